# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that programs describe, where the answer is known: blackbody media in balance and on their own,
emission, absorption and scattering that vary in space.

The grid is a temperature, kelvin, constant or linear in z; a program makes a medium of it inside a box. Its
radiance is the blackbody's colour times (T / 1000 K)^4; how much that is comes from the same program as a
world's, one pixel for each temperature: these tests are of transport.

False alarm: 5 standard errors, 6e-7 for each of about 60 numbers, and 1e-4 for the blocks of each furnace.
"""

import numpy as np
import pytest
import scipy.integrate
from assembler import Code, inside_box
from nephele import description as d
from truth import (
    BOX_FILTER,
    NO_LIMIT,
    Scene,
    assert_blocks,
    assert_mean,
    emission,
    orthographic,
    perspective,
)  # fmt: skip

HOT, COLD = 3000.0, 1500.0  # at z = 1 and z = -1
HALF = 1.0  # the media fill the cube from -HALF to HALF
VOXEL = 0.25


def radiance_of(code, kelvin):
    """Returns the register of a blackbody's radiance, in units of our own; kelvin: a register."""
    power = code.run("power", code.run("divide", kelvin, code.constant(1000)), code.constant(4))
    return code.run("multiply", code.run("blackbody", kelvin), power)


def shining_world(kelvin):
    code = Code()
    return code.program(("emission", 0, radiance_of(code, code.constant(kelvin)), 0))


def measured_radiance(kelvin):
    """Returns (N, 3): what the renderer makes of blackbodies at these temperatures."""
    seen = [
        Scene(orthographic((0, 0, 5), (0, 0, 0)), shining_world(k)).render(size=1, samples=1)["Combined"]
        for k in kelvin
    ]
    return np.array(seen)[:, 0, 0]


@pytest.fixture
def temperature(tmp_path, openvdb):
    """Returns a function (cold, hot) -> path of a VDB file."""

    def write(cold, hot):
        n = int(2 * HALF / VOXEL) + 5  # nodes, two beyond the box on each side
        z = (np.arange(n) - n // 2) * VOXEL
        kelvin = cold + (hot - cold) * (z + HALF) / (2 * HALF)
        grid = openvdb.FloatGrid()
        grid.name = "temperature"
        grid.copyFromArray(np.broadcast_to(kelvin, (n, n, n)).astype(np.float32).copy())
        grid.transform = openvdb.createLinearTransform(VOXEL)
        path = tmp_path / f"{cold:g}-{hot:g}.vdb"
        openvdb.write(str(path), [grid])
        origin = np.eye(4)
        origin[:3, 3] = -(n // 2) * VOXEL
        return path, origin

    return write


def blackbody_medium(sigma_s, sigma_a, g=0.0):
    """Returns the closure of a medium in local thermal balance: it emits sigma_a times its radiance."""
    code = Code()
    inside = inside_box(code, -HALF, HALF)
    absorbed = code.run("multiply", inside, code.constant(sigma_a))
    kelvin = code.run("grid", code.run("position"), mode=0)
    shining = code.run("multiply", absorbed, radiance_of(code, kelvin))
    scattered = code.run("multiply", inside, code.constant(sigma_s))
    medium = ("medium", 0, scattered, absorbed, shining, code.constant(g), code.constant(0))
    return d.VolumeClosure(program=code.program(medium), grids=("temperature",))


def test_blackbody_slab_shines_like_a_blackbody_as_it_thickens(temperature):
    """Of one temperature, alone: B (1 - exp(-sigma_a d)); B in the limit."""
    path, placed = temperature(2000.0, 2000.0)
    B = measured_radiance([2000.0])[0]
    for sigma_a in (np.array([0.1, 0.5, 1.0]), np.array([2.0, 5.0, 20.0])):
        scene = Scene(orthographic((0.1, 5, 0.2), (0.1, 0, 0.2)))
        scene.add_volume(path, blackbody_medium(0.0, sigma_a), world_from_object=placed)
        image = scene.render(size=48, samples=64, **BOX_FILTER)["Combined"]
        assert_mean(image, B * -np.expm1(-sigma_a * 2 * HALF), rounding=2e-4, most=0.01)


@pytest.mark.parametrize("side", [1, -1], ids=["hot side", "cold side"])
def test_blackbody_slab_of_a_gradient_of_temperature(temperature, side):
    """The integral of sigma_a B(T(z)) exp(-sigma_a depth), seen from either end."""
    path, placed = temperature(COLD, HOT)
    sigma_a = np.array([0.3, 1.0, 4.0])
    depth = np.linspace(0, 2 * HALF, 41)
    kelvin = COLD + (HOT - COLD) * (depth if side < 0 else depth[::-1]) / (2 * HALF)
    B = measured_radiance(kelvin)
    kernel = sigma_a * B * np.exp(-np.outer(depth, sigma_a))
    scene = Scene(orthographic((0.1, 0.2, 5 * side), (0.1, 0.2, 0)))
    scene.add_volume(path, blackbody_medium(0.0, sigma_a), world_from_object=placed)
    image = scene.render(size=48, samples=256, **BOX_FILTER)["Combined"]
    assert_mean(image, scipy.integrate.simpson(kernel, x=depth, axis=0), rounding=1e-3, most=0.01)


@pytest.mark.parametrize("integrator", ["path", "plain"])
def test_isothermal_furnace(temperature, integrator):
    """A medium that absorbs, scatters and shines at the temperature of the world around it is not to be
    seen."""
    path, placed = temperature(2500.0, 2500.0)
    B = measured_radiance([2500.0])[0]
    medium = blackbody_medium((1.0, 2.0, 4.0), (0.5, 1.0, 0.2), 0.5)
    scene = Scene(perspective((3.1, -1.2, 0.9), (0, 0, 0)), shining_world(2500.0))
    scene.add_volume(path, medium, world_from_object=placed)
    image = scene.render(size=32, samples=128, seed=3, integrator=integrator, **NO_LIMIT, **BOX_FILTER)[
        "Combined"
    ]
    assert_mean(image, B, rounding=2e-4, most=0.01)
    for channel in range(3):
        assert_blocks(image[..., channel : channel + 1], B[channel], rounding=3e-4)


def colored_medium(sigma_s, sigma_a, low, high, g=0.0):
    """Returns the closure of a program's medium that fills a box, sigma_s falling to a half along x."""
    code = Code()
    inside = inside_box(code, low, high)
    x = code.run("channel", code.run("position"), mode=0)
    ramp = code.run("multiply_add", x, code.constant(-0.25), code.constant(0.75))
    scattered = code.run("multiply", code.run("multiply", inside, ramp), code.constant(sigma_s))
    absorbed = code.run("multiply", inside, code.constant(sigma_a))
    none = code.constant(0)
    program = code.program(("medium", 0, scattered, absorbed, none, code.constant(g), none))
    return d.VolumeClosure(program=program, grids=("temperature",))


@pytest.mark.parametrize("settings", [{}, {"tracking": "delta"}, {"integrator": "plain"}], ids=str)
def test_furnace_of_overlapping_programs(temperature, settings):
    """Two chromatic media without absorption, which vary and overlap, under a white world: 1 everywhere."""
    path, placed = temperature(1000.0, 1000.0)
    one = colored_medium((1, 2, 4), 0, (-1, -1, -1), (0.5, 1, 1), 0.7)
    other = colored_medium((3, 1, 0.5), 0, (-0.5, -0.8, -1), (1, 0.8, 1), -0.3)
    scene = Scene(perspective((3.1, -1.2, 0.9), (0, 0, 0)), emission(1.0))
    scene.add_volume(path, one, other, world_from_object=placed)
    image = scene.render(size=32, samples=128, seed=3, **NO_LIMIT, **BOX_FILTER, **settings)["Combined"]
    assert_mean(image, 1.0, rounding=2e-6, most=0.01)
    assert_blocks(image, 1.0, rounding=1e-5)


def test_transmittance_through_overlapping_programs(temperature):
    path, placed = temperature(1000.0, 1000.0)
    one = colored_medium(0, (0.2, 0.5, 1.0), (-1, -1, -1), (0.5, 1, 1))
    other = colored_medium(0, (1.0, 0.3, 0.1), (-0.5, -1, -1), (1, 1, 1))
    scene = Scene(orthographic((5, 0.1, 0.2), (0, 0.1, 0.2)), emission(1.0))
    scene.add_volume(path, one, other, world_from_object=placed)
    expected = np.exp(-1.5 * np.array([1.2, 0.8, 1.1]))
    images = scene.render(("Combined", "Transmittance"), size=48, samples=64, **BOX_FILTER)
    for image in images.values():
        assert_mean(image, expected, rounding=2e-4, most=0.01)
