# SPDX-License-Identifier: GPL-3.0-or-later
"""Procedural texture nodes. Those made of plain arithmetic (wave, magic) become instructions of it."""

import math

from ..opcodes import NOISE_TYPES, VORONOI_FEATURES, VORONOI_METRICS
from .nodes_program import ZERO, constant

HALF = constant(0.5)
DIMENSIONS = {"3D": 0, "2D": 1, "1D": 2, "4D": 3}
NORMALIZE = 2  # bit of the mode of "noise"


def coordinate(c, node, path, otherwise="generated"):
    """Returns the Value of the Vector input; `otherwise` (an operation) where nothing is linked."""
    _check_texture_mapping(c, node)
    if c.is_linked(node, "Vector", path):
        return c.input(node, "Vector", path)
    return c.emit("uv", mode=c.uv("")) if otherwise == "uv" else c.emit(otherwise)


def _check_texture_mapping(c, node):
    """Warns about the old mapping inside a texture node, which no interface shows any more."""
    old = node.texture_mapping
    moved = (tuple(old.translation), tuple(old.rotation), tuple(old.scale)) != (
        (0, 0, 0),
        (0, 0, 0),
        (1, 1, 1),
    )
    if moved or (old.mapping_x, old.mapping_y, old.mapping_z) != ("X", "Y", "Z"):
        c.warn(node, "the node's own texture mapping is not supported; use a Mapping node")


def inputs(c, node, path, *identifiers):
    """Returns the Values of inputs of these identifiers."""
    return [c.input(node, identifier, path) for identifier in identifiers]


def scaled_coordinate(c, node, path):
    return c.emit("multiply", coordinate(c, node, path), c.input(node, "Scale", path))


def lattice_coordinate(c, node, path, dimensions):
    """Returns the point of a texture of "1D" (which is W) to "4D"."""
    return c.input(node, "W", path) if dimensions == "1D" else coordinate(c, node, path)


def checker(c, node, output, path):
    point, scale = coordinate(c, node, path), c.input(node, "Scale", path)
    if output.identifier == "Fac":
        return c.emit("checker_fac", point, ZERO, ZERO, scale)
    return c.emit("checker", point, *inputs(c, node, path, "Color1", "Color2"), scale)


GRADIENTS = ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL")


def gradient(c, node, output, path):
    return c.emit("gradient", coordinate(c, node, path), mode=GRADIENTS.index(node.gradient_type))


def noise(c, node, output, path):
    dimensions, kind = node.noise_dimensions, node.noise_type.lower()
    point = lattice_coordinate(c, node, path, dimensions)
    place = c.emit("combine", *inputs(c, node, path, "Scale", "W", "Offset"))
    fractal = c.emit("combine", *inputs(c, node, path, "Detail", "Roughness", "Lacunarity"))
    bent = c.emit("combine", *inputs(c, node, path, "Distortion", "Gain"), ZERO)
    mode = (output.identifier == "Color") | DIMENSIONS[dimensions] << 2 | NOISE_TYPES.index(kind) << 4
    if kind == "fbm" and node.normalize:
        mode |= NORMALIZE
    return c.emit("noise", point, place, fractal, bent, mode=int(mode))


VORONOI_OUTPUTS = {"Distance": 0, "Radius": 0, "Color": 1, "Position": 2, "W": 3}


def voronoi(c, node, output, path):
    dimensions = node.voronoi_dimensions
    point = lattice_coordinate(c, node, path, dimensions)
    place = c.emit("combine", *inputs(c, node, path, "Scale", "W", "Exponent"))
    fractal = c.emit("combine", *inputs(c, node, path, "Detail", "Roughness", "Lacunarity"))
    cells = c.emit("combine", *inputs(c, node, path, "Smoothness", "Randomness"), ZERO)
    mode = (
        VORONOI_OUTPUTS[output.identifier]
        | DIMENSIONS[dimensions] << 2
        | VORONOI_METRICS.index(node.distance.lower()) << 4
        | bool(node.normalize) << 6
        | VORONOI_FEATURES.index(node.feature.lower()) << 7
    )
    return c.emit("voronoi", point, place, fractal, cells, mode=int(mode))


def white_noise(c, node, output, path):
    dimensions = node.noise_dimensions
    if dimensions == "1D":
        point = c.input(node, "W", path)
    elif c.is_linked(node, "Vector", path):
        point = c.input(node, "Vector", path)
    else:
        point = c.emit("object_coordinate" if c.scope != "material" else "position")
    mode = (output.identifier == "Color") | DIMENSIONS[dimensions] << 1
    return c.emit("white_noise", point, c.input(node, "W", path), mode=int(mode))


GABOR_OUTPUTS = {"Value": 0, "Phase": 1, "Intensity": 2}


def gabor(c, node, output, path):
    waves = c.emit("combine", *inputs(c, node, path, "Frequency", "Anisotropy", "Orientation 2D"))
    mode = GABOR_OUTPUTS[output.identifier] | (node.gabor_type == "3D") << 2
    return c.emit(
        "gabor", scaled_coordinate(c, node, path), waves, c.input(node, "Orientation 3D", path), mode=mode
    )


def brick(c, node, output, path):
    mortar = c.emit("combine", *inputs(c, node, path, "Mortar Size", "Mortar Smooth", "Bias"))
    size = c.emit("combine", *inputs(c, node, path, "Brick Width", "Row Height"), ZERO)
    shape = (node.offset, node.squash, node.offset_frequency, node.squash_frequency)
    wall = c.emit("brick", scaled_coordinate(c, node, path), mortar, size, parameters=shape)
    fac = c.emit("channel", wall, mode=1)
    if output.identifier == "Fac":
        return fac
    first, second, between = inputs(c, node, path, "Color1", "Color2", "Mortar")
    bricks = c.emit("mix", first, second, c.emit("channel", wall, mode=0))
    return c.emit("mix", bricks, between, fac)


# --- Wave and magic


def wave(c, node, output, path):
    # moves faces that lie exactly on a lattice plane off it
    point = c.emit(
        "multiply_add", scaled_coordinate(c, node, path), constant(0.999999), constant(0.999999e-6)
    )
    distortion, phase = inputs(c, node, path, "Distortion", "Phase Offset")
    argument = c.emit("add", _wave_argument(c, node, point), phase)
    if not distortion.is_zero:
        fractal = c.emit("combine", *inputs(c, node, path, "Detail", "Detail Roughness"), constant(2.0))
        place = c.emit("combine", c.input(node, "Detail Scale", path), ZERO, ZERO)
        bent = c.emit("noise", point, place, fractal, ZERO, mode=NORMALIZE)
        bent = c.emit("multiply_add", bent, constant(2.0), constant(-1.0))
        argument = c.emit("multiply_add", distortion, bent, argument)
    return _wave_value(c, node.wave_profile, argument)


def _wave_argument(c, node, point):
    twenty = constant(20.0)
    if node.wave_type == "BANDS":
        if node.bands_direction == "DIAGONAL":
            return c.emit("dot", point, constant(10.0))
        return c.emit("multiply", c.emit("channel", point, mode="XYZ".index(node.bands_direction)), twenty)
    if node.rings_direction != "SPHERICAL":
        across = [float(axis != node.rings_direction) for axis in "XYZ"]
        point = c.emit("multiply", point, constant(across))
    return c.emit("multiply", c.emit("length", point), twenty)


def _wave_value(c, profile, argument):
    if profile == "SIN":
        sine = c.emit("sine", c.emit("subtract", argument, constant(math.pi / 2)))
        return c.emit("multiply_add", sine, HALF, HALF)
    turns = c.emit("multiply", argument, constant(0.5 / math.pi))
    if profile == "SAW":
        return c.emit("fraction", turns)
    return c.emit(
        "multiply", c.emit("absolute", c.emit("subtract", turns, c.emit("round", turns))), constant(2.0)
    )


# How each step of Magic Texture after the first replaces one of x, y and z: (which, function, its sign,
# signs of x, y and z in its argument).
MAGIC_STEPS = (
    (0, "cosine", 1, (1, -1, -1)),
    (2, "sine", 1, (-1, -1, -1)),
    (0, "cosine", -1, (-1, 1, -1)),
    (1, "sine", -1, (-1, 1, 1)),
    (1, "cosine", -1, (-1, 1, 1)),
    (0, "cosine", 1, (1, 1, 1)),
    (2, "sine", 1, (1, 1, -1)),
    (0, "cosine", -1, (-1, -1, 1)),
    (1, "sine", -1, (1, -1, 1)),
)


def magic(c, node, output, path):
    distortion, scale = inputs(c, node, path, "Distortion", "Scale")
    point = c.emit("modulo", coordinate(c, node, path), constant(2 * math.pi))
    point = c.emit("multiply", point, c.emit("multiply", scale, constant(5.0)))

    def turned(function, sign, vector, signs):
        return c.emit(
            "multiply", c.emit(function, c.emit("dot", vector, constant(signs))), constant(float(sign))
        )

    first = (("sine", 1, (1, 1, 1)), ("cosine", 1, (-1, 1, -1)), ("cosine", -1, (-1, -1, 1)))
    xyz = [turned(function, sign, point, signs) for function, sign, signs in first]
    depth = node.turbulence_depth
    if depth > 0:
        xyz = [c.emit("multiply", value, distortion) for value in xyz]
        steps = ((1, "cosine", -1, (1, -1, 1)), *MAGIC_STEPS)
        for axis, function, sign, signs in steps[:depth]:
            xyz[axis] = c.emit("multiply", turned(function, sign, c.emit("combine", *xyz), signs), distortion)
    color = c.emit("combine", *xyz)
    twice = c.emit("multiply", distortion, constant(2.0))
    halved = c.emit(
        "mix", color, c.emit("divide", color, twice), c.emit("absolute", c.emit("sign", distortion))
    )
    color = c.emit("subtract", HALF, halved)
    return c.emit("average", color) if output.identifier == "Fac" else color


HANDLERS = {
    "TEX_CHECKER": checker,
    "TEX_GRADIENT": gradient,
    "TEX_NOISE": noise,
    "TEX_VORONOI": voronoi,
    "TEX_WHITE_NOISE": white_noise,
    "TEX_GABOR": gabor,
    "TEX_BRICK": brick,
    "TEX_WAVE": wave,
    "TEX_MAGIC": magic,
}
