# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that make normals and tangents: normal maps, bump, displacement (as bump), tangents, spaces of
vectors.

Bump compiles its height three times: at the point and one step beside it along either axis of the tangent
plane (opcodes.py, SHIFT); only what reads the point is computed anew."""

from ..opcodes import SPACES
from .nodes_program import ONE, ZERO, constant

POINT, VECTOR, NORMAL = range(3)
FILTER_WIDTH = 0.1  # of Blender before the node had the socket, and of displacement, in pixels


def convert_space(c, value, source, target, kind):
    """Returns a vector taken from one space of opcodes.SPACES to another. kind: POINT, VECTOR or NORMAL."""
    if source == target:
        return value
    mode = SPACES.index(source) | SPACES.index(target) << 2 | kind << 4
    return c.emit("convert_space", value, mode=mode)


def vector_transform(c, node, output, path):
    spaces = node.convert_from.lower(), node.convert_to.lower()
    kind = ("POINT", "VECTOR", "NORMAL").index(node.vector_type)
    return convert_space(c, c.input(node, "Vector", path), *spaces, kind)


def normal_input(c, node, identifier, path):
    """Returns the Value of a normal input; where nothing is linked the normal that displacement leaves, or
    None (the shading normal)."""
    return c.input(node, identifier, path) if c.is_linked(node, identifier, path) else c.default_normal


def normal_or_shading(c, node, path):
    normal = normal_input(c, node, "Normal", path)
    return c.emit("normal") if normal is None else normal


def normal_map(c, node, output, path):
    color, strength = c.input(node, "Color", path), c.input(node, "Strength", path)
    if node.space == "TANGENT":
        return c.emit("normal_map", color, strength, mode=c.uv(node.uv_map))
    mapped = c.emit("multiply_add", color, constant(2.0), constant(-1.0))
    if node.space.startswith("BLENDER_"):  # as older Blenders baked them
        mapped = c.emit("multiply", mapped, constant((1.0, -1.0, -1.0)))
    if node.space.endswith("OBJECT"):
        mapped = convert_space(c, mapped, "object", "world", NORMAL)
    mapped = c.emit("normalize", mapped)
    backwards = c.emit(
        "multiply_add", c.emit("backfacing"), constant(-2.0), ONE
    )  # the map belongs to the front
    shading = c.emit("normal")
    return c.emit(
        "normalize", c.emit("mix", shading, c.emit("multiply", mapped, backwards), _positive(c, strength))
    )


def _positive(c, value):
    return c.emit("maximum", value, ZERO)


def bump(c, node, output, path):
    normal = normal_or_shading(c, node, path)
    if not c.is_linked(node, "Height", path) or c.scope != "material":
        return normal
    width = c.input(node, "Filter Width", path, missing=FILTER_WIDTH)
    if width.constant is None:
        c.warn(node, f"a filter width that is not constant is not supported; {FILTER_WIDTH} is used")
        width = constant(FILTER_WIDTH)
    distance = c.input(node, "Distance", path)
    if node.invert:
        distance = c.emit("multiply", distance, constant(-1.0))
    height = c.socket(node, "Height")
    return bent(c, lambda: c.value(height, path), c.input(node, "Strength", path), distance, width, normal)


def bent(c, height, strength, distance, width, normal):
    """Returns the Value of `normal` bent by a height. height: function that compiles and returns its
    Value."""
    if c.shift:  # the heights of a bump inside a bump's height: no second step
        return normal
    heights = [c.shifted(axis, width.constant[0], height) for axis in range(3)]
    if heights[0] == heights[1] == heights[2]:
        return normal
    settings = c.emit("combine", strength, distance, width)
    return c.emit("bump", c.emit("combine", *heights), settings, normal)


# --- Displacement, as bump


def displacement(c, node, output, path):
    """Displacement: the normal times the height, in world space."""
    height, middle, scale = (c.input(node, name, path) for name in ("Height", "Midlevel", "Scale"))
    amount = c.emit("multiply", c.emit("subtract", height, middle), scale)
    normal = normal_or_shading(c, node, path)
    if node.space == "WORLD":
        return c.emit("multiply", c.emit("normalize", normal), amount)
    local = c.emit("normalize", convert_space(c, normal, "world", "object", NORMAL))
    return convert_space(c, c.emit("multiply", local, amount), "object", "world", VECTOR)


def vector_displacement(c, node, output, path):
    vector, middle, scale = (c.input(node, name, path) for name in ("Vector", "Midlevel", "Scale"))
    moved = c.emit("multiply", c.emit("subtract", vector, middle), scale)
    if node.space == "WORLD":
        return moved
    if node.space == "TANGENT":
        normal = c.emit("normalize", convert_space(c, c.emit("normal"), "world", "object", NORMAL))
        tangent = c.emit(
            "normalize", convert_space(c, c.emit("uv_tangent", mode=c.uv("")), "world", "object", VECTOR)
        )
        across = c.emit("normalize", c.emit("cross", normal, tangent))
        along = [c.emit("channel", moved, mode=k) for k in range(3)]
        moved = c.emit("multiply", tangent, along[0])
        moved = c.emit("multiply_add", normal, along[1], moved)
        moved = c.emit("multiply_add", across, along[2], moved)
    return convert_space(c, moved, "object", "world", VECTOR)


def displaced_normal(c, socket):
    """Returns the Value of the shading normal bent as displacement through `socket` of the output bends
    it."""
    normal = c.emit("normal")
    return bent(
        c, lambda: c.emit("dot", c.value(socket, ()), normal), ONE, ONE, constant(FILTER_WIDTH), normal
    )


# --- Tangents


def radial_tangent(c, axis):
    """Returns the tangent of circles around an axis of the object's box: 0 x, 1 y, 2 z."""
    centered = c.emit("subtract", c.emit("generated"), constant(0.5))
    x, y, z = (c.emit("channel", centered, mode=k) for k in range(3))
    minus = [c.emit("multiply", value, constant(-1.0)) for value in (x, y, z)]
    around = ((ZERO, minus[2], y), (minus[2], ZERO, x), (minus[1], x, ZERO))[axis]
    direction = convert_space(c, c.emit("combine", *around), "object", "world", NORMAL)
    normal = c.emit("normal")
    return c.emit("cross", normal, c.emit("normalize", c.emit("cross", direction, normal)))


def tangent(c, node, output, path):
    if node.direction_type == "RADIAL":
        return radial_tangent(c, "XYZ".index(node.axis))
    return c.emit("uv_tangent", mode=c.uv(node.uv_map))


def normal(c, node, output, path):
    direction = constant(tuple(node.outputs["Normal"].default_value))
    if output.identifier == "Normal":
        return c.emit("normalize", direction)
    return c.emit(
        "dot", c.emit("normalize", direction), c.emit("normalize", normal_or_shading(c, node, path))
    )


def bevel(c, node, output, path):
    c.warn(node, "bevel is not supported; the normal stays as it is")
    return normal_or_shading(c, node, path)


HANDLERS = {
    "VECT_TRANSFORM": vector_transform,
    "NORMAL_MAP": normal_map,
    "BUMP": bump,
    "DISPLACEMENT": displacement,
    "VECTOR_DISPLACEMENT": vector_displacement,
    "TANGENT": tangent,
    "NORMAL": normal,
    "BEVEL": bevel,
}
