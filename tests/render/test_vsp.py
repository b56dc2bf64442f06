# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume scattering probability guiding changes no expectation: every way of sampling the camera ray's
distance, every criterion, control and extension, right and deliberately wrong targets, trained or not, give
the image of delta tracking. See comparison.py for the statistics and their false alarms."""

from functools import cache

import numpy as np
import pytest
import scipy.stats
from comparison import assert_same, moments
from nephele import description as d
from nephele import passes as pass_table
from test_twin import chromatic_overlap, endless_fog, everything, lamps_inside, veils
from truth import Scene, box, diffuse, emission, half_world, medium, perspective, placed

SEEDS, BLOCK = 16, 8
BARE = {"vsp_product": False, "vsp_gather": False, "vsp_cost": False}
WAYS = {
    "nds": {"distance_sampling": "nds"},
    "nds_plus": {"distance_sampling": "nds_plus"},
    "published": {**BARE, "vsp_control": "exact", "vsp_criterion": "contribution"},
    "exact": {**BARE, "vsp_control": "exact", "vsp_defensive": 1.0},
    "bare": BARE,
    "contribution": {**BARE, "vsp_criterion": "contribution"},
    "cost": {**BARE, "vsp_cost": True},
    "product": {**BARE, "vsp_product": True},
    "gather": {**BARE, "vsp_gather": True},
    "exact_all_on": {"vsp_control": "exact"},
    "all_on": {},
    "kdtree": {"majorant": "kdtree"},
    "lowest": {"vsp_control": "exact", "vsp_target": "lowest"},
    "highest": {"vsp_control": "exact", "vsp_target": "highest"},
    "random": {"vsp_target": "random"},
    "exact_random": {"vsp_control": "exact", "vsp_target": "random"},
    "independent": {"sampler": "independent"},
}
# Samples by scene, and the largest standard error, relative, of the image's mean between two ways.
EFFORTS = {
    everything: (32, 0.012),
    chromatic_overlap: (24, 0.012),
    lamps_inside: (32, 0.04),
    endless_fog: (24, 0.04),
    veils: (24, 0.02),
}


# The world's fog there leaves one channel untouched, and makes the others certain to scatter: by these ways
# one path in a thousand carries all light of that channel, and no feasible number of samples is enough for a
# normal mean. Their image means at 400 samples agree all the same.
TOO_RARE = {(endless_fog, "exact"), (endless_fog, "nds_plus")}
PAIRS = [(make, way) for make in EFFORTS for way in WAYS if (make, way) not in TOO_RARE]


@cache
def by_delta_tracking(make):
    """Returns the moments of a scene without guiding."""
    return moments(make(), SEEDS, 2 * EFFORTS[make][0], BLOCK, seed=1000, distance_sampling="delta")


@pytest.mark.parametrize(("make", "way"), PAIRS, ids=lambda x: x if isinstance(x, str) else x.__name__)
def test_no_way_of_guiding_changes_the_image(make, way):
    samples, error = EFFORTS[make]
    assert_same(by_delta_tracking(make), moments(make(), SEEDS, samples, BLOCK, **WAYS[way]), SEEDS, error)


def glow():
    """A lit wall behind a thick, shining ball and a thin box of fog: much to learn, little to render."""
    sky = half_world((0.6, 0.7, 1.0), 0.2)
    lamp = d.Light("lamp", "point", placed(0.2, -0.6, 0.9), (15.0, 10.0, 5.0), radius=0.1)
    scene = Scene(perspective((0, -4, 0.2), (0, 0, 0), 0.35), sky, lights=(lamp,))
    scene.add(box((-1.2, -1.0, -1.2), (0.2, 1.0, 1.2)), None, (medium((0.4, 0.3, 0.2), 0.05),))
    scene.add(box((0.3, -0.5, -0.6), (1.2, 0.5, 0.6)), None, (medium(4.0, 1.0, emission=(0.1, 0.05, 0.0)),))
    return scene.add(box((-2, 1.2, -2), (2, 1.4, 2)), diffuse(0.7))


SMALL = {"max_bounces": 3, "roulette_depth": 8}


@cache
def glow_by_delta_tracking():
    """Returns (mean, squared standard error) of the image's mean."""
    means = []
    for seed in range(64):
        image = glow().render(size=8, samples=512, seed=5000 + seed, distance_sampling="delta", **SMALL)
        means.append(image["Combined"].mean((0, 1)))
    return np.mean(means, 0), np.var(means, 0, ddof=1) / len(means)


@pytest.mark.parametrize("control", ["exact", "conditional"])
@pytest.mark.parametrize("samples", [1, 2, 4, 8])
def test_learning_is_no_bias(samples, control):
    """The mean over 1000 seeds is right however few samples a render has and learns from: z-test of three
    channels, false alarm 1e-4 for each of the eight cases."""
    scene, expected = glow(), glow_by_delta_tracking()
    means = [
        scene.render(size=8, samples=samples, seed=seed, vsp_control=control, **SMALL)["Combined"].mean(
            (0, 1)
        )
        for seed in range(1000)
    ]
    error2 = np.var(means, 0, ddof=1) / len(means) + expected[1]
    z = np.abs(np.mean(means, 0) - expected[0]) / np.sqrt(error2)
    assert np.all(z < scipy.stats.norm.isf(1e-4 / 6)), z
    assert np.all(np.sqrt(error2) < 0.02 * expected[0]), "too noisy to tell"


@pytest.mark.parametrize("target", ["lowest", "highest", "random"])
def test_what_is_achieved_is_what_was_wanted(target):
    """Exact control without a defensive share, in a homogeneous medium that every camera ray crosses: the
    count of scattered paths over the image is binomial, false alarm 1e-4."""
    scene = Scene(perspective((0, -4, 0), (0, 0, 0), 0.1), emission(1.0))
    scene.add(box((-2, -1, -2), (2, 1, 2)), None, (medium((0.4, 0.2, 0.1), 0.1),))
    samples, size = 256, 24
    settings = {"vsp_control": "exact", "vsp_defensive": 1.0, "vsp_target": target, "max_bounces": 0}
    image = scene.render(("VSP Target", "VSP Achieved"), size=size, samples=samples, **settings)
    wanted = image["VSP Target"][..., 0].astype(float)
    if target != "random":
        assert np.allclose(wanted, {"lowest": 0.001, "highest": 0.999}[target])
    z = (image["VSP Achieved"][..., 0] - wanted).sum() * samples
    z /= np.sqrt((wanted * (1 - wanted)).sum() * samples)
    assert abs(z) < scipy.stats.norm.isf(1e-4 / 2)


def lamp_in_fog():
    """A lamp in thin fog before a dim wall, right in the camera's view."""
    lamp = d.Light("lamp", "point", placed(0.1, 0, 0.1), (10.0,) * 3, radius=0.01)
    scene = Scene(perspective((0, -4, 0), (0, 0, 0), 0.2), lights=(lamp,))
    scene.add(box((-3, -3, -3), (3, 3, 3)), None, (medium(0.02),))
    return scene.add(box((-4, 4, -4), (4, 4.2, 4)), diffuse(0.1))


def squared_error(scene, reference, **settings):
    """Returns the mean relMSE of 64 renders of 16 samples."""
    images = [
        scene.render(size=24, samples=16, seed=seed, max_bounces=2, train_field="never", **settings)[
            "Combined"
        ]
        for seed in range(64)
    ]
    return np.mean((np.array(images) - reference) ** 2 / (reference**2 + 0.01))


def test_candidates_near_lamps_pay():
    """In thin fog around a lamp the light product cuts the error at least in half, and guiding without it
    is no worse than none."""
    scene = lamp_in_fog()
    reference = scene.render(size=24, samples=8192, seed=99, max_bounces=2)["Combined"]
    delta = squared_error(scene, reference, distance_sampling="delta")
    bare, product = (squared_error(scene, reference, **{**BARE, "vsp_product": p}) for p in (False, True))
    assert bare < delta
    assert product < bare / 2


def test_guiding_lowers_the_error_behind_smoke():
    """Bright walls behind dark smoke: by a factor of four at equal samples."""
    scene = Scene(perspective((0, -4, 0), (0, 0, 0), 0.2), emission(2.0))
    scene.add(box((-2, -0.5, -2), (2, 0.5, 2)), None, (medium(1.0, 1.0),))
    reference = scene.render(size=24, samples=4096, seed=99, max_bounces=2)["Combined"]
    delta = squared_error(scene, reference, distance_sampling="delta")
    assert squared_error(scene, reference) < delta / 4


def test_scenes_without_media_learn_nothing():
    scene = Scene(perspective((0, -4, 0), (0, 0, 0), 0.4), emission(1.0))
    scene.add(box((-1, -1, -1), (1, 1, 1)), diffuse(0.5))
    guided = scene.render(("Combined", "VSP Target"), size=8, samples=4, train_field="never")
    assert not guided["VSP Target"].any()
    plain = scene.render(size=8, samples=4, distance_sampling="delta", train_field="never")
    assert np.array_equal(guided["Combined"], plain["Combined"])


def test_passes_of_guiding_are_in_the_table():
    for name in (
        "VSP Target",
        "VSP Achieved",
        "Volume Variance",
        "Surface Variance",
        "Majorant Optical Depth",
    ):
        assert pass_table.lookup(name)
