# SPDX-License-Identifier: GPL-3.0-or-later
"""The node compiler: groups, closures and registers, compiled in whole materials and run in numpy."""

import numpy as np
import pytest
from nephele import opcodes
from programs import POINT, Tree, closure_inputs, run

P = POINT["position"]


@pytest.fixture
def tree(bpy):
    return Tree(bpy)


@pytest.fixture
def position(tree):
    return tree.node("ShaderNodeNewGeometry").outputs["Position"]


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
    node = tree.node("ShaderNodeShaderToRGB")
    assert tree.color(node.outputs["Color"]) == pytest.approx((0.2, 0.4, 0.6))
    (warning,) = tree.warnings
    assert "material 'Material', node 'Shader to RGB'" in warning


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


@pytest.mark.parametrize(
    "socket", ["Subsurface Weight", "Anisotropic", "Thin Film Thickness", "Diffuse Roughness"]
)
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
    diffuse, glass = (
        tree.node("ShaderNodeBsdfDiffuse"),
        tree.node("ShaderNodeBsdfGlass", distribution="BECKMANN"),
    )
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


def test_displacement_bends_normals_and_warns_where_it_should_move_the_surface(tree, position):
    displacement = tree.node("ShaderNodeDisplacement", {"Height": position})
    tree.link(displacement.outputs[0], tree.output.inputs["Displacement"])
    tree.link(tree.node("ShaderNodeBsdfDiffuse").outputs[0], tree.output.inputs["Surface"])
    closure = tree.compile().surface.closures[0]
    assert closure.kind == "diffuse" and closure.inputs[2] >= 0
    assert tree.warnings == []
    tree.material.displacement_method = "BOTH"
    tree.compile()
    assert any("true displacement is not supported" in text for text in tree.warnings)


def test_bump_reads_its_height_at_three_places(tree, position):
    height = tree.node("ShaderNodeSeparateXYZ", {0: position}).outputs[0]
    bump = tree.node("ShaderNodeBump", {"Height": height, "Distance": 2.0})
    tree.color(bump.outputs[0], POINT | {"normal": np.array((0.0, 0, 1)), "bump": lambda o, p, m: o[0]})
    code = tree.compile().surface.code.tolist()
    names = list(opcodes.OPCODES)
    assert [row[7] for row in code if names[row[0]] == "position"] == [0, opcodes.SHIFT, 2 * opcodes.SHIFT]


def test_bump_of_a_constant_leaves_the_normal(tree):
    bump = tree.node("ShaderNodeBump", {"Height": 0.7})
    tree.color(bump.outputs[0], {"normal": np.array((0.0, 0, 1))})
    assert [row[0] for row in tree.compile().surface.code.tolist()] == [list(opcodes.OPCODES).index("normal")]


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
        value = tree.node(
            "ShaderNodeVectorMath", {0: value, 1: (k % 7, 1, -1)}, operation="SUBTRACT"
        ).outputs[0]
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
