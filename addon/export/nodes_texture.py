# SPDX-License-Identifier: GPL-3.0-or-later
"""Texture nodes: image, environment, checker, noise and gradient."""

from .nodes_program import ONE, ZERO, constant

MISSING_IMAGE = constant((1.0, 0.0, 1.0))  # Blender's magenta
EXTENSIONS = {"REPEAT": 0, "EXTEND": 1, "CLIP": 2, "MIRROR": 3}


def _coordinate(c, node, path, otherwise):
    """Returns the Value of the Vector input; `otherwise` (an operation) where nothing is linked."""
    _check_texture_mapping(c, node)
    if c.is_linked(node, "Vector", path):
        return c.input(node, "Vector", path)
    return c.emit("uv", mode=c.uv("")) if otherwise == "uv" else c.emit(otherwise)


def _check_texture_mapping(c, node):
    """Warns about the old mapping inside a texture node, which no interface shows any more."""
    old = node.texture_mapping
    neutral = (tuple(old.translation), tuple(old.rotation), tuple(old.scale)) == (
        (0, 0, 0),
        (0, 0, 0),
        (1, 1, 1),
    )
    if not neutral or (old.mapping_x, old.mapping_y, old.mapping_z) != ("X", "Y", "Z"):
        c.warn(node, "the node's own texture mapping is not supported; use a Mapping node")


def _image_number(c, node):
    """Returns the image's number in the scene description, or None (warned)."""
    if node.image is None:
        c.warn(node, "has no image; magenta is used")
        return None
    return c.context.image_number(node.image, f"{c.owner}, node '{node.name}'")


def image(c, node, output, path):
    alpha = output.identifier == "Alpha"
    coordinate = _coordinate(c, node, path, "uv")
    number = _image_number(c, node)
    if number is None:
        return ONE if alpha else MISSING_IMAGE
    if node.projection != "FLAT":
        c.warn(node, f"{node.projection.title()} projection is not supported; Flat is used")
    if node.interpolation not in ("Linear", "Closest"):
        c.warn(node, f"{node.interpolation} interpolation is not supported; Linear is used")
    mode = (node.interpolation == "Closest") | EXTENSIONS[node.extension] << 1
    return c.emit("image_alpha" if alpha else "image", coordinate, parameters=(number,), mode=int(mode))


def environment(c, node, output, path):
    coordinate = _coordinate(c, node, path, "generated" if c.scope == "world" else "position")
    number = _image_number(c, node)
    if number is None:
        return MISSING_IMAGE
    if node.interpolation != "Linear":
        c.warn(node, f"{node.interpolation} interpolation is not supported; Linear is used")
    operation = "environment" if node.projection == "EQUIRECTANGULAR" else "environment_mirror_ball"
    return c.emit(operation, coordinate, parameters=(number,))


def checker(c, node, output, path):
    coordinate, scale = _coordinate(c, node, path, "generated"), c.input(node, "Scale", path)
    if output.identifier == "Fac":
        return c.emit("checker_fac", coordinate, ZERO, ZERO, scale)
    return c.emit("checker", coordinate, c.input(node, "Color1", path), c.input(node, "Color2", path), scale)


DIMENSIONS = {"3D": 0, "2D": 1, "1D": 2}


def noise(c, node, output, path):
    dimensions = node.noise_dimensions
    if node.noise_type != "FBM":
        c.warn(node, f"noise of type {node.noise_type.title()} is not supported; fBM is used")
    if dimensions == "4D":
        c.warn(node, "4D noise is not supported; 3D is used, W is left out")
        dimensions = "3D"
    coordinate = c.input(node, "W", path) if dimensions == "1D" else _coordinate(c, node, path, "generated")
    fractal = c.emit(
        "combine", *(c.input(node, name, path) for name in ("Detail", "Roughness", "Lacunarity"))
    )
    mode = (output.identifier == "Color") | node.normalize << 1 | DIMENSIONS[dimensions] << 2
    scale, distortion = c.input(node, "Scale", path), c.input(node, "Distortion", path)
    return c.emit("noise", coordinate, scale, fractal, distortion, mode=int(mode))


GRADIENTS = ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL")


def gradient(c, node, output, path):
    return c.emit(
        "gradient", _coordinate(c, node, path, "generated"), mode=GRADIENTS.index(node.gradient_type)
    )


HANDLERS = {
    "TEX_IMAGE": image,
    "TEX_ENVIRONMENT": environment,
    "TEX_CHECKER": checker,
    "TEX_NOISE": noise,
    "TEX_GRADIENT": gradient,
}
