# SPDX-License-Identifier: GPL-3.0-or-later
"""The guiding field changes no expectation: directions, later segments and termination guided by it, one by
one and together, tried or always, give the image of unguided delta tracking. One seed gives one image. See
comparison.py for the statistics and their false alarms."""

from functools import cache

import nephele_native
import numpy as np
import pytest
import scipy.stats
from comparison import assert_same, moments
from field_scenes import baffle_room, burning_smoke, cloud, glass_and_leaves
from nephele import description as d
from slabs import beam, closure, radiance, under_screen
from truth import Scene, box, medium, perspective, placed

SEEDS, BLOCK = 16, 8
NONE = {"train_field": "always", "guide_directions": False, "vsp_secondary": False, "guided_roulette": False}
WAYS = {
    "directions": {**NONE, "guide_directions": True},
    "segments": {**NONE, "vsp_secondary": True},
    "roulette": {**NONE, "guided_roulette": True},
    "all": {"train_field": "always"},
    "exact": {"train_field": "always", "vsp_control": "exact"},
    "camera_by_delta": {"train_field": "always", "distance_sampling": "delta"},
    "auto": {"train_field": "auto"},
}
# Samples by scene, and the largest standard error, relative, of the image's mean between two ways.
EFFORTS = {
    baffle_room: (128, 0.05),  # where light is rare; fewer make the means of 16 seeds too skewed for a t-test
    cloud: (40, 0.012),
    glass_and_leaves: (40, 0.02),
    burning_smoke: (32, 0.02),
}


@cache
def unguided(make):
    """Returns the moments of a scene by delta tracking alone."""
    settings = {"distance_sampling": "delta", "train_field": "never"}
    return moments(make(), SEEDS, 2 * EFFORTS[make][0], BLOCK, seed=1000, **settings)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("make", EFFORTS, ids=lambda f: f.__name__)
def test_the_field_does_not_change_the_image(make, way):
    samples, error = EFFORTS[make]
    assert_same(unguided(make), moments(make(), SEEDS, samples, BLOCK, **WAYS[way]), SEEDS, error)


def test_many_guided_directions_in_a_row_add_no_fireflies():
    """A deep, forward-peaked cloud under a sun: light that leaves it has scattered tens of times. Weights of
    guided directions that multiplied without bound made the spread of pixels 1.9 times the unguided."""
    scene = under_screen(16, closure((1, 1, 1), 0.85), lights=(beam(1.0, 1.0),))
    guided = {**NONE, "guide_directions": True}
    spread = [
        radiance(scene, 64, 3, **settings)[..., 0].std() for settings in ({"train_field": "never"}, guided)
    ]
    assert spread[1] < 1.25 * spread[0]


FEW = {"max_bounces": 4, "roulette_depth": 8}


@cache
def cloud_unguided():
    """Returns (mean, squared standard error) of the mean of a small image of the cloud."""
    settings = {"distance_sampling": "delta", "train_field": "never", **FEW}
    means = [
        cloud().render(size=8, samples=256, seed=5000 + s, **settings)["Combined"].mean((0, 1))
        for s in range(48)
    ]
    return np.mean(means, 0), np.var(means, 0, ddof=1) / len(means)


@pytest.mark.parametrize("samples", [2, 4, 8])
def test_what_few_samples_teach_is_no_bias(samples):
    """The mean over 1000 seeds. False alarm 1e-4, Bonferroni over the channels."""
    scene, expected = cloud(), cloud_unguided()
    means = [
        scene.render(size=8, samples=samples, seed=seed, train_field="always", **FEW)["Combined"].mean((0, 1))
        for seed in range(1000)
    ]
    error2 = np.var(means, 0, ddof=1) / len(means) + expected[1]
    z = np.abs(np.mean(means, 0) - expected[0]) / np.sqrt(error2)
    assert np.all(z < scipy.stats.norm.isf(1e-4 / 6)), z
    assert np.all(np.sqrt(error2) < 0.02 * expected[0]), "too noisy to tell"


# --- One seed, one image


def rendered(settings, knowledge=None, size=(40, 24), make=baffle_room):
    """Returns a native renderer of a scene that has finished."""
    renderer = nephele_native.Renderer(make().description(size, seed=3, **settings))
    if knowledge is not None:
        renderer.inherit(knowledge)
    renderer.start()
    assert renderer.wait(200)
    return renderer


@pytest.mark.parametrize("mode", ["always", "auto"])
def test_threads_make_no_difference(mode):
    one, two = (
        rendered({"samples": 24, "train_field": mode, "threads": n}).read_pass("Combined") for n in (1, 2)
    )
    assert np.array_equal(one, two)


@pytest.mark.parametrize("mode", ["always", "auto"])
@pytest.mark.parametrize("at", [3, 8, 21])
def test_a_checkpoint_continues_to_the_same_bits(mode, at):
    settings = {"train_field": mode}
    whole = rendered(settings | {"samples": 24}).read_pass("Combined")
    half = rendered(settings | {"samples": at}).checkpoint()
    rest = nephele_native.Renderer(baffle_room().description((40, 24), seed=3, samples=24, **settings))
    rest.restore(half)
    rest.start()
    assert rest.wait(200)
    assert np.array_equal(rest.read_pass("Combined"), whole)


# --- Nothing for nothing


def one_fog_one_lamp():
    lamp = d.Light("lamp", "point", placed(0.5, -1, 0.5), (10.0,) * 3, radius=0.05)
    scene = Scene(perspective((0, -4, 0), (0, 0, 0), 0.3), lights=(lamp,))
    return scene.add(box((-1, -1, -1), (1, 1, 1)), None, (medium(0.5),))


@pytest.mark.parametrize(
    ("make", "settings", "reason"),
    [
        (one_fog_one_lamp, {}, "one light"),
        (baffle_room, {"max_bounces": 0}, "do not bounce"),
        (baffle_room, {"train_field": "never"}, "switched off"),
        (
            baffle_room,
            dict.fromkeys(("guide_directions", "vsp_secondary", "guided_roulette"), False),
            "no setting",
        ),
    ],
)
def test_what_cannot_gain_trains_nothing(make, settings, reason):
    field = rendered({"samples": 8, **settings}, make=make)
    told = field.statistics()["guiding_field"]
    assert (told["trains"], told["regions"], told["bytes"]) == (False, 0, 0)
    assert reason in told["reason"]
    never = rendered({"samples": 8, **settings, "train_field": "never"}, make=make)
    assert np.array_equal(field.read_pass("Combined"), never.read_pass("Combined"))


def test_an_indirect_room_trains_and_says_for_what():
    field = rendered({"samples": 32, "train_field": "auto"}).statistics()["guiding_field"]
    assert field["trains"]
    assert field["regions"] > 0
    assert set(field["uses"]) <= {"directions", "segments", "roulette"}
    assert rendered({"samples": 4}).statistics()["guiding_field"]["uses"] is None, "still on trial"


# --- Knowledge handed on


@cache
def learned(make=baffle_room):
    return rendered({"samples": 64, "train_field": "always"}, make=make).knowledge()


def cloud_error(images):
    reference = cloud_picture()
    return np.mean((np.array(images) - reference) ** 2 / (reference**2 + 0.01 * reference.mean() ** 2))


@cache
def cloud_picture():
    scene = cloud()
    images = [
        scene.render(size=(40, 24), samples=512, seed=900 + s, train_field="always")["Combined"]
        for s in range(3)
    ]
    return np.mean(images, 0)


def test_inherited_knowledge_lowers_the_error_of_few_samples_and_keeps_the_mean():
    """Four samples learn next to nothing by themselves: 2.9 times the error (one standard error 0.05)."""
    with_it, without = [], []
    for seed in range(24):
        for images, knowledge in ((with_it, learned(cloud)), (without, None)):
            scene = cloud().description((40, 24), seed=seed, samples=4, train_field="always")
            renderer = nephele_native.Renderer(scene)
            if knowledge is not None:
                assert "the field" in renderer.inherit(knowledge)
            renderer.start()
            assert renderer.wait(100)
            images.append(renderer.read_pass("Combined")[::-1, :, :3])
    assert 2 * cloud_error(with_it) < cloud_error(without)
    a, b = (np.array(images).mean((1, 2)) for images in (with_it, without))
    z = np.abs(a.mean(0) - b.mean(0)) / np.sqrt((a.var(0, ddof=1) + b.var(0, ddof=1)) / len(a))
    assert np.all(z < scipy.stats.norm.isf(1e-4 / 6)), z


@pytest.mark.parametrize("damage", ["cut", "nan", "negative", "huge", "missing"])
def test_damaged_knowledge_is_refused(damage):
    knowledge = {name: np.array(values) for name, values in learned().items()}
    name = next(n for n in knowledge if n.startswith("field_regions"))
    if damage == "cut":
        knowledge[name] = knowledge[name][:-1]
    elif damage == "missing":
        del knowledge[name.replace("regions", "nodes")]
    else:
        knowledge[name][3] = {"nan": np.nan, "negative": -1, "huge": 1e18}[damage]
    renderer = nephele_native.Renderer(baffle_room().description((40, 24), train_field="always"))
    with pytest.raises(ValueError, match=r"damaged|does not fit"):
        renderer.inherit(knowledge)


def test_knowledge_of_another_size_hands_on_the_field_alone():
    renderer = nephele_native.Renderer(baffle_room().description((20, 20), train_field="always"))
    assert renderer.inherit(learned()) == "the field"
