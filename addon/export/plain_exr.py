# SPDX-License-Identifier: GPL-3.0-or-later
"""The simplest OpenEXR file there is: one part, scan lines, four channels of 32 bits, uncompressed. Blender's
Python has no OpenEXR, and Blender's own writing of images would convert their colours.

After "OpenEXR File Layout" (openexr.com): magic, version, attributes, offset table, lines from the top.
"""

import struct
from pathlib import Path

import numpy as np

MAGIC, VERSION, FLOAT = 20000630, 2, 2
CHANNELS = "ABGR"  # in the order of the alphabet, as the file has to have them


def write_rgba(path, pixels):
    """Writes (h, w, 4) float32 pixels, top row first."""
    height, width = pixels.shape[:2]
    line = np.dtype([("y", "<i4"), ("bytes", "<i4"), ("channels", "<f4", (4, width))])
    lines = np.empty(height, line)
    lines["y"], lines["bytes"] = np.arange(height), 16 * width
    lines["channels"] = pixels[..., ::-1].transpose(0, 2, 1)
    head = _header(width, height)
    offsets = len(head) + 8 * height + line.itemsize * np.arange(height, dtype="<u8")
    with Path(path).open("wb") as file:
        file.write(head + offsets.astype("<u8").tobytes())
        lines.tofile(file)


def _header(width, height):
    box = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channels = b"".join(struct.pack("<2siB3x2i", c.encode(), FLOAT, 0, 1, 1) for c in CHANNELS) + b"\0"
    attributes = (
        ("channels", "chlist", channels),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", box),
        ("displayWindow", "box2i", box),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    )
    found = struct.pack("<2i", MAGIC, VERSION)
    for name, kind, value in attributes:
        found += f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value
    return found + b"\0"
