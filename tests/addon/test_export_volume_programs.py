# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders that vary by more than one grid: their programs, run in numpy, against the formulas."""

import math

import numpy as np
import pytest
from nephele import opcodes
from nephele.export.blackbody import blackbody_rgb
from nephele.export.nodes_volume import BOLTZMANN
from nephele.export.volume_grids import Fire, Grids
from volume_trees import GRIDS, POINT, VolumeTree, evaluate, total

FIELDS = {
    "density": 0.8, "smoke": 0.6, "heat": 0.25, "flame": 0.5, "temperature": 1.5,
    "color": np.array((0.9, 0.5, 0.1)), "velocity": np.array((3.0, -1.0, 1.0)),
}  # fmt: skip


@pytest.fixture
def tree(bpy):
    return VolumeTree(bpy)


def value_of(tree, output, fields=FIELDS, grids=GRIDS, **inputs):
    """Returns (3,), what an output gives as the colour of an emission; it must take a program."""
    (closure,) = tree.compile(tree.node("Emission", Color=output, Strength=1.0), grids)
    assert closure.program is not None
    return evaluate(closure, fields, **inputs)["emission"]


@pytest.mark.parametrize(
    ("build", "expected"),
    [
        (lambda t: t.math("ADD", t.attribute("smoke"), 1.0), 1.6),
        (lambda t: t.math("MULTIPLY", t.attribute("smoke"), t.attribute("heat")), 0.15),
        (lambda t: t.math("MULTIPLY", t.attribute("smoke"), t.attribute("smoke")), 0.36),
        (lambda t: t.math("DIVIDE", 1.0, t.attribute("smoke")), 1 / 0.6),
        (lambda t: t.math("SUBTRACT", t.attribute("smoke"), 1.0), 0.0),
        (lambda t: t.math("MAXIMUM", t.attribute("smoke"), 0.7), 0.7),
    ],
)
def test_any_density_compiles(tree, build, expected):
    node = tree.node("VolumeScatter", Color=(1, 0.5, 0.25, 1), Density=build(tree), Anisotropy=0.3)
    (closure,) = tree.compile(node)
    values = evaluate(closure, FIELDS)
    assert values["sigma_s"] == pytest.approx(expected * np.array((1, 0.5, 0.25)), abs=1e-6)
    assert values["phase_a"] == pytest.approx([0.3] * 3)
    assert not values["sigma_a"].any()
    assert not values["emission"].any()
    assert tree.warnings == []


def test_one_closure_of_kind_medium(tree):
    node = tree.node("VolumeScatter", Density=tree.position())
    (closure,) = tree.compile(node)
    (row,) = closure.program.closures
    assert (row.kind, row.mode, len(row.inputs)) == ("medium", 0, len(opcodes.CLOSURES["medium"]))
    assert (closure.sigma_s, closure.density_grid, closure.grids) == ((0, 0, 0), None, ())


def test_grids_are_numbered_by_closure(tree):
    """Each program reads only the grids that its own closure names."""
    first = tree.node("VolumeScatter", Density=tree.math("ADD", tree.attribute("smoke"), 1.0))
    both = tree.math("MULTIPLY", tree.attribute("flame"), tree.attribute("heat"))
    second = tree.node("Emission", Strength=both)
    scatter, emission = tree.compile(tree.mix(None, first, second))
    assert scatter.grids == ("smoke",)
    assert set(emission.grids) == {"flame", "heat"}
    assert evaluate(emission, FIELDS)["emission"] == pytest.approx([0.125] * 3)


def test_grid_read_elsewhere_takes_a_program(tree):
    """No node moves the point at which a grid is read; a hand-made instruction does."""
    from nephele.export.context import Context
    from nephele.export.nodes import VOLUME_HANDLERS
    from nephele.export.nodes_medium import Medium, closures_of
    from nephele.export.nodes_program import constant
    from nephele.export.nodes_volume_input import VolumeCompiler

    context = Context(tree.bpy.context.evaluated_depsgraph_get())
    c = VolumeCompiler("material 'Fog'", context, VOLUME_HANDLERS, GRIDS)
    c.grid_names.append("smoke")
    moved = c.emit("grid", c.emit("add", c.emit("position"), constant(1.0)), mode=0)
    (closure,) = closures_of(c, None, Medium(sigma_s=moved))
    seen = evaluate(closure, {"smoke": lambda point: point})["sigma_s"]
    assert seen == pytest.approx(np.maximum(POINT + 1, 0))


def test_principled_density_times_its_attribute(tree):
    node = tree.node(
        "VolumePrincipled",
        Color=(0.2, 0.5, 1.0, 1),
        Absorption_Color=(0.25, 0, 0, 1),
        Density=tree.attribute("smoke"),
    )
    (closure,) = tree.compile(node)
    values, d = evaluate(closure, FIELDS), 0.6 * 0.8
    assert values["sigma_s"] == pytest.approx(d * np.array((0.2, 0.5, 1.0)))
    assert values["sigma_a"] == pytest.approx(d * np.array((0.8 * 0.5, 0.5, 0.0)))


def test_principled_color_times_its_attribute(tree):
    node = tree.node("VolumePrincipled", Color=(0.5, 1.0, 1.0, 1), Color_Attribute="color", Density=2.0)
    (closure,) = tree.compile(node)
    values, c = evaluate(closure, FIELDS), FIELDS["color"] * (0.5, 1, 1)
    assert values["sigma_s"] == pytest.approx(1.6 * c)
    assert values["sigma_a"] == pytest.approx(1.6 * (1 - c))
    assert set(closure.grids) == {"density", "color"}


def blackbody(kelvin):
    return BOLTZMANN * kelvin**4 * blackbody_rgb(kelvin)


def test_principled_blackbody(tree):
    tint = np.array((1.0, 0.5, 0.25))
    node = tree.node(
        "VolumePrincipled",
        Density=3.0,
        Blackbody_Intensity=0.7,
        Blackbody_Tint=(*tint, 1),
        Temperature=1000.0,
    )
    medium, fire = tree.compile(node)
    assert (medium.density_grid, medium.program) == ("density", None)
    assert fire.grids == ("temperature",)
    assert evaluate(fire, FIELDS)["emission"] == pytest.approx(0.7 * tint * blackbody(1500.0), rel=1e-5)
    assert not evaluate(fire, {"temperature": -2.0})["emission"].any()
    assert not evaluate(fire, {})["emission"].any()


def test_blackbody_is_added_to_the_emission(tree):
    node = tree.node("VolumePrincipled", Density=0.0, Emission_Strength=0.25, Blackbody_Intensity=1.0)
    assert total(tree.compile(node), "emission", FIELDS) == pytest.approx(0.25 + blackbody(1500.0), rel=1e-5)


def test_temperature_without_its_grid_stands_alone(tree):
    node = tree.node("VolumePrincipled", Density=0.0, Blackbody_Intensity=1.0, Temperature=2000.0)
    for grids, warnings in ((Grids((("density", 1),)), 1), (None, 0)):
        (closure,) = tree.compile(node, grids)
        assert closure.emission == pytest.approx(blackbody(2000.0), rel=1e-5)
        assert len(tree.warnings) == warnings
    tree.compile(node, Grids((("density", 1),)))
    assert "material 'Fog', node 'Principled Volume': there is no grid 'temperature'" in tree.warnings[0]


DOMAIN = Grids((("density", 1), ("flame", 1), ("temperature", 1), ("velocity", 3)), Fire(1.5, 3.0))


@pytest.mark.parametrize(("flame", "expected"), [(0.5, 2.25), (0.0, 0.0), (0.009, 0.0), (1.0, 3.0)])
def test_temperature_of_a_fluid_domain_follows_from_its_flame(tree, flame, expected):
    fields = {"flame": flame, "temperature": 0.8}
    output = tree.node("VolumeInfo").outputs["Temperature"]
    assert value_of(tree, output, fields, DOMAIN) == pytest.approx([expected] * 3)
    node = tree.node("VolumePrincipled", Density=0.0, Blackbody_Intensity=1.0, Temperature=1000.0)
    (fire,) = tree.compile(node, DOMAIN)
    assert fire.grids == ("flame",)
    expected = blackbody(1000 * expected) if expected else 0.0
    assert evaluate(fire, fields)["emission"] == pytest.approx(expected, rel=1e-5)


def test_heat_of_a_fluid_domain_is_half_its_stored_temperature(tree):
    (closure,) = tree.compile(tree.node("Emission", Strength=tree.attribute("heat")), DOMAIN)
    assert (closure.emission, closure.emission_grid) == ((0.5,) * 3, "temperature")


def test_vector_grids(tree):
    assert value_of(tree, tree.attribute("color", "Color")) == pytest.approx(FIELDS["color"])
    assert value_of(tree, tree.attribute("color", "Vector")) == pytest.approx(FIELDS["color"])
    assert value_of(tree, tree.attribute("velocity", "Fac")) == pytest.approx([1.0] * 3)
    assert value_of(tree, tree.node("VolumeInfo").outputs["Color"]) == pytest.approx(FIELDS["color"])
    assert tree.warnings == []


def test_alpha_of_a_grid_is_1(tree):
    (closure,) = tree.compile(tree.node("Emission", Strength=tree.attribute("smoke", "Alpha")))
    assert closure.emission == (1, 1, 1)


def test_attribute_of_the_color_attribute_node(tree):
    node = tree.node("VertexColor", {"layer_name": "color"})
    assert value_of(tree, node.outputs["Color"]) == pytest.approx(FIELDS["color"])


def test_mix_factor_that_varies(tree):
    scatter = tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=4.0)
    shine = tree.node("Emission", Color=(1, 0.5, 0, 1), Strength=8.0)
    closures = tree.compile(tree.mix(tree.attribute("smoke"), scatter, shine))
    assert total(closures, "sigma_s", FIELDS) == pytest.approx([4 * 0.4] * 3)
    assert total(closures, "emission", FIELDS) == pytest.approx(8 * 0.6 * np.array((1, 0.5, 0)))
    assert total(closures, "sigma_s", {"smoke": 7.0}) == pytest.approx([0] * 3)
    assert total(closures, "emission", {"smoke": -7.0}) == pytest.approx([0] * 3)


def test_weights_multiply_through_nested_mixes(tree):
    inner = tree.mix(
        tree.attribute("heat"), None, tree.node("VolumeAbsorption", Color=(0, 0, 0, 1), Density=2.0)
    )
    closures = tree.compile(tree.mix(0.5, None, tree.mix(None, inner, tree.node("VolumeScatter"))))
    assert total(closures, "sigma_a", FIELDS) == pytest.approx([0.5 * 0.25 * 2] * 3)
    assert total(closures, "sigma_s", FIELDS) == pytest.approx([0.5 * 0.8] * 3)


@pytest.mark.skipif(
    "__import__('bpy').app.version < (5, 0, 0)", reason="Volume Coefficients came with Blender 5.0"
)
def test_coefficients_that_vary(tree):
    node = tree.node(
        "VolumeCoefficients",
        Scatter_Coefficients=tree.position(),
        Absorption_Coefficients=tree.attribute("smoke"),
        Emission_Coefficients=tree.attribute("color", "Color"),
        Anisotropy=0.5,
    )
    absorb, rest = tree.compile(node)
    assert (absorb.density_grid, absorb.program) == ("smoke", None)
    values = evaluate(rest, FIELDS)
    assert values["sigma_s"] == pytest.approx(np.maximum(POINT, 0))
    assert values["emission"] == pytest.approx(FIELDS["color"])
    assert values["phase_a"] == pytest.approx([0.5] * 3)


@pytest.mark.skipif(
    "__import__('bpy').app.version < (4, 3, 0)", reason="phase functions came with Blender 4.3"
)
@pytest.mark.parametrize(
    ("phase", "socket", "field", "low", "high"),
    [
        ("HENYEY_GREENSTEIN", "Anisotropy", "phase_a", -0.999, 0.999),
        ("DRAINE", "Anisotropy", "phase_a", -0.999, 0.999),
        ("DRAINE", "Alpha", "phase_b", 0.0, 9.0),
        ("FOURNIER_FORAND", "IOR", "phase_a", 1.001, 9.0),
        ("FOURNIER_FORAND", "Backscatter", "phase_b", 0.0, 0.499),
        ("MIE", "Diameter", "phase_a", 0.0, 9.0),
    ],
)
def test_phase_that_varies(tree, phase, socket, field, low, high):
    node = tree.node("VolumeScatter", {"phase": phase}, Color=(1, 1, 1, 1), Density=tree.attribute("smoke"))
    tree.set(node, socket, tree.attribute("heat"))
    (closure,) = tree.compile(node)
    assert list(opcodes.PHASES)[closure.program.closures[0].mode] == phase.lower()
    for value in (-9.0, 0.25, 9.0):
        values = evaluate(closure, {"smoke": 0.6, "heat": value})
        assert values[field] == pytest.approx([min(max(value, low), high)] * 3)
        assert values["sigma_s"] == pytest.approx([0.6] * 3)


X, Y, Z = POINT
INPUTS = {
    "position": (lambda t: t.position(), POINT),
    "object info": (lambda t: t.node("ObjectInfo").outputs["Random"], 0.4),
    "generated": (lambda t: t.node("TexCoord").outputs["Generated"], (0.1, 0.2, 0.3)),
    "object": (lambda t: t.node("TexCoord").outputs["Object"], (1, 2, 3)),
    "camera": (lambda t: t.node("TexCoord").outputs["Camera"], (4, 5, 6)),
    "window": (lambda t: t.node("TexCoord").outputs["Window"], (0.5, 0.75, 0)),
    "noise": (lambda t: t.node("TexNoise").outputs[0], 0.7),
    "noise of position": (lambda t: t.node("TexNoise", Vector=t.position()).outputs["Color"], 0.7),
    "gradient": (lambda t: t.node("TexGradient").outputs["Fac"], 0.6),
    "light path": (lambda t: t.node("LightPath").outputs["Is Shadow Ray"], 1.0),
    "math": (lambda t: t.math("POWER", t.attribute("smoke"), 2.0), 0.36),
    "vector math": (
        lambda t: t.node("VectorMath", {"operation": "LENGTH"}, Vector=t.position()).outputs["Value"],
        math.hypot(X, Y, Z),
    ),
    "map range": (
        lambda t: t.node("MapRange", Value=t.attribute("smoke"), From_Min=0.5, To_Max=10.0).outputs[0], 2.0,
    ),
    "mapping": (
        lambda t: t.node("Mapping", Vector=t.position(), Location=(1, 2, 3), Scale=(2, 2, 2)).outputs[0],
        2 * POINT + (1, 2, 3),
    ),
    "clamp": (lambda t: t.node("Clamp", Value=t.attribute("smoke"), Max=0.5).outputs[0], 0.5),
    "ramp": (lambda t: t.node("ValToRGB", Fac=t.attribute("smoke")).outputs["Color"], 0.6),
    "rgb curves": (
        lambda t: t.node("RGBCurve", Color=t.attribute("color", "Color")).outputs[0], FIELDS["color"],
    ),
    "float curve": (lambda t: t.node("FloatCurve", Value=t.attribute("smoke")).outputs[0], 0.6),
    "blackbody": (
        lambda t: t.node("Blackbody", Temperature=t.math("MULTIPLY", t.attribute("heat"), 6e3)).outputs[0],
        blackbody_rgb(1500.0),
    ),
    "separate": (
        lambda t: t.node("SeparateColor", Color=t.attribute("color", "Color")).outputs["Green"], 0.5,
    ),
    "combine": (
        lambda t: t.node("CombineColor", Red=t.attribute("smoke"), Green=t.attribute("heat")).outputs[0],
        (0.6, 0.25, 0.0),
    ),
    "hue": (
        lambda t: t.node("HueSaturation", Color=t.attribute("color", "Color"), Value=2.0).outputs[0],
        2 * FIELDS["color"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", INPUTS)
def test_inputs_of_volumes(tree, name):
    """Everything that surfaces can be driven by drives volumes too."""
    build, expected = INPUTS[name]
    seen = value_of(
        tree, build(tree), object_random=np.full(3, 0.4), generated=np.array((0.1, 0.2, 0.3)),
        object_coordinate=np.array((1.0, 2, 3)), camera_coordinate=np.array((4.0, 5, 6)),
        window_coordinate=np.array((0.5, 0.75, 0)), noise=np.full(3, 0.7), gradient=np.full(3, 0.6),
        ray_is=lambda operands, parameters, mode: np.full(3, float(mode == 0b100000)),
    )  # fmt: skip
    assert seen == pytest.approx(np.maximum(np.broadcast_to(expected, 3), 0), abs=1e-4)
    assert tree.warnings == []


@pytest.mark.parametrize(
    ("data_type", "output", "a", "b"), [("RGBA", 2, 6, 7), ("FLOAT", 0, 2, 3), ("VECTOR", 1, 4, 5)]
)
def test_mix_node(tree, data_type, output, a, b):
    node = tree.node("Mix", {"data_type": data_type})
    for socket, value in (
        (0, tree.attribute("heat")),
        (a, tree.attribute("smoke")),
        (b, tree.attribute("flame")),
    ):
        tree.set(node, socket, value)
    assert value_of(tree, node.outputs[output]) == pytest.approx([0.75 * 0.6 + 0.25 * 0.5] * 3)


@pytest.mark.parametrize("kind", ["VolumePrincipled", "VolumeScatter", "VolumeAbsorption"])
@pytest.mark.parametrize("bad", [-1e3, -1.0, 0.0, math.nan])
def test_coefficients_are_never_negative_nor_no_number(tree, kind, bad):
    inputs = {"Density": tree.attribute("smoke"), "Color": tree.attribute("color", "Color")}
    if kind == "VolumePrincipled":
        inputs |= {"Emission Strength": inputs["Density"], "Emission Color": inputs["Color"]}
        inputs |= {"Blackbody Intensity": inputs["Density"], "Temperature": inputs["Density"]}
    closures = tree.compile(tree.node(kind, **inputs))
    assert closures
    for fields in ({"smoke": bad, "color": bad}, {"smoke": 1.0, "color": bad}, {"smoke": bad, "color": 1.0}):
        for closure in closures:
            for name, value in evaluate(closure, {"density": 1.0, "temperature": 1.0} | fields).items():
                assert (value >= 0).all(), (name, fields)


def test_program_that_grows_too_large_is_left_out_and_warns(tree):
    """Each term of the sum waits for the rest of it in a register of its own."""
    top = tree.attribute("smoke")
    for k in range(260):
        top = tree.math("MULTIPLY", top, tree.math("ADD", tree.attribute("smoke"), float(k)))
    node = tree.node("VolumeScatter", Density=top)
    assert tree.compile(node) == ()
    assert any(
        "node 'Volume Scatter': the volume's node tree needs more than 256" in t for t in tree.warnings
    )


def test_long_chains_do_not_recurse(tree):
    output = tree.attribute("smoke")
    for _ in range(400):
        output = tree.math("MULTIPLY", output, 1.001)
    (closure,) = tree.compile(tree.node("VolumeScatter", Color=(1, 1, 1, 1), Density=output))
    assert closure.sigma_s == pytest.approx([1.001**400] * 3, rel=1e-3)


def test_world_volume_that_varies(bpy):
    from nephele.export.context import Context
    from nephele.export.nodes import compile_world
    from programs import with_nodes

    world = with_nodes(bpy.data.worlds.new("Air"))
    tree = world.node_tree
    output = next(n for n in tree.nodes if n.type == "OUTPUT_WORLD")
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"], scatter.inputs["Color"])
    tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    (closure,) = compile_world(world, Context(bpy.context.evaluated_depsgraph_get())).volume
    assert evaluate(closure)["sigma_s"] == pytest.approx(np.maximum(POINT, 0))
