# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders: coefficients by the formulas of Cycles, grids, weights, and what warns."""

import pytest
from nephele.export.context import Context
from nephele.export.nodes import compile_material
from programs import with_nodes


class Tree:
    """A material with a Volume socket to fill."""

    def __init__(self, bpy):
        self.bpy = bpy
        self.material = with_nodes(bpy.data.materials.new("Fog"))
        self.tree = self.material.node_tree
        self.tree.links.clear()
        self.target = self.tree.nodes["Material Output"].inputs["Volume"]

    def node(self, kind, **inputs):
        """Adds a node; inputs: socket names with _ for blanks -> constant or output socket."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in inputs.items():
            self.set(node, name.replace("_", " "), value)
        return node

    def set(self, node, name, value):
        if isinstance(value, self.bpy.types.NodeSocket):
            self.tree.links.new(value, node.inputs[name])
        else:
            node.inputs[name].default_value = value

    def compile(self, node, grids=True):
        self.tree.links.new(node.outputs[0], self.target)
        self.context = Context(self.bpy.context.evaluated_depsgraph_get())
        return compile_material(self.material, self.context, grids)[0].volume


@pytest.fixture
def tree(bpy):
    return Tree(bpy)


def attribute(tree, name, output="Fac"):
    node = tree.tree.nodes.new("ShaderNodeAttribute")
    node.attribute_name = name
    return next(s for s in node.outputs if s.identifier == output)


def math(tree, operation, *values):
    node = tree.tree.nodes.new("ShaderNodeMath")
    node.operation = operation
    for k, value in enumerate(values):
        tree.set(node, k, value)
    return node.outputs[0]


def test_principled(tree):
    node = tree.node(
        "VolumePrincipled",
        Color=(0.2, 0.5, 1.0, 1),
        Density=2.0,
        Anisotropy=0.3,
        Absorption_Color=(0.25, 0, 0, 1),
    )
    (closure,) = tree.compile(node)
    assert closure.sigma_s == pytest.approx((0.4, 1.0, 2.0))
    assert closure.sigma_a == pytest.approx((0.8 * 0.5 * 2, 0.5 * 2, 0.0))
    assert (closure.phase.a, closure.density_grid) == (pytest.approx(0.3), "density")
    assert tree.context.warnings == []


def test_principled_on_a_mesh_has_no_grid(tree):
    (closure,) = tree.compile(tree.node("VolumePrincipled"), grids=False)
    assert closure.density_grid is None
    assert closure.sigma_s == pytest.approx((0.5, 0.5, 0.5))


def test_principled_emission_is_not_scaled_by_density(tree):
    node = tree.node("VolumePrincipled", Density=7.0, Emission_Strength=3.0, Emission_Color=(1, 0.5, 0, 1))
    _, emission = tree.compile(node)
    assert emission.emission == pytest.approx((3.0, 1.5, 0.0))
    assert (emission.emission_grid, emission.density_grid) == (None, None)


def test_principled_warns_about_what_it_lacks(tree):
    node = tree.node("VolumePrincipled", Blackbody_Intensity=1.0, Color_Attribute="color")
    tree.compile(node)
    assert len(tree.context.warnings) == 2
    assert all("material 'Fog', node 'Principled Volume'" in text for text in tree.context.warnings)
    assert tree.compile(node, grids=False)  # no colour grids on a mesh: nothing is lost
    assert len(tree.context.warnings) == 1


def test_density_attribute_may_be_named_or_empty(tree):
    node = tree.node("VolumePrincipled", Density_Attribute="smoke")
    assert tree.compile(node)[0].density_grid == "smoke"
    node.inputs["Density Attribute"].default_value = ""
    assert tree.compile(node)[0].density_grid is None


def test_scatter_and_absorption(tree):
    scatter = tree.node("VolumeScatter", Color=(0.1, 0.2, 0.3, 1), Density=10.0, Anisotropy=-0.4)
    absorb = tree.node("VolumeAbsorption", Color=(0.1, 0.2, 0.3, 1), Density=10.0)
    add = tree.node("AddShader")
    tree.tree.links.new(scatter.outputs[0], add.inputs[0])
    tree.tree.links.new(absorb.outputs[0], add.inputs[1])
    first, second = tree.compile(add)
    assert (first.sigma_s, first.sigma_a) == (pytest.approx((1, 2, 3)), (0, 0, 0))
    assert (second.sigma_s, second.sigma_a) == ((0, 0, 0), pytest.approx((9, 8, 7)))
    assert first.phase.a == pytest.approx(-0.4)


def test_mix_weighs_everything(tree):
    mix = tree.tree.nodes.new("ShaderNodeMixShader")
    mix.inputs[0].default_value = 0.25
    tree.tree.links.new(tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=4.0).outputs[0], mix.inputs[1])
    tree.tree.links.new(tree.node("Emission", Color=(1, 1, 1, 1), Strength=8.0).outputs[0], mix.inputs[2])
    scatter, emission = tree.compile(mix)
    assert scatter.sigma_s == pytest.approx((3, 3, 3))
    assert emission.emission == pytest.approx((2, 2, 2))


@pytest.mark.skipif(
    "__import__('bpy').app.version < (5, 0, 0)", reason="Volume Coefficients came with Blender 5.0"
)
def test_coefficients(tree):
    node = tree.node(
        "VolumeCoefficients", Scatter_Coefficients=(1, 2, 3), Absorption_Coefficients=(4, 5, 6),
        Emission_Coefficients=(7, 8, 9), Anisotropy=0.5,
    )  # fmt: skip
    medium, emission = tree.compile(node)
    assert (medium.sigma_s, medium.sigma_a, medium.phase.a) == ((1, 2, 3), (4, 5, 6), 0.5)
    assert emission.emission == (7, 8, 9)


@pytest.mark.parametrize(
    ("build", "factor"),
    [
        (lambda t: attribute(t, "smoke"), 1.0),
        (lambda t: math(t, "MULTIPLY", attribute(t, "smoke"), 3.0), 3.0),
        (lambda t: math(t, "MULTIPLY", 3.0, math(t, "MULTIPLY", attribute(t, "smoke"), 2.0)), 6.0),
        (lambda t: math(t, "DIVIDE", attribute(t, "smoke"), 4.0), 0.25),
        (lambda t: math(t, "MULTIPLY", attribute(t, "smoke"), math(t, "ADD", 1.0, 1.5)), 2.5),
    ],
)
def test_density_by_a_grid(tree, build, factor):
    node = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=build(tree))
    (closure,) = tree.compile(node)
    assert (closure.sigma_s, closure.density_grid) == (pytest.approx((factor,) * 3), "smoke")
    assert tree.context.warnings == []


def test_volume_info(tree):
    info = tree.node("VolumeInfo")
    assert (
        tree.compile(tree.node("VolumeScatter", Density=info.outputs["Density"]))[0].density_grid == "density"
    )
    node = tree.node("Emission", Strength=math(tree, "MULTIPLY", info.outputs["Flame"], 5.0))
    (fire,) = tree.compile(node)
    assert (fire.emission, fire.emission_grid) == (pytest.approx((5, 5, 5)), "flame")


def test_grid_on_a_mesh_is_0_and_warns(tree):
    node = tree.node("VolumeScatter", Density=attribute(tree, "smoke"))
    assert tree.compile(node, grids=False) == ()
    assert any("there is no grid 'smoke'" in text for text in tree.context.warnings)


@pytest.mark.parametrize(
    "build",
    [
        lambda t: t.tree.nodes.new("ShaderNodeTexNoise").outputs[0],
        lambda t: math(t, "ADD", attribute(t, "smoke"), 1.0),
        lambda t: math(t, "MULTIPLY", attribute(t, "smoke"), attribute(t, "heat")),
        lambda t: math(t, "DIVIDE", 1.0, attribute(t, "smoke")),
    ],
)
def test_other_densities_warn_and_fall_back(tree, build):
    node = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=0.5)
    tree.set(node, "Density", build(tree))
    (closure,) = tree.compile(node)
    assert (closure.sigma_s, closure.density_grid) == ((0.5,) * 3, None)
    assert len(tree.context.warnings) == 1
    assert "node 'Volume Scatter': what is linked to 'Density'" in tree.context.warnings[0]


def test_constant_expressions_are_folded(tree):
    ramp = tree.tree.nodes.new("ShaderNodeValToRGB")
    ramp.inputs[0].default_value = 0.5
    node = tree.node("VolumeScatter", Color=ramp.outputs[0], Density=math(tree, "SQRT", 16.0))
    (closure,) = tree.compile(node)
    assert closure.sigma_s == pytest.approx((2, 2, 2), abs=1e-4)


@pytest.mark.skipif(
    "__import__('bpy').app.version < (4, 3, 0)", reason="phase functions came with Blender 4.3"
)
def test_other_phase_functions_warn(tree):
    node = tree.node("VolumeScatter")
    node.phase = "RAYLEIGH"
    (closure,) = tree.compile(node)
    assert closure.phase.a == 0.0
    assert any("phase function Rayleigh" in text for text in tree.context.warnings)


def test_volume_in_a_group(tree):
    group = tree.bpy.data.node_groups.new("Fog", "ShaderNodeTree")
    group.interface.new_socket("Density", in_out="INPUT", socket_type="NodeSocketFloat")
    group.interface.new_socket("Volume", in_out="OUTPUT", socket_type="NodeSocketShader")
    scatter, start, end = (
        group.nodes.new(n) for n in ("ShaderNodeVolumeScatter", "NodeGroupInput", "NodeGroupOutput")
    )
    scatter.inputs["Color"].default_value = (1, 1, 1, 1)
    group.links.new(start.outputs[0], scatter.inputs["Density"])
    group.links.new(scatter.outputs[0], end.inputs[0])
    node = tree.tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group
    tree.set(node, 0, math(tree, "MULTIPLY", attribute(tree, "smoke"), 2.0))
    (closure,) = tree.compile(node)
    assert (closure.sigma_s, closure.density_grid) == ((2, 2, 2), "smoke")


def test_surface_shader_in_the_volume_socket_warns(tree):
    assert tree.compile(tree.node("BsdfDiffuse")) == ()
    assert any("not supported in a volume" in text for text in tree.context.warnings)
