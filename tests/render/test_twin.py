# SPDX-License-Identifier: GPL-3.0-or-later
"""The path tracer against its plain twin (integrator = plain: no light sampling, no MIS, no roulette, no
local majorants, one channel per path), and its own ways of tracking against each other, on small scenes.

Every scene is rendered with several seeds by each side. Pixels are averaged over blocks; a block's standard
error comes from the scatter between seeds, so nothing is assumed of the samples within a render. Welch's t
over all blocks and channels of a scene, Sidak-corrected: a right renderer fails one scene with probability
1e-4. Besides, the whole image's means are held together at 1e-4 per scene, which sees small biases best.
"""

from functools import cache

import numpy as np
import pytest
from comparison import assert_same, moments
from nephele import description as d
from truth import (
    RAY,
    ROUGH_BALL,
    Scene,
    box,
    constant_program,
    diffuse,
    emission,
    facing,
    glass,
    half_world,
    medium,
    perspective,
    placed,
    sphere,
)  # fmt: skip

SKY = half_world((0.3, 0.5, 1.0), (0.2, 0.15, 0.1))
SKIES_AND_SUN = half_world((0.2, 0.3, 0.5), 0.05)


def area_lamp(position, target, power, size=(1.0, 1.0), **more):
    return d.Light("area", "area", facing(position, target), (power,) * 3, size=size, **more)


def everything():
    """A grid over a floor, an area lamp, a shining ball, a sky."""
    view = perspective((0, -4, 0.6), (0, 0, -0.1), 0.4)
    scene = Scene(view, SKY, lights=(area_lamp((1.5, -0.5, 2), (0, 0, 0), 60.0),))
    scene.add_volume(ROUGH_BALL, medium((2, 3, 4), (1, 0.5, 0.1), 0.5, density_grid="density"))
    scene.add(box((-3, -3, -1.4), (3, 3, -1)), diffuse((0.8, 0.6, 0.4)))
    return scene.add(sphere(0.3, 2), emission((6.0, 4.0, 2.0)), (), placed(-1.0, -0.6, -0.3))


def chromatic_overlap():
    """Two closures in one grid, a box through it, a ball with the camera inside; all chromatic, one
    shines."""
    scene = Scene(perspective((1.0, -0.4, 0.2), (0, 0, 0)), SKY)
    scene.add_volume(
        ROUGH_BALL,
        medium((1, 4, 0), (2, 0, 1), 0.7, density_grid="density"),
        medium((0, 1, 3), (0, 0.5, 0), -0.4),
    )
    scene.add(
        box((-0.2, -1, -1), (0.6, 1, 1)), None, (medium((0.5, 0.2, 2), (0, 1, 0), emission=(0.2, 0.5, 0.1)),)
    )
    return scene.add(sphere(0.7, 2), None, (medium((2, 1, 0.5), 0.3, 0.8),), placed(0.9, -0.3, 0.1))


def glass_of_fog():
    """A smooth glass ball full of fog, a rough glass box, a white floor and a wide lamp."""
    scene = Scene(
        perspective((0, -4, 0.8), (0, 0, 0), 0.35),
        SKY,
        lights=(area_lamp((0, -1, 3), (0, 0, 0), 80.0, (2, 2)),),
    )
    scene.add(sphere(0.6, 3), glass(1.45), (medium((1, 2, 3), 0.1, 0.3),), placed(-0.5, 0, 0))
    scene.add(box((0.3, -0.4, -0.6), (0.9, 0.4, 0.3), "rough"), glass(1.3, 0.4))
    return scene.add(box((-3, -3, -1.4), (3, 3, -0.65)), diffuse(0.7))


def depth_of_field():
    """A wide lens with 5 blades in front of balls in a thin fog."""
    view = perspective((0, -3, 0.3), (0, 0, 0), 0.4, aperture_radius=0.2, blades=5, focus_distance=2.5)
    scene = Scene(view, SKY, world_volume=())
    scene.add(box((-2, -2, -1), (2, 2, 1), "fog"), None, (medium(0.3, 0.1, 0.6),))
    for x in (-0.6, 0.5):
        scene.add(sphere(0.35, 2), diffuse((0.2, 0.7, 0.9)), (), placed(x, x, 0))
    return scene.add(sphere(0.2, 1), emission(8.0), (), placed(0.1, -0.8, 0.4))


def lamps_inside():
    """Ball, soft ball, spot and area lamps amid a box of fog and a grid; one lamp casts no shadow on
    itself: none blocks another's light."""
    fog = medium((0.6, 0.5, 0.4), 0.05, 0.4)
    lights = (
        d.Light("ball", "point", placed(-0.5, 0.2, 0.4), (20.0, 15.0, 10.0), radius=0.25),
        d.Light("soft", "point", placed(0.6, 0.3, -0.5), (8.0, 8.0, 20.0), radius=0.3, soft_falloff=True),
        d.Light("spot", "spot", facing((0.9, -0.7, 0.9), (0, 0, 0)), (60.0,) * 3, radius=0.2, spot_size=1.4),
        area_lamp((0, 0.8, 0), (0, 0, 0), 10.0, (0.8, 0.5), shape="ellipse"),
        area_lamp((0, 0.8, 0), (0, 0, 0), 6.0, (0.5, 0.8), spread=1.5),  # in the same place as the one before
    )
    scene = Scene(perspective((0, -4, 0.4), (0, 0, 0), 0.35), lights=lights)
    scene.add(box((-1.2, -1.2, -1.2), (1.2, 1.2, 1.2)), None, (fog,))
    scene.add_volume(ROUGH_BALL, medium((2, 1, 0.5), 0.2, -0.2, density_grid="density"))
    return scene.add(box((-3, -3, -1.6), (3, 3, -1.3)), diffuse(0.6))


def wide_suns():
    """Two suns of 60 and 100 degrees and a sky, on a floor and a grid: light that both techniques find."""
    lights = tuple(
        d.Light(f"sun {i}", "sun", facing(towards, (0, 0, 0)), power, angle=np.radians(angle))
        for i, (towards, power, angle) in enumerate(
            (((1, 0, 2), (2.0, 1.5, 1.0), 60), ((-1, -1, 1), (1.0, 2.0, 3.0), 100))
        )
    )
    scene = Scene(perspective((0, -4, 0.8), (0, 0, -0.2), 0.4), SKIES_AND_SUN, lights=lights)
    scene.add_volume(ROUGH_BALL, medium((3, 2, 1), 0.3, 0.6, density_grid="density"))
    return scene.add(box((-3, -3, -1.4), (3, 3, -1)), diffuse(0.7))


def veils():
    """Half-transparent, shining and invisible surfaces between lamp, grid and camera; an object without
    shadow."""
    veil = constant_program(
        ("transparent", (0.7, 0.5, 0.9)), ("diffuse", (0.2, 0.3, 0.05), 0.0, None), ("emission", 0.1, 1.0)
    )
    scene = Scene(
        perspective((0, -4, 0.5), (0, 0, 0), 0.4),
        SKY,
        lights=(area_lamp((1, 0, 2.5), (0, 0, 0), 60.0, (2, 2)),),
    )
    scene.add_volume(ROUGH_BALL, medium(3, (0.2, 0.5, 1), 0.3, density_grid="density"))
    scene.add(box((-1, -1.3, -0.2), (0.8, -1.1, 1)), veil)
    return scene.add(box((-3, -3, -1.4), (3, 3, -1)), diffuse(0.6))


def endless_fog():
    """The world's own medium, which leaves one channel untouched, around a shining ball, lamps and a grid."""
    lamp = d.Light(
        "ball",
        "point",
        placed(0.8, -0.5, 0.8),
        (20.0, 10.0, 30.0),
        radius=0.2,
        visibility=d.ALL_RAYS & ~RAY["camera"],
    )
    world = (medium((0.1, 0.2, 0), (0.1, 0.02, 0), 0.5, emission=(0.02, 0.01, 0.0)),)
    scene = Scene(perspective((0, -4, 0.3), (0, 0, 0), 0.4), world_volume=world, lights=(lamp,))
    scene.add_volume(ROUGH_BALL, medium((1, 2, 3), (1, 0.5, 0), 0.2, density_grid="density"))
    return scene.add(sphere(0.3, 2), emission(5.0), (), placed(-0.9, -0.3, 0.2))


SCENES = (
    everything,
    chromatic_overlap,
    glass_of_fog,
    depth_of_field,
    lamps_inside,
    wide_suns,
    veils,
    endless_fog,
)


@pytest.mark.parametrize("make", SCENES, ids=lambda f: f.__name__)
def test_path_and_plain_twin_agree(make):
    scene, seeds = make(), 16
    path = moments(scene, seeds, 96, 6)
    plain = moments(scene, seeds, 384, 6, integrator="plain")
    assert_same(path, plain, seeds)


WAYS = ({"tracking": "delta"}, {"majorant": "global"}, {"sampler": "independent"}, {"roulette_depth": 0})
# Samples by scene, and the largest standard error, relative, of the image's mean that they leave between two
# ways: a bias of 6 of them is seen. Paths through the overlap are the longest, and the least noisy.
EFFORTS = {everything: (128, 0.004), chromatic_overlap: (48, 0.006), lamps_inside: (128, 0.015)}


@cache
def usual_way(make):
    """Returns the moments of a scene by the settings that a render has."""
    return moments(make(), 16, EFFORTS[make][0], 6)


@pytest.mark.parametrize("other", WAYS, ids=lambda s: "-".join(map(str, *s.items())))
@pytest.mark.parametrize("make", EFFORTS, ids=lambda f: f.__name__)
def test_all_ways_of_tracking_agree(make, other):
    samples, error = EFFORTS[make]
    assert_same(usual_way(make), moments(make(), 16, samples, 6, **other), 16, error)
