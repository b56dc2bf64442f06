# SPDX-License-Identifier: GPL-3.0-or-later
"""The node compiler: expression nodes, compiled in whole materials and run in numpy."""

import math

import numpy as np
import pytest
from nephele import opcodes
from programs import POINT, Tree


@pytest.fixture
def tree(bpy):
    return Tree(bpy)


@pytest.fixture
def position(tree):
    return tree.node("ShaderNodeNewGeometry").outputs["Position"]


A, B, C = 1.3, -0.7, 0.4
MATH = {
    "ADD": A + B, "SUBTRACT": A - B, "MULTIPLY": A * B, "DIVIDE": A / B, "MULTIPLY_ADD": A * B + C,
    "POWER": A**B, "LOGARITHM": 0.0, "SQRT": A**0.5, "INVERSE_SQRT": A**-0.5, "ABSOLUTE": A,
    "EXPONENT": math.exp(A), "MINIMUM": B, "MAXIMUM": A, "LESS_THAN": 0.0, "GREATER_THAN": 1.0, "SIGN": 1.0,
    "COMPARE": 0.0, "SMOOTH_MIN": B, "SMOOTH_MAX": A, "ROUND": 1.0, "FLOOR": 1.0, "CEIL": 2.0, "TRUNC": 1.0,
    "FRACT": 0.3, "MODULO": 0.6, "FLOORED_MODULO": -0.1, "SNAP": 1.4, "PINGPONG": 0.1,
    "SINE": math.sin(A), "COSINE": math.cos(A), "TANGENT": math.tan(A), "ARCSINE": math.pi / 2,
    "ARCCOSINE": 0.0, "ARCTANGENT": math.atan(A), "ARCTAN2": math.atan2(A, B), "SINH": math.sinh(A),
    "COSH": math.cosh(A), "TANH": math.tanh(A), "RADIANS": math.radians(A), "DEGREES": math.degrees(A),
    "WRAP": -0.7 + (2.0 % 1.1),
}  # fmt: skip


@pytest.mark.parametrize("operation", MATH)
@pytest.mark.parametrize("folded", [True, False])
def test_math(tree, operation, folded):
    """Every operation of the Math node, computed while compiling and while running."""
    first = A if folded else tree.node("ShaderNodeObjectInfo").outputs["Random"]
    third = B if operation == "WRAP" else C
    second = C if operation == "WRAP" else B
    node = tree.node("ShaderNodeMath", {0: first, 1: second, 2: third}, operation=operation)
    expected = MATH[operation]
    result = tree.color(node.outputs[0], {"object_random": np.full(3, A)})
    assert result == pytest.approx([expected] * 3, abs=1e-5)
    assert tree.warnings == []


def test_every_math_operation_is_covered(tree):
    items = tree.node("ShaderNodeMath").bl_rna.properties["operation"].enum_items
    assert set(items.keys()) == set(MATH)


P = POINT["position"]
V = np.array((0.5, 2.0, -0.25))
VECTOR_MATH = {
    "ADD": P + V, "SUBTRACT": P - V, "MULTIPLY": P * V, "DIVIDE": P / V, "CROSS_PRODUCT": np.cross(P, V),
    "PROJECT": V * (P @ V) / (V @ V), "REFLECT": P - 2 * (P @ V) / (V @ V) * V, "DOT_PRODUCT": [P @ V] * 3,
    "DISTANCE": [np.linalg.norm(P - V)] * 3, "LENGTH": [np.linalg.norm(P)] * 3,
    "NORMALIZE": P / np.linalg.norm(P), "ABSOLUTE": np.abs(P), "MINIMUM": np.minimum(P, V),
    "MAXIMUM": np.maximum(P, V), "FLOOR": np.floor(P), "CEIL": np.ceil(P), "FRACTION": P - np.floor(P),
    "MODULO": np.fmod(P, V), "SNAP": np.floor(P / V) * V, "SINE": np.sin(P), "COSINE": np.cos(P),
    "TANGENT": np.tan(P), "SCALE": P * 3, "MULTIPLY_ADD": P * V + 1,
    "FACEFORWARD": P if np.sum(V) < 0 else -P, "SIGN": np.sign(P), "POWER": [0.3**0.5, 0.49, 1.9**-0.25],
}  # fmt: skip


@pytest.mark.parametrize("operation", VECTOR_MATH)
def test_vector_math(tree, position, operation):
    node = tree.node("ShaderNodeVectorMath", operation=operation)
    tree.link(position, node.inputs[0])
    node.inputs[1].default_value = V
    node.inputs[2].default_value = (1, 1, 1)
    if operation == "SCALE":
        node.inputs["Scale"].default_value = 3
    output = next(socket for socket in node.outputs if socket.enabled)
    assert tree.color(output) == pytest.approx(np.array(VECTOR_MATH[operation]), abs=1e-5)
    assert tree.warnings == []


def test_refract_is_snells_law(tree, position):
    node = tree.node("ShaderNodeVectorMath", {0: position}, operation="REFRACT")
    node.inputs[1].default_value = (0, 0, 1)
    node.inputs["Scale"].default_value = 1 / 1.5
    angle = math.radians(40)
    result = tree.color(node.outputs[0], {"position": np.array((math.sin(angle), 0, -math.cos(angle)))})
    assert result[0] == pytest.approx(math.sin(angle) / 1.5)
    assert np.linalg.norm(result) == pytest.approx(1)
    node.inputs["Scale"].default_value = 3.0  # total internal reflection
    assert (
        tree.color(node.outputs[0], {"position": np.array((math.sin(angle), 0, -math.cos(angle)))}).max() == 0
    )


def test_implicit_conversions(tree, position):
    average = tree.node("ShaderNodeMath", {0: position, 1: 0.0}, operation="ADD")
    assert tree.color(average.outputs[0]) == pytest.approx([P.mean()] * 3)
    mix = tree.node("ShaderNodeMix", data_type="RGBA")
    tree.link(position, mix.inputs[6])
    mix.inputs[0].default_value = 0.0
    luminance = tree.node("ShaderNodeMath", {0: mix.outputs[2], 1: 0.0}, operation="ADD")
    assert tree.color(luminance.outputs[0]) == pytest.approx([P @ (0.2126, 0.7152, 0.0722)] * 3)


@pytest.mark.parametrize("kind", ["POINT", "TEXTURE", "VECTOR", "NORMAL"])
def test_mapping(tree, position, kind):
    from mathutils import Euler, Matrix, Vector

    node = tree.node("ShaderNodeMapping", vector_type=kind)
    tree.link(position, node.inputs[0])
    if kind in ("POINT", "TEXTURE"):
        node.inputs["Location"].default_value = (1, 2, 3)
    node.inputs["Rotation"].default_value = (0.1, 0.2, 0.3)
    node.inputs["Scale"].default_value = (2, 3, 0.5)
    turn, scale = Euler((0.1, 0.2, 0.3)).to_matrix(), Matrix.Diagonal((2, 3, 0.5))
    point = Vector(P)
    expected = {
        "POINT": turn @ scale @ point + Vector((1, 2, 3)),
        "TEXTURE": (turn @ scale).inverted() @ (point - Vector((1, 2, 3))),
        "VECTOR": turn @ scale @ point,
        "NORMAL": (turn @ scale.inverted() @ point).normalized(),
    }[kind]
    assert tree.color(node.outputs[0]) == pytest.approx(list(expected), abs=1e-5)


def test_mapping_with_a_location_that_varies(tree, position):
    node = tree.node("ShaderNodeMapping", {"Vector": position, "Location": position})
    node.inputs["Rotation"].default_value = (0, 0, math.pi / 2)
    assert tree.color(node.outputs[0]) == pytest.approx((P[0] - P[1], P[1] + P[0], 2 * P[2]), abs=1e-5)


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [
        ("LINEAR", 0.5, 15.0),
        ("LINEAR", 9.0, 20.0),
        ("STEPPED", 0.6, 10 + 10 * 3 / 4),
        ("SMOOTHSTEP", 0.25, 10 + 10 * 0.25**2 * 2.5),
        ("SMOOTHERSTEP", 0.25, 10 + 10 * (0.25**3 * (0.25 * (0.25 * 6 - 15) + 10))),
    ],
)
@pytest.mark.parametrize("vector", [False, True])
def test_map_range(tree, position, kind, value, expected, vector):
    node = tree.node(
        "ShaderNodeMapRange", interpolation_type=kind, data_type="FLOAT_VECTOR" if vector else "FLOAT"
    )
    settings = {"From Min": 0.0, "From Max": 1.0, "To Min": 10.0, "To Max": 20.0, "Steps": 4.0}
    for socket in node.inputs:
        if socket.enabled and socket.name in settings:
            socket.default_value = [settings[socket.name]] * 3 if vector else settings[socket.name]
    tree.link(position, next(s for s in node.inputs if s.enabled))
    output = next(s for s in node.outputs if s.enabled)
    assert tree.color(output, {"position": np.full(3, value)}) == pytest.approx([expected] * 3, abs=1e-4)


@pytest.mark.parametrize("mode", ["RGB", "HSV", "HSL"])
def test_separate_and_combine_are_inverse(tree, position, mode):
    separate = tree.node("ShaderNodeSeparateColor", {0: position}, mode=mode)
    combine = tree.node("ShaderNodeCombineColor", dict(enumerate(separate.outputs)), mode=mode)
    point = {"position": np.array((0.2, 0.7, 0.4))}
    assert tree.color(combine.outputs[0], point) == pytest.approx((0.2, 0.7, 0.4), abs=1e-5)


def test_mix_clamps_factor_and_result(tree, position):
    node = tree.node("ShaderNodeMix", data_type="RGBA", clamp_factor=True, clamp_result=False)
    node.inputs[0].default_value = 1.0
    node.inputs[6].default_value, node.inputs[7].default_value = (0, 0, 0, 1), (3, 3, 3, 1)
    tree.link(position, node.inputs[0])
    assert tree.color(node.outputs[2], {"position": np.full(3, 5.0)}) == pytest.approx([3] * 3)
    node.clamp_factor, node.clamp_result = False, True
    assert tree.color(node.outputs[2], {"position": np.full(3, 0.2)}) == pytest.approx([0.6] * 3)
    assert tree.color(node.outputs[2], {"position": np.full(3, 5.0)}) == pytest.approx([1] * 3)


def test_legacy_mix(tree, position):
    node = tree.node("ShaderNodeMixRGB", {"Fac": 0.25, "Color1": position}, blend_type="ADD")
    node.inputs["Color2"].default_value = (1, 2, 3, 1)
    assert tree.color(node.outputs[0]) == pytest.approx(P + 0.25 * np.array((1, 2, 3)))


@pytest.mark.parametrize("interpolation", ["LINEAR", "EASE", "CONSTANT", "B_SPLINE", "CARDINAL"])
def test_color_ramp(tree, position, interpolation):
    node = tree.node("ShaderNodeValToRGB", {0: position})
    ramp = node.color_ramp
    ramp.interpolation = interpolation
    ramp.elements[0].color, ramp.elements[1].color = (0, 0, 0.1, 1), (1, 0.5, 0, 0)
    ramp.elements.new(0.4).color = (0.2, 1, 0.3, 0.5)
    for x in (0.0, 0.1, 0.399, 0.401, 0.7, 0.999, 1.0, -1.0, 2.0):
        point = {"position": np.full(3, x)}
        color = tree.color(node.outputs["Color"], point)
        assert color == pytest.approx(ramp.evaluate(x)[:3], abs=0.005), x
        assert tree.color(node.outputs["Alpha"], point) == pytest.approx(
            [ramp.evaluate(x)[3]] * 3, abs=0.005
        ), x


@pytest.mark.parametrize("extend", ["HORIZONTAL", "EXTRAPOLATED"])
def test_rgb_curves(tree, position, extend):
    node = tree.node("ShaderNodeRGBCurve", {"Color": position, "Fac": 0.5})
    mapping = node.mapping
    mapping.extend = extend
    mapping.curves[0].points.new(0.5, 0.8)
    mapping.curves[3].points.new(0.3, 0.2)
    mapping.update()
    mapping.initialize()
    for x in (-0.5, 0.0, 0.2, 0.55, 1.0, 1.5):
        curved = [mapping.evaluate(c, mapping.evaluate(mapping.curves[3], x)) for c in mapping.curves[:3]]
        result = tree.color(node.outputs[0], {"position": np.full(3, x)})
        assert result == pytest.approx([(x + y) / 2 for y in curved], abs=0.01), x


def test_float_curve(tree, position):
    node = tree.node("ShaderNodeFloatCurve", {"Value": position})
    node.mapping.curves[0].points.new(0.5, 0.9)
    node.mapping.update()
    node.mapping.initialize()
    expected = node.mapping.evaluate(node.mapping.curves[0], 0.25)
    assert tree.color(node.outputs[0], {"position": np.full(3, 0.25)}) == pytest.approx(
        [expected] * 3, abs=0.005
    )


def test_texture_coordinate_of_another_object(bpy, tree, link):
    target = link("Target", None)
    target.location, target.scale = (1, 0, 0), (2, 2, 2)
    node = tree.node("ShaderNodeTexCoord", object=target)
    assert tree.color(node.outputs["Object"]) == pytest.approx((P - (1, 0, 0)) / 2, abs=1e-6)


def test_light_path(tree):
    node = tree.node("ShaderNodeLightPath")
    seen = []
    tree.color(node.outputs["Is Camera Ray"], {"ray_is": lambda o, p, mode: seen.append(mode) or np.ones(3)})
    tree.color(
        node.outputs["Is Reflection Ray"], {"ray_is": lambda o, p, mode: seen.append(mode) or np.ones(3)}
    )
    assert seen == [0b000001, 0b000110]
    tree.color(
        node.outputs["Ray Length"], {"ray_history": lambda o, p, mode: seen.append(mode) or np.ones(3)}
    )
    assert seen[2:] == [opcodes.RAY_HISTORY.index("length")]
    assert tree.warnings == []


def test_registers_do_not_depend_on_the_process(bpy):
    """The same tree must compile to the same program in every process, or an interrupted render would not
    know its scene again. Of registers set free together, the last operand's is handed out first; in an order
    of hashes, which are others in every process, all 24 would be with a probability of 6e-8."""
    from nephele.export.nodes_program import OP_INDEX, ProgramBuilder, constant

    builder = ProgramBuilder()
    total = constant(0.0)
    for k in range(24):
        a, b = (builder.emit("position", mode=2 * k + i) for i in range(2))
        total = builder.emit("add", total, builder.emit("subtract", a, b))
    one = constant(1.0)
    code = builder.finish([("emission", one, (total, one), 0)]).code
    differences = code[code[:, 0] == OP_INDEX["subtract"]]
    assert len(differences) == 24
    np.testing.assert_array_equal(differences[:, 1], differences[:, 3])
