# SPDX-License-Identifier: GPL-3.0-or-later
"""White furnaces: where nothing absorbs, under a uniform world of radiance 1, every pixel is 1. And its
twin with emission: a medium that shines with j in balance with its absorption has radiance j / sigma_a
everywhere.

False alarms: the image's mean may be off by 5 standard errors (6e-7 per channel). Besides, the means of
blocks of 4 x 4 pixels are held to 1 by Student's t with 15 degrees of freedom, all blocks and channels of an
image together at 1e-4 (Sidak): a bias of some pixels alone (a silhouette, a seam, an edge shared by
triangles) shows there.
"""

import numpy as np
import pytest
from nephele import description as d
from truth import (
    BOX_FILTER,
    NO_LIMIT,
    ROUGH_BALL,
    Scene,
    assert_blocks,
    assert_mean,
    box,
    constant_program,
    diffuse,
    emission,
    glass,
    joined,
    medium,
    orthographic,
    perspective,
    placed,
    sphere,
)  # fmt: skip

OUTSIDE, INSIDE = ((3.1, -1.2, 0.9), (0, 0, 0)), ((0.1, 0.05, -0.1), (1, 0.3, 0.2))
WHITE = emission(1.0)
SIGMA_S = {"grey": (3.0, 3.0, 3.0), "chromatic": (1.0, 3.0, 8.0)}


def check(scene, expected=1.0, samples=384, most=0.004, **settings):
    image = scene.render(size=32, samples=samples, seed=3, **NO_LIMIT, **BOX_FILTER, **settings)["Combined"]
    assert_mean(image, expected, rounding=2e-6, most=most)
    assert_blocks(image, expected, rounding=1e-5)


@pytest.mark.parametrize("view", [OUTSIDE, INSIDE], ids=["outside", "inside"])
@pytest.mark.parametrize("g", [-0.7, 0.0, 0.8])
@pytest.mark.parametrize("color", SIGMA_S)
def test_furnace_of_a_homogeneous_mesh(view, g, color):
    check(
        Scene(perspective(*view), WHITE).add(
            box((-1, -1, -1), (1, 1, 1)), None, (medium(SIGMA_S[color], g=g),)
        )
    )


@pytest.mark.parametrize("view", [OUTSIDE, INSIDE], ids=["outside", "inside"])
@pytest.mark.parametrize("g", [-0.7, 0.0, 0.8])
@pytest.mark.parametrize("color", SIGMA_S)
def test_furnace_of_a_grid(view, g, color):
    check(
        Scene(perspective(*view), WHITE).add_volume(
            ROUGH_BALL, medium(SIGMA_S[color], g=g, density_grid="density")
        )
    )


@pytest.mark.parametrize(
    "settings",
    [{"tracking": "delta"}, {"majorant": "global"}, {"sampler": "independent"}, {"roulette_depth": 0}],
    ids=lambda s: "-".join(map(str, *s.items())),
)
def test_furnace_of_overlapping_chromatic_media(settings):
    """A grid with two closures, two meshes that cut through it, one of them around the camera."""
    closures = (
        medium((1, 2, 4), g=0.7, density_grid="density"),
        medium((2, 1, 0.5), g=-0.3, density_grid="density"),
    )
    scene = Scene(perspective((1.2, 0.1, 0.2), (0, 0, 0)), WHITE).add_volume(ROUGH_BALL, *closures)
    scene.add(box((0, -1, -1), (1.5, 1, 1), "right"), None, (medium((0.2, 1, 3), g=0.5),))
    scene.add(sphere(0.8, 2), None, (medium((2, 0.3, 0), g=0.0),), placed(0.4, 0.3, 0))
    check(scene, **settings)


@pytest.mark.parametrize("view", [OUTSIDE, INSIDE], ids=["outside", "inside"])
def test_furnace_of_a_nested_shell(view):
    """One mesh of two spheres, the inner one turned inwards: the medium lies between them."""
    shell = joined(sphere(1.0, 3), sphere(0.6, 3, inwards=True))
    check(Scene(perspective(*view), WHITE).add(shell, None, (medium((2, 4, 6), g=0.3),)))


def test_furnace_of_white_diffuse_surfaces():
    scene = Scene(perspective((0, -4, 1.5), (0, 0, 0.3)), WHITE)
    scene.add(box((-5, -5, -2), (5, 5, -0.5), "floor"), diffuse(1.0)).add(sphere(0.7, 3), diffuse(1.0))
    check(scene)


def test_furnace_of_white_plastic():
    plastic = constant_program(("plastic", 1.0, 0.0, 1.5, 1.0, None))
    scene = Scene(perspective((0, -4, 1.5), (0, 0, 0.3)), WHITE)
    check(
        scene.add(box((-5, -5, -2), (5, 5, -0.5), "floor"), plastic).add(box((-1, -1, 0), (1, 1, 1)), plastic)
    )


@pytest.mark.parametrize("nonlinear", [0.0, 1.0])
def test_a_plastic_plane_loses_what_its_base_absorbs(nonlinear):
    """At 60 degrees: its coat mirrors F; of the rest, the base returns by its colour what the coat lets out,
    n = 1.5. Between base and coat light goes on by the share that the coat throws back from below."""
    color, n, cosine = np.array((0.9, 0.5, 0.1)), 1.5, 0.5
    below = np.sqrt(1 - (1 - cosine**2) / n**2)
    across, along = (cosine - n * below) / (cosine + n * below), (n * cosine - below) / (n * cosine + below)
    mirrored = (across**2 + along**2) / 2
    back = 1 - (1 - 0.0917780) / n**2  # 0.0917780: mean of F over the hemisphere, integrated numerically
    again = color if nonlinear else 1.0
    expected = mirrored + (1 - mirrored) * color * (1 - back) / (1 - again * back)
    camera = orthographic((0, -4 * np.sqrt(0.75), 2), (0, 0, 0), 1)
    scene = Scene(camera, WHITE).add(
        box((-9, -9, -2), (9, 9, 0), "plane"), constant_program(("plastic", color, 0.0, n, nonlinear, None))
    )
    # A pixel takes one of few values, by how often the coat was chosen: Student's t of 16 says nothing.
    image = scene.render(size=32, samples=384, seed=3, **NO_LIMIT, **BOX_FILTER)["Combined"]
    assert_mean(image, expected, rounding=2e-6, most=0.004)


@pytest.mark.parametrize("roughness", [0.0, 0.3])
def test_furnace_of_lossless_glass_with_a_medium_inside(roughness):
    """Rough glass by multiple-scattering GGX would be exact too; single scattering is what mode 0 means,
    so only the smooth one conserves energy, and the rough one must not gain any."""
    scene = Scene(perspective((0, -4, 1.0), (0, 0, 0)), WHITE)
    scene.add(sphere(0.8, 4), glass(1.5, roughness), (medium((1, 2, 3), g=0.5),))
    if roughness == 0:
        check(scene, most=0.01)
    else:
        image = scene.render(size=32, samples=64, **NO_LIMIT)["Combined"]
        assert image.mean() <= 1.001
        assert image.mean() >= 0.9


def test_furnace_of_a_white_room_in_a_medium():
    """Surfaces inside media inside media: a diffuse ball in a grid in a box."""
    scene = Scene(perspective(*OUTSIDE), WHITE).add_volume(
        ROUGH_BALL, medium((2, 2, 2), g=0.4, density_grid="density")
    )
    scene.add(sphere(0.5, 3), diffuse(1.0)).add(
        box((-1, -1, -1), (1, 1, 1)), None, (medium((0.5, 1, 2), g=0.0),)
    )
    check(scene)


@pytest.mark.parametrize("g", [-0.7, 0.0, 0.8])
def test_shining_world_in_balance(g):
    """An endless medium, sigma_s over sigma_a different in each channel, with white surfaces in it and no
    light but its own: radiance j / sigma_a everywhere."""
    sigma_s, sigma_a, j = np.array([1.0, 2.0, 0.5]), np.array([0.5, 1.0, 2.0]), np.array([2.0, 1.0, 3.0])
    shining = d.VolumeClosure(tuple(sigma_s), tuple(sigma_a), tuple(j), d.Phase(a=g))
    scene = Scene(perspective((0, -4, 0.5), (0, 0, 0)), world_volume=(shining,)).add(
        sphere(1.0, 3), diffuse(1.0)
    )
    check(scene, j / sigma_a, most=0.01)


def test_shining_box_in_balance_with_the_world():
    """Inside and outside a box of absorbing, scattering and shining medium the world's radiance is j /
    sigma_a."""
    shining = d.VolumeClosure((1, 2, 0), (0.5, 1, 2), (0.5, 1, 2), d.Phase(a=0.5))
    for view in (OUTSIDE, INSIDE):
        check(Scene(perspective(*view), WHITE).add(box((-1, -1, -1), (1, 1, 1)), None, (shining,)))
