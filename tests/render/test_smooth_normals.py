# SPDX-License-Identifier: GPL-3.0-or-later
"""Coarse meshes with smooth normals: these stand off their faces by up to 40 degrees, and directions near the
horizon are above the one and below the other. No light may be lost there, nor leak through what is opaque,
nor may the terminator show the faces.

False alarms: means may be off by 5 standard errors (6e-7 per number).
"""

import dataclasses

import numpy as np
import pytest
from nephele import description as d
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
    facing,
    glass,
    half_world,
    perspective,
    sphere,
)  # fmt: skip

VIEW = (0, -4, 1), (0, 0, 0)
HALF_PICTURE = 0.28  # a ball of radius 1 fills it


def smooth(mesh):
    """Returns the mesh with normals that point away from the origin."""
    normals = mesh.positions / np.linalg.norm(mesh.positions, axis=1, keepdims=True)
    return dataclasses.replace(mesh, corner_normals=np.ascontiguousarray(normals[mesh.triangles], np.float32))


def ball(subdivisions):
    return smooth(sphere(1.0, subdivisions))


def principled(metallic=0.0, transmission=0.0, roughness=0.5):
    base = (1.0, metallic, roughness, 1.5, 1.0, None, 0.5, 1.0, transmission)
    coat, sheen, shine = (0.0, 0.03, 1.5, 1.0, None), (0.0, 0.5, 1.0), (0.0, 0.0)
    brushed, below, film = (0.0, 0.0, 0.0, None), (0.0, 0.0, 0.0, 1.4, 0.0), (0.0, 1.33)
    return constant_program(("principled", *base, *coat, *sheen, *shine, *brushed, *below, *film))


def furnace(mesh, surface, samples=64):
    scene = Scene(perspective(*VIEW, HALF_PICTURE), emission(1.0)).add(mesh, surface)
    return scene.render(samples=samples, seed=1, **NO_LIMIT, **BOX_FILTER)["Combined"]


@pytest.mark.parametrize("subdivisions", [0, 1, 2])
@pytest.mark.parametrize(
    "surface",
    [
        diffuse(1.0),
        constant_program(("diffuse", 1.0, 0.7, None)),
        constant_program(("translucent", 1.0, None)),
        constant_program(("glossy", 1.0, 0.0, None)),
    ],
    ids=["diffuse", "rough diffuse", "translucent", "mirror"],
)
def test_lossless_surfaces_lose_nothing(surface, subdivisions):
    assert_mean(furnace(ball(subdivisions), surface), 1.0, rounding=2e-6, most=0.002)


@pytest.mark.parametrize(("subdivisions", "loss"), [(0, 2e-3), (1, 2e-4), (2, 2e-4)])
@pytest.mark.parametrize(
    "surface", [glass(1.5), principled(transmission=1.0, roughness=0.0)], ids=["glass", "principled"]
)
def test_smooth_glass_loses_next_to_nothing(surface, subdivisions, loss):
    """Smooth normals let a few paths circle inside for ever: the rest of the light is all there."""
    mean = furnace(ball(subdivisions), surface).mean()
    assert 1 - loss <= mean <= 1 + 1e-5


@pytest.mark.parametrize("subdivisions", [0, 1, 2])
@pytest.mark.parametrize(
    "surface",
    [glass(1.5, 0.2), principled(), principled(metallic=1.0), principled(transmission=1.0)],
    ids=["rough glass", "plastic", "metal", "frosted"],
)
def test_smooth_normals_cost_rough_surfaces_nothing_more(surface, subdivisions):
    """Held against the same mesh with flat normals: these lobes' energy is their own matter."""
    bare = estimate(furnace(sphere(1.0, subdivisions), surface, 128))
    e = estimate(furnace(ball(subdivisions), surface, 128))
    assert np.all(np.abs(e.mean - bare.mean) <= 0.004 + 5 * np.hypot(e.error, bare.error))


@pytest.mark.parametrize("subdivisions", [0, 1])
@pytest.mark.parametrize("surface", [diffuse(0.8), principled(roughness=0.3)], ids=["diffuse", "principled"])
def test_closed_rooms_are_dark(surface, subdivisions):
    """Bright outside: not a single path of 32 bounces gets in."""
    camera = perspective((0.1, 0.05, -0.1), (1, 0.3, 0.2), 2.0)
    scene = Scene(camera, emission(1.0)).add(ball(subdivisions), surface)
    assert scene.render(samples=256, seed=1, max_bounces=32, surface_bounces=32)["Combined"].max() == 0


@pytest.mark.parametrize("subdivisions", [1, 2])
def test_the_terminator_shows_no_faces(subdivisions):
    """A sun from the side: every point is as bright as its smooth normal says, on faces turned away too."""
    to_sun = np.array([0.9, -0.3, 0.3]) / np.linalg.norm([0.9, -0.3, 0.3])
    sun = d.Light("sun", "sun", facing(to_sun, (0, 0, 0)), (np.pi, np.pi, np.pi))
    scene = Scene(perspective(*VIEW, HALF_PICTURE), lights=[sun]).add(ball(subdivisions), diffuse(1.0))
    limits = {"max_bounces": 0, "surface_bounces": 0}
    images = scene.render(("Combined", "Normal"), size=128, samples=16, seed=1, **limits, **BOX_FILTER)
    cosine = images["Normal"] @ to_sun
    lit = cosine > 0.05
    ratio = images["Combined"][lit].mean(-1) / cosine[lit]
    assert ratio.min() > 0.999
    assert ratio.max() < 1.001


@pytest.mark.parametrize("subdivisions", [0, 1])
@pytest.mark.parametrize("surface", [diffuse(0.8), principled(roughness=0.4)], ids=["diffuse", "plastic"])
def test_light_sampling_agrees_with_running_into_light(surface, subdivisions):
    """Whichever way light is found, rays leave from the same points: the path tracer against its twin."""
    scene = Scene(perspective(*VIEW, HALF_PICTURE), half_world(1.0)).add(ball(subdivisions), surface)
    scene.add(box((-3, -3, -3), (3, 3, -1.2)), emission((0.2, 1.0, 3.0)))
    limits = {"max_bounces": 8, "surface_bounces": 8}
    twin, path = (
        scene.render(samples=samples, seed=seed, integrator=name, **limits, **BOX_FILTER)["Combined"]
        for name, samples, seed in (("plain", 512, 1), ("path", 128, 2))
    )
    assert_mean(1 + twin - path, 1.0, most=0.005)
