# SPDX-License-Identifier: GPL-3.0-or-later
"""Subsurface scattering: white furnaces, the colour of what is set, the plain twin, holes of holdouts.

The medium below a surface is a random walk of our own; test_surfaces_against_cycles.py holds it beside
Cycles."""

import numpy as np
import pytest
from comparison import assert_same, moments
from nephele import description as d
from nephele import opcodes
from test_twin import SKY, area_lamp
from truth import (
    BOX_FILTER,
    NO_LIMIT,
    Scene,
    assert_mean,
    box,
    constant_program,
    diffuse,
    emission,
    estimate,
    orthographic,
    perspective,
    placed,
    sphere,
)

VIEW = perspective((0, -4, 0), (0, 0, 0), 0.14)  # within a ball of radius 1
METHODS = opcodes.SUBSURFACE_METHODS


def below(color, radius, method="burley", roughness=1.0, g=0.0):
    """Returns the program of a subsurface closure; radius: metres, of all channels or three."""
    program = constant_program(("subsurface", color, 1.0, radius, 1.4, roughness, g, None))
    (row,) = program.closures
    return d.Program(program.registers, closures=(d.Closure(row.kind, 0, row.inputs, METHODS.index(method)),))


@pytest.mark.parametrize("method", ["burley", "random_walk_skin"])
def test_a_white_ball_vanishes_in_a_white_world(method):
    """Nothing absorbs, so that each pixel is 1, but for walks that are cut off. (The method random_walk takes
    the mean free path for 0 where the colour is white.)"""
    scene = Scene(VIEW, emission(1.0)).add(sphere(1.0, 2), below(1.0, 4.0, method))
    image = scene.render(size=16, samples=64, seed=1, **NO_LIMIT, **BOX_FILTER)["Combined"]
    assert_mean(image, 1.0, rounding=2e-3, most=0.0025)


@pytest.mark.parametrize("method", METHODS)
def test_a_flat_surface_has_its_colour(method):
    """A face far larger than the radius, seen straight on. Entry by refraction depends on the angle: the
    tolerance holds it, 0.03."""
    color = np.array((0.8, 0.5, 0.2))
    view = orthographic((0, 0, 4), (0, 0, 0), 0.5)
    scene = Scene(view, emission(1.0)).add(box((-4, -4, -4), (4, 4, 0)), below(color, 0.3, method))
    image = scene.render(size=16, samples=64, seed=1, **NO_LIMIT, **BOX_FILTER)["Combined"]
    assert np.all(np.abs(estimate(image).mean - color) < 0.03)


def test_path_and_plain_twin_agree_below_the_surface():
    """A ball of wax over a floor, beside a lamp: false alarm and standard errors of comparison.py."""
    scene = Scene(
        perspective((0, -4, 0.8), (0, 0, 0), 0.25),
        SKY,
        lights=(area_lamp((1.5, -1, 2), (0, 0, 0), 60.0, (2, 2)),),
    )
    scene.add(sphere(0.6, 2), below((0.8, 0.5, 0.3), (2.0, 1.0, 0.5), roughness=0.3, g=0.3))
    scene.add(box((-3, -3, -1.4), (3, 3, -0.65)), diffuse(0.7))
    path = moments(scene, 16, 48, 6, size=12)
    plain = moments(scene, 16, 192, 6, size=12, integrator="plain")
    assert_same(path, plain, 16, error=0.04)


@pytest.mark.parametrize("integrator", ["path", "plain"])
def test_a_holdout_is_a_hole(integrator):
    """A box of it, and a ball before the box: there the film is full, elsewhere empty and black."""
    import nephele_native

    program = constant_program(("holdout",))
    scene = Scene(VIEW, emission(1.0)).add(box((-1, -1, -1), (1, 1, 1)), program)
    scene.add(sphere(0.2, 1), emission(1.0), (), placed(0, -2, 0))
    renderer = nephele_native.Renderer(
        scene.description(size=16, samples=4, transparent=True, integrator=integrator, **BOX_FILTER)
    )
    renderer.start()
    assert renderer.wait(60)
    image = renderer.read_pass("Combined")
    np.testing.assert_allclose(image[:3, :3], 0, atol=1e-6)
    np.testing.assert_allclose(image[7:9, 7:9, 3], 1, atol=1e-6)
