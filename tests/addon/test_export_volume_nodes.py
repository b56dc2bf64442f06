# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders that need no program: constants, constants times a grid of numbers, and what warns."""

import numpy as np
import pytest
from nephele.description import Phase
from nephele.export.volume_grids import Grids
from volume_trees import VolumeTree


@pytest.fixture
def tree(bpy):
    return VolumeTree(bpy)


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
    assert closure.program is None
    assert tree.warnings == []


def test_principled_on_a_mesh_has_no_grid(tree):
    (closure,) = tree.compile(tree.node("VolumePrincipled"), grids=None)
    assert (closure.density_grid, closure.program) == (None, None)
    assert closure.sigma_s == pytest.approx((0.5, 0.5, 0.5))
    assert tree.warnings == []


def test_principled_emission_is_not_scaled_by_density(tree):
    node = tree.node("VolumePrincipled", Density=7.0, Emission_Strength=3.0, Emission_Color=(1, 0.5, 0, 1))
    _, emission = tree.compile(node)
    assert emission.emission == pytest.approx((3.0, 1.5, 0.0))
    assert (emission.emission_grid, emission.density_grid) == (None, None)


def test_density_attribute_may_be_named_or_empty(tree):
    node = tree.node("VolumePrincipled", Density_Attribute="smoke")
    assert tree.compile(node)[0].density_grid == "smoke"
    node.inputs["Density Attribute"].default_value = ""
    assert tree.compile(node)[0].density_grid is None


def test_density_attribute_that_the_file_lacks_is_still_asked_for(tree):
    """Its absence empties the volume and is the renderer's to report, with the names that the file has."""
    (closure,) = tree.compile(tree.node("VolumePrincipled"), Grids((("smoke", 1),)))
    assert closure.density_grid == "density"


def test_scatter_and_absorption(tree):
    scatter = tree.node("VolumeScatter", Color=(0.1, 0.2, 0.3, 1), Density=10.0, Anisotropy=-0.4)
    absorb = tree.node("VolumeAbsorption", Color=(0.1, 0.2, 0.3, 1), Density=10.0)
    first, second = tree.compile(tree.mix(None, scatter, absorb))
    assert (first.sigma_s, first.sigma_a) == (pytest.approx((1, 2, 3)), (0, 0, 0))
    assert (second.sigma_s, second.sigma_a) == ((0, 0, 0), pytest.approx((9, 8, 7)))
    assert first.phase.a == pytest.approx(-0.4)


def test_mix_weighs_everything(tree):
    scatter = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=4.0)
    mix = tree.mix(0.25, scatter, tree.node("Emission", Color=(1, 1, 1, 1), Strength=8.0))
    medium, emission = tree.compile(mix)
    assert medium.sigma_s == pytest.approx((3, 3, 3))
    assert emission.emission == pytest.approx((2, 2, 2))


@pytest.mark.parametrize("fac", [0.0, 1.0, -3.0, 7.0])
def test_what_a_mix_leaves_out_is_gone(tree, fac):
    scatter, absorb = tree.node("VolumeScatter", Density=4.0), tree.node("VolumeAbsorption", Density=2.0)
    (closure,) = tree.compile(tree.mix(fac, scatter, absorb))
    assert any(closure.sigma_s if fac <= 0 else closure.sigma_a)


def test_zero_closures_vanish(tree):
    assert tree.compile(tree.node("VolumeScatter", Density=0.0)) == ()
    assert tree.compile(tree.node("VolumeScatter", Density=tree.attribute("smoke"), Color=(0, 0, 0, 1))) == ()
    assert tree.compile(tree.node("Emission", Strength=0.0)) == ()
    assert tree.compile(tree.node("VolumeAbsorption", Color=(1, 1, 1, 1), Density=tree.position())) == ()


def test_negative_densities_and_colors_are_0(tree):
    assert tree.compile(tree.node("VolumeScatter", Density=tree.math("ADD", -5.0, 1.0))) == ()
    negative = tree.math("MULTIPLY", tree.attribute("smoke"), -2.0)
    assert tree.compile(tree.node("VolumeScatter", Density=negative)) == ()
    node = tree.node("VolumeScatter", Color=(-1, 0.5, 1, 1), Density=2.0)
    assert tree.compile(node)[0].sigma_s == pytest.approx((0, 1, 2))


def test_an_infinite_density_warns_and_is_0(tree):
    node = tree.node("VolumeScatter", Density=tree.math("EXPONENT", 1000.0))
    assert tree.compile(node) == ()
    assert tree.warnings == [
        "material 'Fog', node 'Volume Scatter': sigma_s is infinite or no number; it is 0"
    ]


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
    tree.set(node, "Absorption Coefficients", tree.attribute("smoke"))
    scatter, absorb, emission = tree.compile(node)
    assert (scatter.sigma_s, scatter.density_grid, scatter.phase.a) == ((1, 2, 3), None, 0.5)
    assert (absorb.sigma_a, absorb.density_grid) == ((1, 1, 1), "smoke")


@pytest.mark.parametrize(
    ("build", "factor"),
    [
        (lambda t: t.attribute("smoke"), 1.0),
        (lambda t: t.attribute("smoke", "Color"), 1.0),
        (lambda t: t.attribute("smoke", "Vector"), 1.0),
        (lambda t: t.math("MULTIPLY", t.attribute("smoke"), 3.0), 3.0),
        (lambda t: t.math("MULTIPLY", 3.0, t.math("MULTIPLY", t.attribute("smoke"), 2.0)), 6.0),
        (lambda t: t.math("DIVIDE", t.attribute("smoke"), 4.0), 0.25),
        (lambda t: t.math("MULTIPLY", t.attribute("smoke"), t.math("ADD", 1.0, 1.5)), 2.5),
        (lambda t: t.math("MAXIMUM", t.math("MULTIPLY", t.attribute("smoke"), 2.0), 0.0), 2.0),
        (lambda t: t.math("ADD", t.attribute("smoke"), 0.0), 1.0),
    ],
)
def test_density_by_a_grid_needs_no_program(tree, build, factor):
    node = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=build(tree))
    (closure,) = tree.compile(node)
    assert (closure.sigma_s, closure.density_grid) == (pytest.approx((factor,) * 3), "smoke")
    assert (closure.program, closure.grids) == (None, ())
    assert tree.warnings == []


def test_color_by_a_grid_needs_no_program(tree):
    tint = tree.node("VectorMath", {"operation": "SCALE"}, Scale=tree.attribute("smoke"))
    tint.inputs[0].default_value = (1, 2, 3)
    node = tree.node("Emission", Color=tint.outputs[0], Strength=2.0)
    (closure,) = tree.compile(node)
    assert (closure.emission, closure.emission_grid) == (pytest.approx((2, 4, 6)), "smoke")


def test_different_grids_for_sigma_and_emission_are_two_closures(tree):
    node = tree.node("VolumePrincipled", Emission_Strength=tree.attribute("flame"))
    medium, emission = tree.compile(node)
    assert (medium.density_grid, medium.emission, emission.emission_grid) == ("density", (0, 0, 0), "flame")


def test_volume_info(tree):
    info = tree.node("VolumeInfo")
    scatter = tree.node("VolumeScatter", Density=info.outputs["Density"])
    assert tree.compile(scatter)[0].density_grid == "density"
    node = tree.node("Emission", Strength=tree.math("MULTIPLY", info.outputs["Flame"], 5.0))
    (fire,) = tree.compile(node)
    assert (fire.emission, fire.emission_grid) == (pytest.approx((5, 5, 5)), "flame")


@pytest.mark.parametrize("grids", [None, Grids(), Grids((("density", 1),))])
def test_grid_that_is_not_there_is_0_and_warns(tree, grids):
    node = tree.node("VolumeScatter", Density=tree.attribute("smoke"))
    assert tree.compile(node, grids) == ()
    assert tree.warnings == ["material 'Fog', node 'Attribute': there is no grid 'smoke' here; it is 0"]


@pytest.mark.parametrize("kind", ["OBJECT", "INSTANCER"])
def test_attributes_of_the_object_are_0_in_grids_and_warn(tree, kind):
    node = tree.node("Attribute", {"attribute_type": kind, "attribute_name": "smoke"})
    assert tree.compile(tree.node("VolumeScatter", Density=node.outputs["Fac"])) == ()
    assert any("node 'Attribute': attributes of type" in text for text in tree.warnings)


def test_constant_expressions_are_folded(tree):
    ramp = tree.node("ValToRGB")
    ramp.inputs[0].default_value = 0.5
    node = tree.node("VolumeScatter", Color=ramp.outputs[0], Density=tree.math("SQRT", 16.0))
    (closure,) = tree.compile(node)
    assert closure.sigma_s == pytest.approx((2, 2, 2), abs=1e-4)
    assert closure.program is None


phases = pytest.mark.skipif(
    "__import__('bpy').app.version < (4, 3, 0)", reason="phase functions came with Blender 4.3"
)
PHASES = [
    ("HENYEY_GREENSTEIN", {"Anisotropy": 0.5}, Phase("henyey_greenstein", 0.5)),
    ("HENYEY_GREENSTEIN", {"Anisotropy": -1.0}, Phase("henyey_greenstein", -0.999)),
    ("RAYLEIGH", {}, Phase("rayleigh")),
    ("DRAINE", {"Anisotropy": 0.25, "Alpha": 0.75}, Phase("draine", 0.25, 0.75)),
    ("FOURNIER_FORAND", {"IOR": 1.5, "Backscatter": 0.25}, Phase("fournier_forand", 1.5, 0.25)),
    ("FOURNIER_FORAND", {"IOR": 1.0, "Backscatter": 0.5}, Phase("fournier_forand", 1.001, 0.499)),
    ("MIE", {"Diameter": 8.0}, Phase("mie", 8.0)),
]


@phases
@pytest.mark.parametrize("kind", ["VolumeScatter", "VolumeCoefficients"])
@pytest.mark.parametrize(("phase", "inputs", "expected"), PHASES)
def test_phase_functions(tree, kind, phase, inputs, expected):
    if not hasattr(tree.bpy.types, f"ShaderNode{kind}"):
        pytest.skip("this Blender has no such node")
    node = tree.node(kind, {"phase": phase}, **inputs)
    closure = tree.compile(node)[0]
    assert (closure.phase.kind, closure.program) == (expected.kind, None)
    assert (closure.phase.a, closure.phase.b) == pytest.approx((expected.a, expected.b))
    assert tree.warnings == []


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
    tree.set(node, 0, tree.math("MULTIPLY", tree.attribute("smoke"), 2.0))
    (closure,) = tree.compile(node)
    assert (closure.sigma_s, closure.density_grid) == ((2, 2, 2), "smoke")


def test_muted_nodes_pass_the_volume_on(tree):
    scatter = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=4.0)
    mix = tree.mix(0.25, scatter, tree.node("VolumeAbsorption"))
    mix.mute = True
    (closure,) = tree.compile(mix)
    assert closure.sigma_s == pytest.approx((4, 4, 4))


def test_reroutes_pass_the_volume_on(tree):
    reroute = tree.tree.nodes.new("NodeReroute")
    scatter = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=4.0)
    tree.tree.links.new(scatter.outputs[0], reroute.inputs[0])
    assert tree.compile(reroute)[0].sigma_s == pytest.approx((4, 4, 4))


def test_color_in_the_volume_socket_shines(tree):
    node = tree.node("RGB")
    node.outputs[0].default_value = (1, 0.5, 0.25, 1)
    (closure,) = tree.compile(node)
    assert closure.emission == pytest.approx((1, 0.5, 0.25))
    assert tree.warnings == [
        f"material 'Fog', node '{node.name}': 'Color' is no shader; it is taken as emission"
    ]


def test_surface_shader_in_the_volume_socket_warns(tree):
    assert tree.compile(tree.node("BsdfDiffuse")) == ()
    assert any("not supported in a volume" in text for text in tree.warnings)


def test_blackbody_of_a_constant_temperature_is_folded(tree):
    """Figures of Cycles 5.0.1 through a box of 2 m with only this emission, colours below 0 cut."""
    rendered = {
        1000: (0.16610318, 0.00140936, 0.0),
        1500: (0.59655106, 0.07932184, 0.0),
        2500: (2.91557693, 1.08482659, 0.1966106),
        6500: (67.18043518, 63.41081619, 66.71128845),
    }
    for kelvin, expected in rendered.items():
        node = tree.node(
            "VolumePrincipled",
            Density=0.0,
            Blackbody_Intensity=1.0,
            Temperature=kelvin,
            Temperature_Attribute="",
        )
        (closure,) = tree.compile(node)
        assert closure.program is None
        difference = 2 * np.array(closure.emission) - expected
        assert np.abs(difference).max() < 0.002 * max(expected), kelvin
