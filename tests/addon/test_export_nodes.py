# SPDX-License-Identifier: GPL-3.0-or-later
"""The node compiler: whole materials compiled, then run in numpy."""

import math

import numpy as np
import pytest
from nephele.export.context import Context
from nephele.export.nodes import compile_material
from programs import closure_inputs, run

POINT = {"position": np.array((0.3, -0.7, 1.9)), "uv": np.array((0.25, 0.75, 0.0)), "object_random": np.full(3, 0.4)}


class Tree:
    """A material whose Emission node is fed by what a test builds. `color(...)` compiles and returns its Color."""

    def __init__(self, bpy):
        self.bpy = bpy
        self.material = bpy.data.materials.new("Material")
        self.tree = self.material.node_tree
        self.tree.nodes.remove(self.tree.nodes["Principled BSDF"])
        self.output = self.tree.nodes["Material Output"]
        self.emission = self.node("ShaderNodeEmission")
        self.link(self.emission.outputs[0], self.output.inputs["Surface"])

    def node(self, kind, inputs=(), **properties):
        """Adds a node; inputs: socket name or number -> constant or output socket."""
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in dict(inputs).items():
            socket = node.inputs[name]
            if isinstance(value, self.bpy.types.NodeSocket):
                self.link(value, socket)
            else:
                socket.default_value = value
        return node

    def link(self, source, target):
        self.tree.links.new(source, target)

    def compile(self):
        self.context = Context(self.bpy.context.evaluated_depsgraph_get())
        return compile_material(self.material, self.context, grids=False)[0]

    def color(self, output, inputs=POINT):
        """Returns (3,) that `output` gives at a point."""
        self.link(output, self.emission.inputs["Color"])
        program = self.compile().surface
        # an emission that is black while compiling has no closure
        return closure_inputs(program, inputs)[2]["color"] if program.closures else np.zeros(3)

    @property
    def warnings(self):
        return self.context.warnings


@pytest.fixture
def tree(bpy):
    return Tree(bpy)


@pytest.fixture
def position(tree):
    return tree.node("ShaderNodeNewGeometry").outputs["Position"]


A, B, C = 1.3, -0.7, 0.4
MATH = {
    "ADD": A + B, "SUBTRACT": A - B, "MULTIPLY": A * B, "DIVIDE": A / B, "MULTIPLY_ADD": A * B + C, "POWER": A**B,
    "LOGARITHM": 0.0, "SQRT": A**0.5, "INVERSE_SQRT": A**-0.5, "ABSOLUTE": A, "EXPONENT": math.exp(A), "MINIMUM": B,
    "MAXIMUM": A, "LESS_THAN": 0.0, "GREATER_THAN": 1.0, "SIGN": 1.0, "COMPARE": 0.0, "SMOOTH_MIN": B, "SMOOTH_MAX": A,
    "ROUND": 1.0, "FLOOR": 1.0, "CEIL": 2.0, "TRUNC": 1.0, "FRACT": 0.3, "MODULO": 0.6, "FLOORED_MODULO": -0.1,
    "SNAP": 1.4, "PINGPONG": 0.1, "SINE": math.sin(A), "COSINE": math.cos(A), "TANGENT": math.tan(A),
    "ARCSINE": math.pi / 2, "ARCCOSINE": 0.0, "ARCTANGENT": math.atan(A), "ARCTAN2": math.atan2(A, B),
    "SINH": math.sinh(A), "COSH": math.cosh(A), "TANH": math.tanh(A), "RADIANS": math.radians(A),
    "DEGREES": math.degrees(A), "WRAP": -0.7 + (2.0 % 1.1),
}  # fmt: skip


@pytest.mark.parametrize("operation", MATH)
@pytest.mark.parametrize("folded", [True, False])
def test_math(tree, operation, folded):
    """Every operation of the Math node, computed while compiling and while running."""
    first = A if folded else tree.node("ShaderNodeObjectInfo").outputs["Random"]
    third = B if operation == "WRAP" else C
    second = C if operation == "WRAP" else B
    node = tree.node("ShaderNodeMath", {0: first, 1: second, 2: third}, operation=operation)
    expected = MATH[operation] if operation != "PINGPONG" else pingpong(A, B)
    result = tree.color(node.outputs[0], {"object_random": np.full(3, A)})
    assert result == pytest.approx([expected] * 3, abs=1e-5)
    assert tree.warnings == []


def pingpong(a, b):
    """Blender's rule, written out."""
    t = (a - b) / (2 * b)
    return abs((t - math.floor(t)) * 2 * b - b)


def test_every_math_operation_is_covered(tree):
    items = tree.node("ShaderNodeMath").bl_rna.properties["operation"].enum_items
    assert set(items.keys()) == set(MATH)


P = POINT["position"]
V = np.array((0.5, 2.0, -0.25))
VECTOR_MATH = {
    "ADD": P + V, "SUBTRACT": P - V, "MULTIPLY": P * V, "DIVIDE": P / V, "CROSS_PRODUCT": np.cross(P, V),
    "PROJECT": V * (P @ V) / (V @ V), "REFLECT": P - 2 * (P @ V) / (V @ V) * V, "DOT_PRODUCT": [P @ V] * 3,
    "DISTANCE": [np.linalg.norm(P - V)] * 3, "LENGTH": [np.linalg.norm(P)] * 3, "NORMALIZE": P / np.linalg.norm(P),
    "ABSOLUTE": np.abs(P), "MINIMUM": np.minimum(P, V), "MAXIMUM": np.maximum(P, V), "FLOOR": np.floor(P),
    "CEIL": np.ceil(P), "FRACTION": P - np.floor(P), "MODULO": np.fmod(P, V), "SNAP": np.floor(P / V) * V,
    "SINE": np.sin(P), "COSINE": np.cos(P), "TANGENT": np.tan(P), "SCALE": P * 3, "MULTIPLY_ADD": P * V + 1,
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
    assert tree.color(node.outputs[0], {"position": np.array((math.sin(angle), 0, -math.cos(angle)))}).max() == 0


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
    node = tree.node("ShaderNodeMapRange", interpolation_type=kind, data_type="FLOAT_VECTOR" if vector else "FLOAT")
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
        assert tree.color(node.outputs["Alpha"], point) == pytest.approx([ramp.evaluate(x)[3]] * 3, abs=0.005), x


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
    assert tree.color(node.outputs[0], {"position": np.full(3, 0.25)}) == pytest.approx([expected] * 3, abs=0.005)


def test_texture_coordinate_of_another_object(bpy, tree, link):
    target = link("Target", None)
    target.location, target.scale = (1, 0, 0), (2, 2, 2)
    node = tree.node("ShaderNodeTexCoord", object=target)
    assert tree.color(node.outputs["Object"]) == pytest.approx((P - (1, 0, 0)) / 2, abs=1e-6)


def test_light_path(tree):
    node = tree.node("ShaderNodeLightPath")
    seen = []
    tree.color(node.outputs["Is Camera Ray"], {"ray_is": lambda o, p, mode: seen.append(mode) or np.ones(3)})
    tree.color(node.outputs["Is Reflection Ray"], {"ray_is": lambda o, p, mode: seen.append(mode) or np.ones(3)})
    assert seen == [0b000001, 0b000110]
    tree.color(node.outputs["Ray Length"], {})
    assert any("'Ray Length' is not supported" in text for text in tree.warnings)


def group_of(bpy, tree):
    """Returns a group node that doubles its vector input, twice nested."""
    inner = bpy.data.node_groups.new("Inner", "ShaderNodeTree")
    inner.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector").default_value = (1, 2, 3)
    inner.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketVector")
    add = inner.nodes.new("ShaderNodeVectorMath")
    start, end = inner.nodes.new("NodeGroupInput"), inner.nodes.new("NodeGroupOutput")
    inner.links.new(start.outputs[0], add.inputs[0])
    inner.links.new(start.outputs[0], add.inputs[1])
    inner.links.new(add.outputs[0], end.inputs[0])
    outer = bpy.data.node_groups.new("Outer", "ShaderNodeTree")
    outer.interface.new_socket("In", in_out="INPUT", socket_type="NodeSocketVector")
    outer.interface.new_socket("Out", in_out="OUTPUT", socket_type="NodeSocketVector")
    nested = [outer.nodes.new("ShaderNodeGroup") for _ in range(2)]
    for node in nested:
        node.node_tree = inner
    start, end = outer.nodes.new("NodeGroupInput"), outer.nodes.new("NodeGroupOutput")
    outer.links.new(start.outputs[0], nested[0].inputs[0])
    outer.links.new(nested[0].outputs[0], nested[1].inputs[0])
    outer.links.new(nested[1].outputs[0], end.inputs[0])
    return tree.node("ShaderNodeGroup", node_tree=outer), inner


def test_nested_groups(bpy, tree, position):
    group, _ = group_of(bpy, tree)
    tree.link(position, group.inputs[0])
    assert tree.color(group.outputs[0]) == pytest.approx(4 * P)


def test_group_input_not_linked_gives_the_group_nodes_value(bpy, tree):
    group, _ = group_of(bpy, tree)
    group.inputs[0].default_value = (1, 0, -2)
    assert tree.color(group.outputs[0], {}) == pytest.approx((4, 0, -8))


def test_muted_group_passes_its_input(bpy, tree, position):
    group, inner = group_of(bpy, tree)
    tree.link(position, group.inputs[0])
    group.mute = True
    assert tree.color(group.outputs[0]) == pytest.approx(P)
    group.mute = False
    next(n for n in inner.nodes if n.type == "VECT_MATH").mute = True
    assert tree.color(group.outputs[0]) == pytest.approx(P)


def test_reroute_and_muted_link(tree, position):
    reroute = tree.node("NodeReroute", {0: position})
    assert tree.color(reroute.outputs[0]) == pytest.approx(P)
    tree.emission.inputs["Color"].default_value = (0.5, 0.5, 0.5, 1)
    tree.emission.inputs["Color"].links[0].is_muted = True
    assert closure_inputs(tree.compile().surface, POINT)[2]["color"] == pytest.approx([0.5] * 3)


def test_unsupported_node_warns_and_falls_back(tree):
    tree.emission.inputs["Color"].default_value = (0.2, 0.4, 0.6, 1)
    node = tree.node("ShaderNodeTexVoronoi")
    assert tree.color(node.outputs["Color"]) == pytest.approx((0.2, 0.4, 0.6))
    (warning,) = tree.warnings
    assert "material 'Material', node 'Voronoi Texture'" in warning


def principled(tree):
    node = tree.node("ShaderNodeBsdfPrincipled")
    tree.link(node.outputs[0], tree.output.inputs["Surface"])
    return node


def test_principled_reads_every_socket(tree):
    node = principled(tree)
    values = {
        "Base Color": (0.1, 0.2, 0.3, 1), "Metallic": 0.11, "Roughness": 0.12, "IOR": 1.33, "Alpha": 0.9,
        "Specular IOR Level": 0.6, "Specular Tint": (0.9, 0.8, 0.7, 1), "Transmission Weight": 0.13,
        "Coat Weight": 0.14, "Coat Roughness": 0.15, "Coat IOR": 1.44, "Coat Tint": (0.5, 0.6, 0.7, 1),
        "Sheen Weight": 0.16, "Sheen Roughness": 0.17, "Sheen Tint": (0.3, 0.2, 0.1, 1),
        "Emission Color": (1, 0.5, 0.25, 1), "Emission Strength": 2.5,
    }  # fmt: skip
    for name, value in values.items():
        node.inputs[name].default_value = value
    closure, weight, found = closure_inputs(tree.compile().surface, {})
    assert (closure.kind, closure.mode, list(weight)) == ("principled", 1, [1, 1, 1])  # multi-scatter GGX
    assert {name: tuple(np.round(v, 6)) for name, v in found.items()} == {
        name.lower().replace(" ", "_"): tuple(np.round(v[:3] if isinstance(v, tuple) else (v,) * 3, 6))
        for name, v in values.items()
    }
    assert tree.warnings == []


@pytest.mark.parametrize("socket", ["Subsurface Weight", "Anisotropic", "Thin Film Thickness", "Diffuse Roughness"])
def test_principled_warns_about_what_it_lacks_only_where_active(tree, socket):
    node = principled(tree)
    node.inputs["Roughness"].default_value = 0.3
    tree.compile()
    assert tree.warnings == []
    node.inputs[socket].default_value = 0.5
    tree.compile()
    assert len(tree.warnings) == 1
    assert "material 'Material', node 'Principled BSDF'" in tree.warnings[0]


def test_mix_and_add_shaders_weigh_closures(tree):
    diffuse, glass = tree.node("ShaderNodeBsdfDiffuse"), tree.node("ShaderNodeBsdfGlass", distribution="BECKMANN")
    clear = tree.node("ShaderNodeBsdfTransparent")
    random = tree.node("ShaderNodeObjectInfo").outputs["Random"]
    mix = tree.node("ShaderNodeMixShader", {0: random, 1: diffuse.outputs[0], 2: glass.outputs[0]})
    add = tree.node("ShaderNodeAddShader", {0: mix.outputs[0], 1: clear.outputs[0]})
    tree.link(add.outputs[0], tree.output.inputs["Surface"])
    program = tree.compile().surface
    registers = run(program, POINT)
    assert [(c.kind, c.mode, registers[c.weight][0]) for c in program.closures] == [
        ("diffuse", 0, pytest.approx(0.6)),
        ("glass", 2, pytest.approx(0.4)),
        ("transparent", 0, pytest.approx(1.0)),
    ]
    assert program.closures[0].inputs[-1] == -1  # no normal connected


def test_branch_with_weight_0_is_left_out(tree):
    mix = tree.node("ShaderNodeMixShader", {0: 0.0, 1: tree.node("ShaderNodeBsdfDiffuse").outputs[0]})
    tree.link(tree.node("ShaderNodeSubsurfaceScattering").outputs[0], mix.inputs[2])
    tree.link(mix.outputs[0], tree.output.inputs["Surface"])
    assert [c.kind for c in tree.compile().surface.closures] == ["diffuse"]
    assert tree.warnings == []


@pytest.mark.parametrize("kind", ["Holdout", "BsdfHair", "BsdfToon", "EeveeSpecular"])
def test_unsupported_shader_warns_and_is_black(tree, kind):
    tree.link(tree.node(f"ShaderNode{kind}").outputs[0], tree.output.inputs["Surface"])
    assert tree.compile().surface.closures == ()
    assert len(tree.warnings) == 1


def test_metallic_bsdf_is_a_metal(tree):
    node = tree.node("ShaderNodeBsdfMetallic", fresnel_type="F82")
    node.inputs["Base Color"].default_value = (0.9, 0.6, 0.2, 1)
    tree.link(node.outputs[0], tree.output.inputs["Surface"])
    closure, _, found = closure_inputs(tree.compile().surface, {})
    assert closure.kind == "principled"
    assert (found["metallic"][0], tuple(found["base_color"])) == (1.0, pytest.approx((0.9, 0.6, 0.2)))


def test_volume_only_material_has_no_surface(tree):
    tree.tree.links.clear()
    tree.link(tree.node("ShaderNodeVolumeAbsorption").outputs[0], tree.output.inputs["Volume"])
    material = tree.compile()
    assert (material.surface, len(material.volume)) == (None, 1)


def test_material_with_nothing_linked_is_black(tree):
    tree.tree.links.clear()
    assert tree.compile().surface.closures == ()


def test_displacement_warns(tree):
    tree.link(tree.node("ShaderNodeDisplacement").outputs[0], tree.output.inputs["Displacement"])
    tree.compile()
    assert any("displacement" in text for text in tree.warnings)


def test_program_is_shared_and_dead_code_dropped(tree, position):
    """a + a through two equal nodes is one instruction each; nodes nobody reads leave no trace."""
    twins = [tree.node("ShaderNodeVectorMath", {0: position, 1: position}) for _ in range(2)]
    product = tree.node(
        "ShaderNodeVectorMath", {0: twins[0].outputs[0], 1: twins[1].outputs[0]}, operation="MULTIPLY"
    )
    tree.color(product.outputs[0])
    assert len(tree.compile().surface.code) == 3  # position, add, multiply


def test_long_chains_reuse_registers(tree, position):
    """600 operations in a row need few registers, though a program has 256."""
    value = position
    for k in range(600):
        value = tree.node("ShaderNodeVectorMath", {0: value, 1: (k % 7, 1, -1)}, operation="SUBTRACT").outputs[0]
    expected = P - np.array((sum(k % 7 for k in range(600)), 600, -600))
    assert tree.color(value) == pytest.approx(expected, rel=1e-4)
    assert len(tree.compile().surface.registers) < 16


def test_too_large_a_tree_warns_by_name(tree, position):
    """300 values alive at once: the same ones are added up and then multiplied."""
    rows = [tree.node("ShaderNodeVectorMath", {0: position, 1: (k, 0, 0)}).outputs[0] for k in range(300)]
    value = rows[0]
    for operation in ("ADD", "MULTIPLY"):
        for row in rows:
            value = tree.node("ShaderNodeVectorMath", {0: value, 1: row}, operation=operation).outputs[0]
    tree.link(value, tree.emission.inputs["Color"])
    assert tree.compile().surface.closures == ()
    assert any("material 'Material': the node tree needs more than 256 registers" in t for t in tree.warnings)
