# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights and the world."""

import math

import numpy as np
import pytest
from nephele.export.blackbody import blackbody_rgb
from programs import with_nodes


@pytest.fixture
def light(bpy, link):
    """Returns a function (type) -> data of a new light in the scene."""

    def make(kind):
        data = bpy.data.lights.new("Lamp", kind)
        link("Lamp", data)
        return data

    return make


def test_point(light, export):
    data = light("POINT")
    data.energy, data.color, data.shadow_soft_size, data.use_soft_falloff = 12.0, (1.0, 0.5, 0.25), 0.3, True
    (result,) = export().lights
    assert result.kind == "point"
    assert result.power == pytest.approx((12.0, 6.0, 3.0))
    assert (result.radius, result.soft_falloff, result.normalize) == (pytest.approx(0.3), True, True)
    assert result.visibility == 0b111110  # Blender hides new lights from the camera


def test_spot(light, export):
    data = light("SPOT")
    data.spot_size, data.spot_blend, data.use_shadow = 0.6, 0.4, False
    (result,) = export().lights
    assert (result.kind, result.cast_shadow) == ("spot", False)
    assert (result.spot_size, result.spot_blend) == pytest.approx((0.6, 0.4))


def test_sun(light, export):
    data = light("SUN")
    data.angle, data.energy = 0.01, 3.0
    (result,) = export().lights
    assert (result.kind, result.angle, result.power) == ("sun", pytest.approx(0.01), (3.0, 3.0, 3.0))


@pytest.mark.parametrize(
    ("shape", "expected"),
    [
        ("SQUARE", ("rectangle", (2.0, 2.0))),
        ("RECTANGLE", ("rectangle", (2.0, 3.0))),
        ("DISK", ("ellipse", (2.0, 2.0))),
        ("ELLIPSE", ("ellipse", (2.0, 3.0))),
    ],
)
def test_area(light, export, shape, expected):
    data = light("AREA")
    data.shape, data.size, data.size_y, data.spread = shape, 2.0, 3.0, math.radians(60)
    (result,) = export().lights
    assert (result.shape, result.size) == expected
    assert result.spread == pytest.approx(math.radians(60))


@pytest.mark.skipif("__import__('bpy').app.version < (4, 5, 0)", reason="Blender has these since 4.5")
def test_exposure_temperature_normalize(light, export):
    data = light("POINT")
    data.energy, data.exposure, data.use_temperature, data.temperature, data.normalize = (
        1.0,
        2.0,
        True,
        3000.0,
        False,
    )
    (result,) = export().lights
    assert result.power == pytest.approx(tuple(4 * c for c in data.temperature_color), rel=1e-5)
    assert not result.normalize


@pytest.mark.skipif(
    "__import__('bpy').app.version < (4, 5, 0)", reason="Blender has temperature_color since 4.5"
)
@pytest.mark.parametrize("kelvin", [1500, 2700, 4000, 6500, 9000, 12000])
def test_blackbody_agrees_with_blender(light, kelvin):
    """To 0.2 % of the largest channel: Blender fits the colours, we tabulate the observer."""
    data = light("POINT")
    data.use_temperature, data.temperature = True, kelvin
    expected = np.array(data.temperature_color)
    assert np.abs(blackbody_rgb(kelvin) - expected).max() < 0.002 * expected.max()


def test_visibility_of_a_light(bpy, light, export):
    light("POINT")
    bpy.data.objects["Lamp"].visible_glossy = False
    assert export().lights[0].visibility == 0b111010


def test_constant_nodes_scale_the_power(bpy, light, export):
    data = light("POINT")
    data.energy, data.use_nodes = 10.0, True
    emission = data.node_tree.nodes["Emission"]
    emission.inputs["Color"].default_value = (1.0, 0.5, 0.0, 1.0)
    emission.inputs["Strength"].default_value = 3.0
    scene = export()
    assert scene.lights[0].power == pytest.approx((30.0, 15.0, 0.0))
    assert scene.warnings == ()


@pytest.mark.parametrize("output", ["Quadratic", "Linear"])
def test_light_falloff_in_a_light(bpy, light, export, output):
    data = light("POINT")
    data.energy, data.use_nodes = 10.0, True
    falloff = data.node_tree.nodes.new("ShaderNodeLightFalloff")
    falloff.inputs["Strength"].default_value = 7.0
    data.node_tree.links.new(falloff.outputs[output], data.node_tree.nodes["Emission"].inputs["Strength"])
    scene = export()
    assert scene.warnings == ()
    lamp = scene.lights[0]
    if output == "Quadratic":  # as usual
        assert (lamp.power, lamp.program) == ((70.0, 70.0, 70.0), None)
    else:
        assert (lamp.power, len(lamp.program.code)) == ((10.0, 10.0, 10.0), 2)


def test_other_nodes_in_a_light_are_its_program(bpy, light, export):
    data = light("POINT")
    data.use_nodes = True
    wave = data.node_tree.nodes.new("ShaderNodeTexWave")
    data.node_tree.links.new(wave.outputs[0], data.node_tree.nodes["Emission"].inputs["Strength"])
    scene = export()
    assert scene.warnings == ()
    assert scene.lights[0].power == (10.0, 10.0, 10.0)
    assert len(scene.lights[0].program.code) > 0


def test_no_world_is_black(export):
    world = export().world
    assert (world.background, world.volume) == (None, ())


def test_background(bpy, export):
    world = bpy.context.scene.world = with_nodes(bpy.data.worlds.new("World"))
    background = world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    background.inputs["Strength"].default_value = 2.0
    program = export().world.background
    (closure,) = program.closures
    assert closure.kind == "emission"
    assert np.allclose(program.registers[closure.inputs[0]], (0.1, 0.2, 0.3))
    assert np.allclose(program.registers[closure.inputs[1]], 2.0)


def test_world_volume(bpy, export):
    world = bpy.context.scene.world = with_nodes(bpy.data.worlds.new("World"))
    tree = world.node_tree
    scatter = tree.nodes.new("ShaderNodeVolumeScatter")
    scatter.inputs["Density"].default_value = 0.05
    tree.links.new(scatter.outputs[0], tree.nodes["World Output"].inputs["Volume"])
    (closure,) = export().world.volume
    assert closure.sigma_s == pytest.approx((0.04, 0.04, 0.04))
    assert closure.density_grid is None
