# SPDX-License-Identifier: GPL-3.0-or-later
"""What a scene does not need is neither loaded nor allocated nor run: memory and counters of the renderer."""

import dataclasses

import nephele_native
import numpy as np
import pytest
from nephele import description as d
from nephele import passes as pass_table
from nephele.commands import info
from small_world import small_world
from truth import (
    ROUGH_BALL,
    SCENES,
    Scene,
    box,
    constant_program,
    diffuse,
    emission,
    finished,
    perspective,
    placed,
)

PLAIN = {"distance_sampling": "delta", "train_field": "never"}
SIZE = (40, 30)
PIXELS = SIZE[0] * SIZE[1]
SMOKE = SCENES / "smoke" / "smoke_0001.vdb"  # grids: density, temperature


def room(*lights):
    """Returns a scene without volumes."""
    scene = Scene(perspective((0, -4, 1.5), (0, 0, 0)), emission(1.0), lights=lights)
    return scene.add(box((-3, -3, -0.2), (3, 3, 0)), diffuse(0.5))


def told(scene, passes=("Combined",), **settings):
    """Returns the statistics of a finished render."""
    renderer = nephele_native.Renderer(scene.description(SIZE, passes, **{"samples": 4} | settings))
    renderer.start()
    assert renderer.wait(100)
    return renderer.statistics()


def ball(closures=None, **more):
    closures = closures or (d.VolumeClosure((2, 2, 2), (0.5, 0.5, 0.5), density_grid="density"),)
    return room().add_volume(ROUGH_BALL, *closures, **more)


# --- The kernel


@pytest.mark.parametrize(
    ("make", "settings", "kernel"),
    [
        (room, PLAIN, ["surfaces"]),
        (room, {}, ["surfaces", "learning"]),
        (ball, PLAIN, ["surfaces", "one medium"]),
        (ball, {}, ["surfaces", "one medium", "learning"]),
        (
            small_world,
            {},
            ["surfaces", "overlapping media", "volume emission", "learning"],
        ),
        (small_world, {"integrator": "plain"}, ["everything, plainly"]),
    ],
    ids=["room", "room learns", "ball", "ball learns", "small world", "plain"],
)
def test_the_kernel_is_the_smallest_that_does(make, settings, kernel):
    scene = make() if settings.get("integrator") != "plain" else room()
    assert told(scene, **settings)["kernel"] == kernel
    assert info.describe(scene.description(SIZE, **settings))["kernel"] == kernel


def test_passes_that_tell_light_apart_take_a_kernel_of_their_own():
    passes = ("Combined", "Diffuse Direct")
    for make, kernel in (
        (room, ["surfaces", "learning", "parts of light"]),
        (ball, ["surfaces", "overlapping media", "volume emission", "learning", "parts of light"]),
    ):
        scene = make().description(SIZE, passes, **PLAIN)
        assert info.describe(scene)["kernel"] == kernel


def test_an_emissive_medium_takes_the_kernel_with_emission():
    glowing = d.VolumeClosure((2, 2, 2), emission=(0.1, 0.1, 0.1))
    scene = room().add(box((-1, -1, 0), (1, 1, 1)), None, (glowing,))
    assert told(scene, **PLAIN)["kernel"] == ["surfaces", "one medium", "volume emission"]


def test_media_that_overlap_without_glowing_take_no_kernel_with_emission():
    scene = ball().add(box((-1, -1, 0), (1, 1, 1)), None, (d.VolumeClosure((2, 2, 2)),))
    assert told(scene, **PLAIN)["kernel"] == ["surfaces", "overlapping media"]


def test_the_boundary_of_a_volume_is_no_hidden_surface():
    """Filters, by which rays pass hidden surfaces, slow every ray down."""
    fog = room().add(box((-1, -1, 0), (1, 1, 1)), None, (d.VolumeClosure((0.1, 0.1, 0.1)),), visibility=1)
    assert "hidden surfaces" in told(fog)["left_out"]
    hidden = room().add(box((-1, -1, 0), (1, 1, 1)), diffuse(0.5), visibility=1)
    assert "hidden surfaces" in told(hidden)["kernel_features"]


# --- Memory


def test_a_film_holds_what_its_passes_need():
    """Bytes a pixel: 4 of the count, 8 of each sum; of a cryptomatte 24 of its list and 16 of each id."""
    for asked in pass_table.PASSES:
        if asked.levels:
            bytes_a_pixel = told(room(), (asked.name,), **PLAIN)["memory"]["film"] / PIXELS
            assert 4 + 24 <= bytes_a_pixel <= 4 + 24 + 16 * 4, asked.name
            continue
        sums = {"Combined": 4, "Sample Count": 0}.get(asked.name, len(asked.channels))
        if asked.name == "Variance":
            sums = 3 + 4  # squares, and Combined
        elif asked.name.endswith(" Variance"):
            sums = 3 + 3  # squares, and the pass itself
        elif asked.name.endswith("irect") and not asked.name.startswith("Volume"):
            sums = 3 + 3  # light, and the colour that divides it
        assert told(room(), (asked.name,), **PLAIN)["memory"]["film"] == PIXELS * (4 + 8 * sums), asked.name


def test_squares_and_weights_are_kept_for_a_target_alone():
    plain, with_target = (
        told(room(), target_error=target, **PLAIN)["memory"]["film"] for target in (0.0, 1e-9)
    )
    assert with_target == plain + PIXELS * (3 * 8 + 4 + 8)
    without_weights = told(room(), target_error=1e-9, adaptive_sampling=False, **PLAIN)
    assert without_weights["memory"]["film"] == plain + PIXELS * 3 * 8


@pytest.mark.parametrize(
    ("make", "settings", "learns"),
    [
        (room, PLAIN, False),
        (room, {}, True),
        (room, {"max_bounces": 0}, False),
        (ball, PLAIN, False),
        (ball, {"train_field": "never"}, True),
        (room, {"train_field": "never"}, False),  # no volume that camera rays could be guided to
        (room, PLAIN | {"target_error": 1e-9}, True),  # where samples are worth most
    ],
)
def test_nothing_is_allocated_for_learning_where_nothing_learns(make, settings, learns):
    statistics = told(make(), **settings)
    assert (statistics["memory"]["learning"] > 0) == learns
    assert ("learning" in statistics["kernel"]) == learns


def test_a_scene_in_which_nothing_scatters_trains_no_field():
    sky = Scene(perspective((0, -4, 1.5), (0, 0, 0)), emission(1.0))
    statistics = told(sky)
    assert not statistics["guiding_field"]["trains"]
    assert statistics["memory"]["learning"] == 0


def test_a_light_tree_is_for_many_lamps():
    def lamp(i):
        return d.Light(f"lamp {i}", "point", placed(np.cos(i), np.sin(i), 2), (1, 1, 1), radius=0.1)

    def lamps(count):
        return room(*(lamp(i) for i in range(count)))

    bytes_of = [told(lamps(count), **PLAIN)["memory"]["light_tree"] for count in (1, 16, 17)]
    assert bytes_of[:2] == [0, 0]
    assert bytes_of[2] > 0


# --- Grids


def smoke(closure, **more):
    scene = Scene(perspective((0, -4, 1.5), (0, 0, 0)), emission(1.0))
    return scene.add_volume(SMOKE, closure, **more)


def test_only_the_grids_that_are_read_are_loaded():
    dark = d.VolumeClosure((2, 2, 2), density_grid="density")
    assert [grid["grid"] for grid in told(smoke(dark))["grids"]] == ["density"]
    glowing = d.VolumeClosure(emission=(1, 1, 1), emission_grid="temperature")
    assert [grid["grid"] for grid in told(smoke(glowing))["grids"]] == ["temperature"]


def test_info_marks_the_grids_that_programs_read():
    program = d.VolumeClosure(program=constant_program(), grids=("temperature",))
    description = smoke(program).description(SIZE)
    (volume,) = [info.describe_volume(description, volume) for volume in description.volumes]
    assert {grid["name"]: grid["used"] for grid in volume["grids"]}["temperature"]


def test_a_velocity_is_loaded_for_an_open_shutter_alone():
    dark = d.VolumeClosure((2, 2, 2), density_grid="density")
    moving = smoke(dark, velocity_grids=("temperature",) * 3, velocity_scale=1e-6).description(SIZE)
    loaded = []
    for shutter in ((0.0, 0.0), (-0.25, 0.25)):
        renderer = nephele_native.Renderer(dataclasses.replace(moving, shutter=shutter))
        loaded.append([grid["grid"] for grid in renderer.statistics()["grids"]])
    assert loaded == [["density"], ["density", "temperature"]]


# --- Bits


@pytest.mark.parametrize(
    "settings", [PLAIN, {}, {"tracking": "decomposition"}, {"transmittance": "ray_marching"}]
)
def test_kernels_agree(settings):
    """A second medium that is never met takes the scene to the kernel with everything: paths are the same,
    and only rounding may differ, where the compiler fuses other multiplications with additions. Hardly a
    path goes another way for that."""
    one = ball()
    several = ball().add(box((90, 90, 90), (91, 91, 91)), None, (d.VolumeClosure((1, 1, 1)),))
    a, b = (
        finished(scene.description(SIZE, samples=8, seed=3, **settings))["Combined"]
        for scene in (one, several)
    )
    same = np.isclose(a, b, rtol=1e-5).all(-1)
    assert same.mean() > 0.95
    assert a.mean() == pytest.approx(b.mean(), rel=2e-3)
