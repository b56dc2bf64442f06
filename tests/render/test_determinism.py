# SPDX-License-Identifier: GPL-3.0-or-later
"""The contract of a render: one seed, one image, whatever the threads, the crop or an interruption; prompt
cancelling; passes that fit together and hold what they say."""

import time

import nephele_native
import numpy as np
import pytest
from nephele import description as d
from nephele import passes as pass_table
from small_world import small_world
from truth import (
    NO_LIMIT,
    RAY,
    Scene,
    box,
    diffuse,
    emission,
    finished,
    finished_after_interruption,
    orthographic,
    perspective,
    sphere,
)

ALL = tuple(p.name for p in pass_table.PASSES)


def dense():
    """A block so dense and white that one path takes long."""
    scene = Scene(perspective((0, -4, 0.5), (0, 0, 0), 0.2), emission(1.0))
    return scene.add(box((-1, -1, -1), (1, 1, 1)), None, (d.VolumeClosure((300, 300, 300)),))


def same(a, b):
    return all(np.array_equal(a[name], b[name]) for name in a)


@pytest.fixture(scope="module")
def reference():
    """Every pass of the small world in full."""
    return small_world().render(ALL, size=(72, 40), samples=9, seed=5, threads=1)


@pytest.mark.parametrize("threads", [1, 2, 4])
def test_same_seed_gives_the_same_bits_on_any_number_of_threads(reference, threads):
    assert same(reference, small_world().render(ALL, size=(72, 40), samples=9, seed=5, threads=threads))


def test_other_seeds_give_other_samples(reference):
    other = small_world().render(ALL, size=(72, 40), samples=9, seed=6)
    differs = np.any(reference["Combined"] != other["Combined"], axis=-1)
    sees_something = reference["Cost"][..., 0] > 0  # the rest is plain sky
    assert sees_something.mean() > 0.3
    assert differs[sees_something].mean() > 0.99


@pytest.mark.parametrize("crop", [(0, 0, 72, 40), (5, 7, 41, 33), (71, 39, 72, 40)])
def test_crop_is_the_same_part_of_the_full_frame(crop):
    """Without guiding, which learns from all pixels that are rendered."""
    settings = {"samples": 9, "seed": 5, "distance_sampling": "delta", "train_field": "never"}
    whole = small_world().render(ALL, size=(72, 40), **settings)
    x0, y0, x1, y1 = crop
    part = small_world().render(ALL, size=(72, 40), crop=crop, **settings)
    assert same(part, {name: image[y0:y1, x0:x1] for name, image in whole.items()})


def test_checkpoint_continues_to_the_same_bits(reference):
    first = nephele_native.Renderer(small_world().description((72, 40), ALL, samples=4, seed=5))
    first.start()
    assert first.wait(100)
    second = nephele_native.Renderer(small_world().description((72, 40), ALL, samples=9, seed=5))
    second.restore(first.checkpoint())
    second.start()
    assert second.wait(100)
    assert second.progress()["samples_done"] == 9
    for name, image in reference.items():
        assert np.array_equal(second.read_pass(name)[..., : image.shape[-1]], image), name


def test_checkpoint_of_a_cancelled_render_continues_to_the_same_bits():
    scene = small_world().description((72, 40), samples=60, seed=5)
    whole = finished(scene)["Combined"]
    assert np.array_equal(finished_after_interruption(scene, 5), whole.astype(np.float32))


def test_checkpoint_of_another_frame_is_refused():
    scene = small_world()
    saved = nephele_native.Renderer(scene.description((8, 8))).checkpoint()
    for other in (scene.description((8, 9)), scene.description((8, 8), ("Combined", "Depth"))):
        with pytest.raises(ValueError, match="checkpoint does not fit"):
            nephele_native.Renderer(other).restore(saved)


@pytest.mark.parametrize("make", [small_world, dense], ids=lambda f: f.__name__)
def test_cancel_is_answered_at_once(make):
    """Within 0.2 s, which holds for a machine that is busy with other things too: the fastest of three
    counts."""
    waits = []
    for _ in range(3):
        renderer = nephele_native.Renderer(make().description(64, samples=2**20, **NO_LIMIT))
        renderer.start()
        time.sleep(0.3)
        began = time.monotonic()
        renderer.cancel()
        assert renderer.wait(60)
        waits.append(time.monotonic() - began)
        assert renderer.progress()["state"] == "cancelled"
    assert min(waits) < 0.2, waits


def test_time_limit_ends_the_render():
    renderer = nephele_native.Renderer(
        small_world().description(64, ("Combined", "Sample Count"), samples=2**20, time_limit=0.5)
    )
    began = time.monotonic()
    renderer.start()
    assert renderer.wait(60)
    assert 0.45 < time.monotonic() - began < 2.5
    assert renderer.progress()["state"] == "done"
    assert renderer.read_pass("Sample Count").min() >= 1
    assert renderer.progress()["samples_done"] == renderer.read_pass("Sample Count").min()


def test_only_passes_asked_for_can_be_read():
    for asked in ALL:
        renderer = nephele_native.Renderer(small_world().description(4, (asked,), samples=1))
        for name in ALL:
            if name in (asked, "Sample Count"):
                renderer.read_pass(name)
            else:
                with pytest.raises(ValueError, match="was not asked for"):
                    renderer.read_pass(name)


def test_passes_do_not_change_each_other(reference):
    for name in ALL:
        alone = small_world().render((name,), size=(72, 40), samples=9, seed=5)
        if name != "Cost":  # it counts what the other passes cost, too
            assert np.array_equal(alone[name], reference[name]), name


def test_volume_and_surface_add_up_and_variance_is_that_of_the_mean():
    parts = {"Combined": "Variance", "Volume": "Volume Variance", "Surface": "Surface Variance"}
    spread = small_world().description(
        (24, 16), (*parts, *parts.values(), "Sample Count"), samples=64, sampler="independent"
    )
    images = finished(spread)
    assert np.allclose(images["Volume"] + images["Surface"], images["Combined"], rtol=1e-6, atol=1e-7)
    assert np.all(images["Sample Count"] == 64)
    seeds = [
        small_world().render(tuple(parts), size=(24, 16), samples=64, sampler="independent", seed=s)
        for s in range(1, 25)
    ]
    for mean, variance in parts.items():
        measured = np.var([seed[mean][..., :3] for seed in seeds], axis=0, ddof=1).mean()  # of 24 x 1152
        assert images[variance].mean() == pytest.approx(measured, rel=0.1), variance


def test_features_of_a_plane():
    """A plane seen at a slant through a fog: what Depth, Normal, Albedo, Transmittance and Emission must
    be."""
    fog = d.VolumeClosure((0.1, 0.2, 0.3), (0.1, 0.2, 0.3))
    view = orthographic((0, -2, 2), (0, 0, 0), 0.5)
    scene = Scene(view, world_volume=(fog,)).add(box((-9, -9, -1), (9, 9, 0)), diffuse((0.2, 0.5, 0.9)))
    names = ("Depth", "Normal", "Albedo", "Transmittance", "Emission", "Mist", "Volume Albedo")
    names += ("Majorant Optical Depth",)
    images = scene.render(names, size=16, samples=4, pixel_filter="box")
    middle = images["Depth"][7:9].mean()
    assert middle == pytest.approx(8**0.5, rel=0.01)
    rows = (np.arange(16) + 0.5) / 16 * 0.5 - 0.25
    assert np.allclose(images["Depth"][..., 0], 8**0.5 + rows[:, None], atol=0.5 / 16)
    assert np.allclose(images["Normal"], (0, 0, 1), atol=1e-6)
    assert np.allclose(images["Albedo"], (0.2, 0.5, 0.9), rtol=1e-6)
    assert np.allclose(
        images["Transmittance"][7:9].mean((0, 1)), np.exp(-(8**0.5) * np.array([0.2, 0.4, 0.6])), rtol=0.01
    )
    assert images["Majorant Optical Depth"][7:9].mean() == pytest.approx(8**0.5 * 0.6, rel=0.01)
    assert not images["Emission"].any()
    scattered = images["Volume Albedo"].max(-1) > 0
    assert np.allclose(images["Volume Albedo"].sum((0, 1)) / images["Volume Albedo"][..., :1].sum((0, 1)), 1)
    assert 0.3 < scattered.mean() < 1


def test_empty_pixels_say_so():
    images = Scene(perspective((0, 0, 5), (0, 0, 9))).render(
        ("Depth", "Mist", "Albedo", "Combined"), size=4, samples=2
    )
    assert np.all(images["Depth"] == np.float32(1e10))
    assert np.all(images["Mist"] == 1)
    assert not images["Albedo"].any()
    assert not images["Combined"].any()


def test_majorants_without_end_stay_finite():
    fog = d.VolumeClosure((0.1, 0.1, 0.1), (0, 0, 0))
    scene = Scene(perspective((0, 0, 5), (0, 0, 9)), world_volume=(fog,))
    depth = scene.render(("Majorant Optical Depth",), size=4, samples=3)["Majorant Optical Depth"]
    assert np.all(depth == 1e6)


def test_visibility_hides_from_the_kinds_of_rays_named():
    """A grey ball hidden from camera rays still shadows the floor; a world hidden from the camera still
    lights."""
    floor = box((-3, -3, -1.4), (3, 3, -1))
    world = emission(1.0)

    def picture(**more):
        scene = Scene(perspective((0, -0.01, 4), (0, 0, -1), 0.2), world).add(floor, diffuse(0.8))
        return scene.add(sphere(0.5, 3), diffuse(0.1), **more).render(size=16, samples=64)["Combined"].mean()

    hidden, shown, no_shadow = (
        picture(visibility=bits) for bits in (d.ALL_RAYS & ~RAY["camera"], d.ALL_RAYS, RAY["camera"])
    )
    alone = Scene(perspective((0, -0.01, 4), (0, 0, -1), 0.2), world).add(floor, diffuse(0.8))
    bare = alone.render(size=16, samples=64)["Combined"].mean()
    assert shown < hidden - 0.1 < bare
    assert hidden < bare - 0.05
    assert no_shadow < hidden
