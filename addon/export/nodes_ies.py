# SPDX-License-Identifier: GPL-3.0-or-later
"""IES textures: a picture of the profile over both angles, looked up by direction."""

import math
from pathlib import Path

import bpy
import numpy as np

from .ies import HEIGHT, WIDTH, BadProfile, picture
from .nodes_program import ZERO, constant

EXTEND = 1 << 2  # the image's mode: linear, beyond the edge as there
# Light of 177.83 lm/W, as Cycles takes it; the strength of a lamp is that of one which shines evenly all
# round.
WATTS_PER_CANDELA = 4 * math.pi / 177.83


def profile(node):
    """Returns the text of a node's profile, "" without one. Raises OSError where its file cannot be read."""
    if node.mode == "INTERNAL":
        return node.ies.as_string() if node.ies is not None else ""
    if not node.filepath:
        return ""
    return Path(bpy.path.abspath(node.filepath)).read_text("latin-1")


def ies(c, node, output, path):
    try:
        text = profile(node)
        pixels = picture(text) if text else None
    except (OSError, BadProfile) as fault:
        c.warn(node, f"its profile cannot be read ({fault}); it gives no light. Choose an IES file")
        return ZERO
    if pixels is None:
        c.warn(node, "has no profile; it gives no light")
        return ZERO
    number = c.context.picture_number("IES", text, np.repeat(pixels[..., None], 3, axis=2).astype(np.float32))
    linked = c.is_linked(node, "Vector", path)
    direction = c.emit("normalize", c.input(node, "Vector", path) if linked else c.emit("normal_object"))
    x, y, z = (c.emit("channel", direction, mode=axis) for axis in range(3))
    around = c.emit("add", c.emit("arctan2", x, y), constant(math.pi))
    down = c.emit("arccosine", c.emit("subtract", ZERO, z))
    place = c.emit("combine", _pixel(c, around, 2 * math.pi, WIDTH), _pixel(c, down, math.pi, HEIGHT), ZERO)
    found = c.emit("image", place, parameters=(number,), mode=EXTEND)
    return c.emit(
        "multiply", found, c.emit("multiply", c.input(node, "Strength", path), constant(WATTS_PER_CANDELA))
    )


def _pixel(c, angle, most, count):
    """Returns the texture coordinate of an angle from 0 to `most`: its ends are the middles of the outer
    pixels."""
    return c.emit("multiply_add", angle, constant((count - 1) / count / most), constant(0.5 / count))


HANDLERS = {"TEX_IES": ies}
