# SPDX-License-Identifier: GPL-3.0-or-later
"""Image texture nodes: projections, filters, UDIM tiles and sequences; environments."""

from .images import ImageUse, sequence_frame, tile_numbers
from .nodes_procedural import coordinate
from .nodes_program import ONE, ZERO, constant

MISSING_IMAGE = constant((1.0, 0.0, 1.0))  # Blender's magenta
FILTERS = {"Linear": 0, "Closest": 1, "Cubic": 2, "Smart": 2}
EXTENSIONS = {"REPEAT": 0, "EXTEND": 1, "CLIP": 2, "MIRROR": 3}


def _uses(c, node, associated):
    """Returns the ImageUse of each tile of a node's image (of its one file where it has no tiles); () where
    it has none (warned). associated: colours are multiplied by alpha."""
    if node.image is None:
        c.warn(node, "has no image; magenta is used")
        return ()
    frame = sequence_frame(node.image, node.image_user, c.context.scene.frame_current)
    return tuple(ImageUse(node.image, associated, frame, tile) for tile in tile_numbers(node.image))


def _number(c, node, use):
    """Returns the number of an image's file in the scene description."""
    return c.context.image_number(use, f"{c.owner}, node '{node.name}'")


def image(c, node, output, path):
    alpha = output.identifier == "Alpha"
    point = coordinate(c, node, path, "uv")
    uses = _uses(c, node, associated=not node.outputs["Alpha"].is_linked)
    if not uses:
        return ONE if alpha else MISSING_IMAGE
    mode = FILTERS[node.interpolation] | EXTENSIONS[node.extension] << 2
    operation = "image_alpha" if alpha else "image"

    def read(place):
        if len(uses) == 1 and uses[0].tile is None:
            return c.emit(operation, place, parameters=(_number(c, node, uses[0]),), mode=mode)
        return _tiles(c, node, uses, place, operation, mode)

    if node.projection == "BOX":
        return _box(c, node, point, read)
    if node.projection != "FLAT":
        point = c.emit(f"{node.projection.lower()}_projection", point)
    return read(point)


def _tiles(c, node, uses, place, operation, mode):
    """Returns what UDIM tiles hold at `place`: of each its part of the plane; magenta where there is none."""
    cell = c.emit("floor", place)
    column, row = c.emit("channel", cell, mode=0), c.emit("channel", cell, mode=1)
    result, covered = ZERO, ZERO
    for use in uses:
        u, v = (use.tile - 1001) % 10, (use.tile - 1001) // 10
        inside = c.emit(
            "multiply",
            c.emit("compare", column, constant(float(u)), ZERO),
            c.emit("compare", row, constant(float(v)), ZERO),
        )
        local = c.emit("subtract", place, constant((float(u), float(v), 0.0)))
        value = c.emit(operation, local, parameters=(_number(c, node, use),), mode=mode)
        result = c.emit("multiply_add", inside, value, result)
        covered = c.emit("add", covered, inside)
    missing = ONE if operation == "image_alpha" else MISSING_IMAGE
    return c.emit("mix", missing, result, covered)


def _box(c, node, point, read):
    """Returns the blend of an image on the faces of a cube."""
    normal = c.emit("normal_object")
    result = ZERO
    for axis in range(3):
        face = c.emit("box_projection", point, normal, parameters=(node.projection_blend,), mode=axis)
        result = c.emit("multiply_add", read(face), c.emit("channel", face, mode=2), result)
    return result


def environment(c, node, output, path):
    point = coordinate(c, node, path, "generated" if c.scope == "world" else "position")
    uses = _uses(c, node, associated=True)
    if not uses:
        return MISSING_IMAGE
    operation = "environment" if node.projection == "EQUIRECTANGULAR" else "environment_mirror_ball"
    return c.emit(operation, point, parameters=(_number(c, node, uses[0]),), mode=FILTERS[node.interpolation])


HANDLERS = {"TEX_IMAGE": image, "TEX_ENVIRONMENT": environment}
