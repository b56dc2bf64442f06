# SPDX-License-Identifier: GPL-3.0-or-later
"""OpenEXR files: writing passes as Blender's multilayer files do, and reading those of any renderer.

Writes one part of scan lines, ZIP, float32, channels named ViewLayer.Pass.Channel. The display window is the
full frame, the data window what was rendered. Reads single and multi-part files, with or without layer names.
"""

from pathlib import Path

import numpy as np
import OpenEXR

from . import noise, passes
from .errors import InputError
from .output import atomic

CHANNEL_ORDER = "RGBAXYZWUV"  # how the channels of a pass are sorted in memory


def write(path, images, film, layer="ViewLayer", attributes=None, metadata=None):
    """Writes `images`, a dict of pass name -> (h, w, channels) float32 with the bottom row first, to `path`.

    film: description.Film that they were rendered with. attributes: dict of text for the header, each name
    prefixed with "nephele/". metadata: more of the same, by their whole names. Raises InputError where
    the file cannot be written.
    """
    channels = {}
    for name, pixels in images.items():
        for index, letter in enumerate(passes.lookup(name).channels):
            channels[f"{layer}.{name}.{letter}"] = np.ascontiguousarray(pixels[::-1, :, index], np.float32)
    x0, y0, x1, y1 = film.crop or (0, 0, film.width, film.height)
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        # Windows are inclusive and count rows from the top.
        "displayWindow": window(0, 0, film.width, film.height),
        "dataWindow": window(x0, film.height - y1, x1, film.height - y0),
    }
    header |= {f"nephele/{key}": value for key, value in (attributes or {}).items()}
    header |= metadata or {}
    with atomic(path) as temporary, OpenEXR.File(header, channels) as file:
        try:
            file.write(str(temporary))
        except RuntimeError as error:
            raise InputError(f"{path}: cannot be written: {error}") from error


def window(x0, y0, x1, y1):
    """Returns OpenEXR's box of the pixels from (x0, y0) up to but not including (x1, y1)."""
    return np.array([x0, y0], np.int32), np.array([x1 - 1, y1 - 1], np.int32)


def open_file(path):
    """Returns an OpenEXR.File with every channel by itself. Raises InputError where there is none to read."""
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    try:
        return OpenEXR.File(str(path), separate_channels=True)
    except (RuntimeError, ValueError) as error:
        raise InputError(f"{path}: not an OpenEXR file, or damaged: {error}") from error


def read(path):
    """Returns a dict of pass name -> (channel letters, (h, w, channels) float32 with the top row first).

    The layer's name is left out of the pass's where the file has only one layer; channels without any name
    make the pass Combined. Raises InputError naming the file.
    """
    groups = {}
    # The library prints a fault of the pixels, drops the part and goes on.
    with noise.hidden(), open_file(path) as file, OpenEXR.File(str(path), header_only=True) as headers:
        if len(file.parts) != len(headers.parts):
            raise InputError(f"{path}: damaged; its pixels cannot be read to the end")
        for part in file.parts:
            part_name = part.name() if len(file.parts) > 1 else ""
            for name, channel in part.channels.items():
                full_name = name if "." in name or not part_name else f"{part_name}.{name}"
                prefix, _, letter = full_name.rpartition(".")
                layer, _, pass_name = prefix.rpartition(".")
                groups.setdefault((layer, pass_name or "Combined"), {})[letter] = np.asarray(
                    channel.pixels, np.float32
                )
    single = len({layer for layer, _ in groups}) == 1
    return {
        name if single or not layer else f"{layer}.{name}": stacked(path, name, letters)
        for (layer, name), letters in groups.items()
    }


def stacked(path, name, letters):
    """Returns (letters in order, (h, w, channels) array) of a dict letter -> (h, w) array."""

    def place(letter):
        return (CHANNEL_ORDER.find(letter.upper()) % len(CHANNEL_ORDER), letter)  # cryptomattes have rgba

    order = sorted(letters, key=place)
    if len({letters[letter].shape for letter in order}) != 1:
        raise InputError(f"{path}: channels of pass {name} differ in size")
    return "".join(order), np.stack([letters[letter] for letter in order], axis=-1)


def read_attributes(path):
    """Returns the header's texts that write() stored, without their prefix. Raises InputError naming the
    file."""
    with open_file(path) as file:
        return {
            key[len("nephele/") :]: value
            for key, value in file.header().items()
            if key.startswith("nephele/")
        }
