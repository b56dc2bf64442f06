# SPDX-License-Identifier: GPL-3.0-or-later
"""The estimated error of a render, stopping at one, and fewer samples where the image is clean: means stay
right, the estimate is what it claims to be, and an interruption changes nothing."""

import nephele_native
import numpy as np
import pytest
from nephele import metrics
from small_world import small_world
from truth import finished, finished_after_interruption

NEVER = 1e-12  # a target that no noise comes down to
SIZE = (24, 16)


def rendered(names=("Combined",), size=SIZE, **settings):
    """Returns the finished Renderer of the small world."""
    renderer = nephele_native.Renderer(small_world().description(size, names, **settings))
    renderer.start()
    assert renderer.wait(200)
    return renderer


def image_of(renderer):
    return renderer.read_pass("Combined")[..., :3].astype(float)


@pytest.fixture(scope="module")
def truth():
    """Many samples of the small world."""
    return image_of(rendered(samples=4096, seed=77))


@pytest.mark.parametrize("guiding", ["never", "auto"])
def test_adaptive_means_are_the_plain_ones(guiding):
    """Over 160 seeds of 64 samples, of which each pixel takes as many as its noise asks for, against 160
    others of 64 each; blocks of 4 x 4 pixels and the three channels, 72 z-scores. False alarms: 1 in 1000
    seeds (Sidak)."""

    def blocks(first, **settings):
        runs = [rendered(samples=64, train_field=guiding, seed=first + k, **settings) for k in range(160)]
        images = np.stack([image_of(run) for run in runs]).reshape(160, 4, 4, 6, 4, 3).mean(axis=(2, 4))
        return images.mean(axis=0), images.std(axis=0, ddof=1) / len(images) ** 0.5

    adaptive, error = blocks(0, target_error=NEVER)
    plain, plain_error = blocks(1000)
    assert np.allclose(adaptive, plain, rtol=0.1)
    noise = np.maximum(np.hypot(error, plain_error), 1e-6 * plain)
    assert (noise > 1e-4 * plain).mean() > 0.5
    z = (adaptive - plain) / noise
    assert np.abs(z).max() < 4.35, z


def test_adaptive_takes_fewer_samples_where_the_image_is_clean():
    names = ("Combined", "Sample Count", "Variance", "Cost")
    renderer = rendered(names, samples=256, target_error=NEVER, seed=3)
    counts, cost = renderer.read_pass("Sample Count")[..., 0], renderer.read_pass("Cost")[..., 0]
    least = 16 + 240 / 8  # 16 samples, then an eighth
    assert counts.min() == least
    assert np.median(counts[cost == 0]) == least, "where there is nothing but the sky"
    assert counts.max() == 256
    variance = renderer.read_pass("Variance")[..., 0]
    assert np.median(counts[variance > np.quantile(variance, 0.9)]) == 256
    assert renderer.progress()["samples_done"] == 256


def test_adaptive_sampling_lowers_the_error_for_the_work(truth):
    """Error times paths, in the mean over 8 seeds, against the same samples everywhere."""

    def product(adaptive):
        products = []
        for seed in range(8):
            renderer = rendered(
                ("Combined", "Sample Count"),
                samples=256,
                target_error=NEVER,
                adaptive_sampling=adaptive,
                seed=seed,
            )
            error = metrics.relmse(image_of(renderer).reshape(-1, 3), truth.reshape(-1, 3))["relmse"]
            products.append(error * renderer.read_pass("Sample Count").mean())
        return np.mean(products)

    assert product(True) < 0.9 * product(False)


@pytest.mark.parametrize("adaptive", [False, True])
def test_the_estimated_error_is_the_real_one(truth, adaptive):
    """With independent samples, whose spread tells all; in the mean over 24 seeds, within a tenth."""
    ratios = []
    for seed in range(24):
        renderer = rendered(
            samples=64,
            seed=seed,
            sampler="independent",
            target_error=NEVER,
            adaptive_sampling=adaptive,
            train_field="never",
        )
        last = renderer.statistics()["errors"][-1]
        assert last["samples"] == 64
        real = metrics.relmse(image_of(renderer).reshape(-1, 3), truth.reshape(-1, 3))["relmse"]
        ratios.append(last["error"] / real)
    assert np.mean(ratios) == pytest.approx(1, abs=0.1)


def test_a_render_stops_at_its_target():
    renderer = rendered(samples=2**20, target_error=0.01, seed=1)
    told = renderer.statistics()
    assert told["target_reached"]
    assert 16 <= told["samples_done"] < 2**14
    assert [mark["error"] <= 0.01 for mark in told["errors"] if mark["samples"] >= 16][:-1].count(True) == 0
    assert told["errors"][-1]["error"] <= 0.01
    assert renderer.progress()["error"] == told["errors"][-1]["error"]
    assert renderer.progress()["state"] == "done"
    samples = [mark["samples"] for mark in told["errors"]]
    assert samples == sorted(set(samples))
    cpu = [mark["cpu_seconds"] for mark in told["errors"]]
    assert cpu == sorted(cpu)
    assert cpu[0] > 0


def test_errors_are_estimated_only_where_asked_for():
    assert rendered(samples=4).statistics()["errors"] == []
    assert rendered(samples=4).progress()["error"] is None
    asked = rendered(samples=32, estimate_error=True).statistics()
    assert [mark["samples"] for mark in asked["errors"]] == [2, 4, 8, 16, 32]
    assert asked["target_reached"] is False
    plain = rendered(("Combined",), samples=32, seed=9)
    told = rendered(("Combined",), samples=32, seed=9, estimate_error=True)
    assert np.array_equal(image_of(plain), image_of(told)), "to know the error does not change the image"


def test_an_interrupted_adaptive_render_continues_to_the_same_bits():
    scene = small_world().description((72, 40), samples=100, seed=5, target_error=NEVER)
    whole = finished(scene)["Combined"]
    assert np.array_equal(finished_after_interruption(scene, 32), whole.astype(np.float32))


def test_adaptive_images_do_not_depend_on_threads():
    one, four = (
        image_of(rendered(size=(72, 40), samples=96, seed=2, target_error=NEVER, threads=n)) for n in (1, 4)
    )
    assert np.array_equal(one, four)
