# SPDX-License-Identifier: GPL-3.0-or-later
"""Expression nodes of arithmetic: Math, Vector Math, Map Range, Clamp, Mapping, rotation, combine and
separate."""

import math

import numpy as np
from mathutils import Euler

from .nodes_program import ONE, ZERO, constant

SAME_NAME = (
    "ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "POWER", "LOGARITHM", "SQRT", "INVERSE_SQRT",
    "ABSOLUTE", "EXPONENT", "MINIMUM", "MAXIMUM", "LESS_THAN", "GREATER_THAN", "SIGN", "COMPARE",
    "SMOOTH_MIN", "SMOOTH_MAX", "ROUND", "FLOOR", "CEIL", "MODULO", "FLOORED_MODULO", "WRAP", "SNAP",
    "PINGPONG", "SINE", "COSINE", "TANGENT", "ARCSINE", "ARCCOSINE", "ARCTANGENT", "ARCTAN2", "SINH",
    "COSH", "TANH",
)  # fmt: skip
MATH = {name: name.lower() for name in SAME_NAME} | {"TRUNC": "truncate", "FRACT": "fraction"}

UNARY = (
    "sqrt", "inverse_sqrt", "absolute", "exponent", "sign", "round", "floor", "ceil", "truncate",
    "fraction", "sine", "cosine", "tangent", "arcsine", "arccosine", "arctangent", "sinh", "cosh", "tanh",
    "length", "normalize",
)  # fmt: skip
TERNARY = {"multiply_add", "compare", "smooth_min", "smooth_max", "wrap"}
ANGLES = {"RADIANS": math.pi / 180, "DEGREES": 180 / math.pi}


def arity(operation):
    """Returns how many operands an arithmetic operation takes."""
    return 1 if operation in UNARY else 3 if operation in TERNARY else 2


def clamp01(c, value):
    return c.emit("clamp", value, ZERO, ONE)


def math_node(c, node, output, path):
    operands = [c.input(node, name, path) for name in ("Value", "Value_001", "Value_002")]
    if node.operation in ANGLES:
        result = c.emit("multiply", operands[0], constant(ANGLES[node.operation]))
    elif node.operation in MATH:
        operation = MATH[node.operation]
        result = c.emit(operation, *operands[: arity(operation)])
    else:
        c.warn(node, f"operation {node.operation.title()} is not supported; the first value passes")
        result = operands[0]
    return clamp01(c, result) if node.use_clamp else result


VECTOR_SAME_NAME = (
    "ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "ABSOLUTE", "POWER", "SIGN", "MINIMUM",
    "MAXIMUM", "FLOOR", "CEIL", "MODULO", "WRAP", "SNAP", "SINE", "COSINE", "TANGENT",
)  # fmt: skip
VECTOR_MATH = {name: name.lower() for name in VECTOR_SAME_NAME} | {
    "FRACTION": "fraction",
    "CROSS_PRODUCT": "cross",
    "DOT_PRODUCT": "dot",
    "DISTANCE": "distance",
    "LENGTH": "length",
    "NORMALIZE": "normalize",
}


def vector_math(c, node, output, path):
    a, b, third = (c.input(node, name, path) for name in ("Vector", "Vector_001", "Vector_002"))
    if node.operation in VECTOR_MATH:
        operation = VECTOR_MATH[node.operation]
        return c.emit(operation, *(a, b, third)[: arity(operation)])
    scale = c.input(node, "Scale", path)
    special = {
        "SCALE": lambda: c.emit("multiply", a, scale),
        "PROJECT": lambda: c.emit("multiply", b, c.emit("divide", c.emit("dot", a, b), c.emit("dot", b, b))),
        "REFLECT": lambda: _reflect(c, a, c.emit("normalize", b)),
        "REFRACT": lambda: _refract(c, a, c.emit("normalize", b), scale),
        "FACEFORWARD": lambda: _face_forward(c, a, b, third),
    }
    if node.operation not in special:
        c.warn(node, f"operation {node.operation.title()} is not supported; the first vector passes")
        return a
    return special[node.operation]()


def _reflect(c, incident, normal):
    twice = c.emit("multiply", constant(-2.0), c.emit("dot", incident, normal))
    return c.emit("multiply_add", twice, normal, incident)


def _refract(c, incident, normal, eta):
    """GLSL's refract: zero on total internal reflection."""
    cosine = c.emit("dot", incident, normal)
    sine_squared = c.emit("subtract", ONE, c.emit("multiply", cosine, cosine))
    k = c.emit("subtract", ONE, c.emit("multiply", c.emit("multiply", eta, eta), sine_squared))
    along = c.emit("multiply_add", eta, cosine, c.emit("sqrt", k))
    bent = c.emit("subtract", c.emit("multiply", eta, incident), c.emit("multiply", along, normal))
    refracts = c.emit("subtract", ONE, c.emit("less_than", k, ZERO))
    return c.emit("multiply", bent, refracts)


def _face_forward(c, vector, incident, reference):
    """`vector` where reference . incident < 0, else its negative."""
    faces = c.emit("less_than", c.emit("dot", reference, incident), ZERO)
    return c.emit("multiply", vector, c.emit("multiply_add", faces, constant(2.0), constant(-1.0)))


def clamp(c, node, output, path):
    value, low, high = (c.input(node, name, path) for name in ("Value", "Min", "Max"))
    if node.clamp_type == "RANGE":
        low, high = c.emit("minimum", low, high), c.emit("maximum", low, high)
    return c.emit("clamp", value, low, high)


EASING = {"LINEAR": 0, "SMOOTHSTEP": 1, "SMOOTHERSTEP": 2}


def map_range(c, node, output, path):
    vector = node.data_type == "FLOAT_VECTOR"
    suffix = "_FLOAT3" if vector else ""
    value = c.input(node, "Vector" if vector else "Value", path)
    ends = [c.input(node, name + suffix, path) for name in ("From_Min", "From_Max", "To_Min", "To_Max")]
    if not vector:
        ends = [c.input(node, name, path) for name in ("From Min", "From Max", "To Min", "To Max")]
    kind = node.interpolation_type
    if not vector and kind in EASING:
        source, target = (c.emit("combine", low, high, ZERO) for low, high in (ends[:2], ends[2:]))
        result = c.emit("map_range", value, source, target, mode=EASING[kind])
    else:
        steps = c.input(node, "Steps" + suffix, path) if kind == "STEPPED" else None
        result = _map_range_by_parts(c, value, ends, kind, steps)
    if node.clamp and kind in ("LINEAR", "STEPPED"):
        low, high = c.emit("minimum", *ends[2:]), c.emit("maximum", *ends[2:])
        result = c.emit("clamp", result, low, high)
    return result


def _map_range_by_parts(c, value, ends, kind, steps):
    from_min, from_max, to_min, to_max = ends
    t = c.emit("divide", c.emit("subtract", value, from_min), c.emit("subtract", from_max, from_min))
    if kind == "STEPPED":
        t = c.emit("divide", c.emit("floor", c.emit("multiply", t, c.emit("add", steps, ONE))), steps)
    elif kind != "LINEAR":
        t = clamp01(c, t)
        if kind == "SMOOTHSTEP":
            polynomial = c.emit("multiply_add", t, constant(-2.0), constant(3.0))
        else:
            inner = c.emit("multiply_add", t, constant(6.0), constant(-15.0))
            polynomial = c.emit("multiply", t, c.emit("multiply_add", t, inner, constant(10.0)))
        t = c.emit("multiply", c.emit("multiply", t, t), polynomial)
    return c.emit("mix", to_min, to_max, t)


def rotate(c, vector, rotation, inverse=False):
    """Returns `vector` turned by a 3x3 rotation matrix."""
    matrix = np.eye(3, 4)
    matrix[:, :3] = rotation.T if inverse else rotation
    return c.emit("transform", vector, parameters=matrix.ravel(), mode=1)


def rotate_euler(c, vector, angles, inverse=False):
    """Returns `vector` turned by Euler angles in the order XYZ, which need not be constant."""
    if angles.constant is not None:
        return rotate(c, vector, np.array(Euler(angles.constant).to_matrix()), inverse)
    sine, cosine = c.emit("sine", angles), c.emit("cosine", angles)
    if inverse:
        sine = c.emit("multiply", sine, constant(-1.0))
    for axis in reversed(range(3)) if inverse else range(3):
        s, k = c.emit("channel", sine, mode=axis), c.emit("channel", cosine, mode=axis)
        xyz = [c.emit("channel", vector, mode=m) for m in range(3)]
        first, second = (axis + 1) % 3, (axis + 2) % 3
        turned = list(xyz)
        turned[first] = c.emit(
            "subtract", c.emit("multiply", xyz[first], k), c.emit("multiply", xyz[second], s)
        )
        turned[second] = c.emit("multiply_add", xyz[first], s, c.emit("multiply", xyz[second], k))
        vector = c.emit("combine", *turned)
    return vector


def rotate_around(c, vector, axis, angle):
    """Returns `vector` turned around an axis (Rodrigues); unturned where the axis is 0."""
    unit = c.emit("normalize", axis)
    sine, cosine = c.emit("sine", angle), c.emit("cosine", angle)
    along = c.emit("multiply", unit, c.emit("dot", unit, vector))
    flat = c.emit("subtract", vector, along)
    turned = c.emit("multiply_add", flat, cosine, along)
    turned = c.emit("multiply_add", c.emit("cross", unit, vector), sine, turned)
    return c.emit("mix", vector, turned, c.emit("greater_than", c.emit("length", axis), ZERO))


def mapping(c, node, output, path):
    vector, location, rotation, scale = (
        c.input(node, n, path) for n in ("Vector", "Location", "Rotation", "Scale")
    )
    kind = node.vector_type
    if kind == "TEXTURE":
        turned = rotate_euler(c, c.emit("subtract", vector, location), rotation, inverse=True)
        return c.emit("divide", turned, scale)
    if kind == "NORMAL":
        return c.emit("normalize", rotate_euler(c, c.emit("divide", vector, scale), rotation))
    if None not in (scale.constant, location.constant, rotation.constant):
        matrix = np.eye(3, 4)
        matrix[:, :3] = np.array(Euler(rotation.constant).to_matrix()) * np.array(scale.constant)
        matrix[:, 3] = location.constant if kind == "POINT" else 0.0
        return c.emit("transform", vector, parameters=matrix.ravel())
    turned = rotate_euler(c, c.emit("multiply", vector, scale), rotation)
    return c.emit("add", turned, location) if kind == "POINT" else turned


def vector_rotate(c, node, output, path):
    vector, center, axis, angle, euler = (
        c.input(node, name, path) for name in ("Vector", "Center", "Axis", "Angle", "Rotation")
    )
    kind, local = node.rotation_type, c.emit("subtract", vector, center)
    if kind == "EULER_XYZ":
        return c.emit("add", rotate_euler(c, local, euler, node.invert), center)
    if node.invert:
        angle = c.emit("multiply", angle, constant(-1.0))
    if kind != "AXIS_ANGLE":
        axis = constant([float(letter == kind[0]) for letter in "XYZ"])
    return c.emit("add", rotate_around(c, local, axis, angle), center)


def separate(names):
    """Returns the handler of a node that gives the channels of its input, named by outputs in order."""

    def handler(c, node, output, path):
        value = c.value(node.inputs[0], path)
        return c.emit("channel", value, mode=names.index(output.identifier))

    return handler


def combine(c, node, output, path):
    return c.emit("combine", *(c.value(socket, path) for socket in node.inputs[:3]))


HANDLERS = {
    "MATH": math_node,
    "VECT_MATH": vector_math,
    "CLAMP": clamp,
    "MAP_RANGE": map_range,
    "MAPPING": mapping,
    "VECTOR_ROTATE": vector_rotate,
    "SEPXYZ": separate(("X", "Y", "Z")),
    "SEPRGB": separate(("R", "G", "B")),
    "COMBXYZ": combine,
    "COMBRGB": combine,
}
