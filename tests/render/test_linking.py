# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking, lamps that the camera sees, node trees of lamps, holdouts: what follows from
what they are. False alarms: see comparison.py."""

import dataclasses

import numpy as np
import pytest
from comparison import assert_same, moments
from nephele import description as d
from nephele import opcodes
from truth import (
    BOX_FILTER,
    NO_LIMIT,
    Scene,
    box,
    constant_program,
    diffuse,
    emission,
    orthographic,
    perspective,
    placed,
)

GLOSSY = constant_program(("diffuse", 0.4, 0.0, None), ("glossy", 0.4, 0.4, None))
SEEDS = 6


def square(half, z=0.0, x=0.0, name="square"):
    corners = np.array(
        [(x - half, -half, z), (x + half, -half, z), (x + half, half, z), (x - half, half, z)], np.float32
    )
    return d.Mesh(name, corners, np.array([(0, 1, 2), (0, 2, 3)], np.int32))


def room(lights, fog=True, **more):
    """Returns a scene: a floor in set 0, a block in set 1 and fog in a box in set 2."""
    scene = Scene(perspective((0, -4, 2.5), (0, 0, 0.5)), lights=lights)
    scene.add(square(2), GLOSSY)
    scene.add(box((-0.9, -0.3, 0), (-0.3, 0.3, 0.6)), GLOSSY, receiver_set=1, blocker_set=1)
    if fog:
        scene.add(
            box((0.1, -0.5, 0.1), (1.1, 0.5, 1.1)),
            None,
            (d.VolumeClosure((0.8,) * 3, (0.1,) * 3),),
            receiver_set=2,
        )
    return scene


def area(**more):
    values = {"size": (1.2, 0.8), "visibility": d.ALL_RAYS & ~1} | more
    return d.Light("area", "area", placed(0.2, 0, 1.6), (10.0, 8.0, 6.0), **values)


def test_lights_of_each_set_add_up_to_the_light_of_all():
    """Every path's light comes to its last vertex, whose object is in one set."""
    whole = moments(room([area()]), SEEDS, 64, 6)
    parts = [
        moments(room([area(receivers=sets)]), SEEDS, 64, 6, seed=100 * n)
        for n, sets in enumerate((0b001, 0b010, 0b100))
    ]
    total = tuple((sum(p[k][0] for p in parts), sum(p[k][1] for p in parts)) for k in range(2))
    assert all(part[1][0].min() > 1e-3 for part in parts), "each set gets its part"
    assert_same(whole, total, SEEDS)


@pytest.mark.parametrize("sets", [0b001, 0b110])
def test_linked_light_agrees_with_the_plain_twin(sets):
    one, other = (
        moments(
            room([area(receivers=sets)], fog=sets != 1),
            SEEDS,
            samples,
            6,
            integrator=name,
            train_field="never",
        )
        for name, samples in (("path", 64), ("plain", 256))
    )
    assert_same(one, other, SEEDS, error=0.05)


def test_a_glowing_mesh_shines_on_its_receivers_alone():
    def scene(receivers):
        result = Scene(orthographic((0, 0, 5), (0, 0, 0), 4))
        result.add(square(0.9, x=-1, name="left"), diffuse(0.5), receiver_set=1)
        result.add(square(0.9, x=1, name="right"), diffuse(0.5))
        result.add(box((-0.2, -0.2, 6), (0.2, 0.2, 6.4)), emission(50.0), receivers=receivers)
        return result.render(size=16, samples=64, **BOX_FILTER)["Combined"]

    both, left = scene(d.ALL_SETS), scene(0b10)
    assert np.abs(left[:, :8] - both[:, :8]).max() < 1e-6
    assert both[:, 8:].mean() > 0.01
    assert left[:, 8:].max() == 0


def test_shadows_of_all_but_one_set_are_those_without_it():
    """The block in set 1 lets this lamp's light through; it still is there, and dark beneath nothing."""
    small = area(size=(0.05, 0.05), blockers=~0b10 & d.ALL_SETS)
    lit_through = room([small], fog=False)
    away = room([area(size=(0.05, 0.05))], fog=False)
    block = lit_through.instances.pop(1)
    lit_through.instances.append(dataclasses.replace(block, visibility=0b111110))
    away.instances[1] = dataclasses.replace(
        away.instances[1], visibility=0b011110
    )  # no shadow rays, nor the camera's
    one, other = (moments(s, SEEDS, 64, 6) for s in (lit_through, away))
    assert_same(one, other, SEEDS)


def test_the_camera_sees_a_lamp_of_its_radiance():
    lamp = d.Light("lamp", "area", placed(0, 0, 1), (12.0,) * 3, size=(2.0, 1.0), visibility=d.ALL_RAYS)
    seen = Scene(orthographic((0, 0, -1), (0, 0, 1), 4), lights=[lamp])
    image = seen.render(size=16, samples=4, **BOX_FILTER)["Combined"]
    assert np.allclose(image[6:10, 4:12], 12 / (np.pi * 2), rtol=1e-5)
    assert image[:5].max() == image[:, :3].max() == 0
    hidden = dataclasses.replace(lamp, visibility=d.ALL_RAYS & ~1)
    assert Scene(seen.camera, lights=[hidden]).render(size=16, samples=4)["Combined"].max() == 0


def test_the_camera_sees_no_lamp_behind_a_wall_nor_before_its_clipping():
    lamp = d.Light("lamp", "point", placed(0, 0, 2), (12.0,) * 3, radius=0.5, visibility=d.ALL_RAYS)
    camera = orthographic((0, 0, -1), (0, 0, 1), 1)
    walled = Scene(camera, lights=[lamp]).add(square(3, z=1), diffuse(0.0))
    assert walled.render(size=8, samples=4)["Combined"].max() == 0
    clipped = dataclasses.replace(camera, clip_start=4.0)
    assert Scene(clipped, lights=[lamp]).render(size=8, samples=4)["Combined"].max() == 0
    assert Scene(camera, lights=[lamp]).render(size=8, samples=4)["Combined"].max() > 0.1


def of_one_operation(name, mode=0):
    """Returns a program that shines with what an operation tells."""
    row = (list(opcodes.OPCODES).index(name), 1, 0, 0, 0, 0, 0, mode)
    return d.Program(
        np.ones((2, 3), np.float32), np.array([row], np.int32), closures=(d.Closure("emission", 0, (1, 0)),)
    )


def test_a_lamp_shows_what_its_nodes_make_of_it():
    lamp = d.Light(
        "lamp", "area", placed(0, 0, 1), (np.pi * 4,) * 3, size=(2.0, 2.0), visibility=d.ALL_RAYS,
        program=of_one_operation("parametric"),
    )  # fmt: skip
    seen = Scene(orthographic((0, 0, -1), (0, 0, 1), 2), lights=[lamp])
    image = seen.render(size=16, samples=64, **BOX_FILTER)["Combined"]
    across = (np.arange(16) + 0.5) / 16
    u = image[..., 0].mean(0)
    assert np.allclose(u if u[0] < u[-1] else u[::-1], across, atol=0.005)
    assert np.allclose(image[..., 1].mean(1), across, atol=0.005)
    assert image[..., 2].max() == 0


def test_a_lamp_that_its_nodes_tint_lights_as_its_pieces_do():
    """A rectangle whose nodes make it as bright as its u, against 16 strips of the mean of each: on
    surfaces, by light sampling and scattering."""
    tinted = dataclasses.replace(
        area(size=(1.6, 0.8), program=of_one_operation("parametric")), power=(16.0, 0.0, 0.0)
    )
    strips = []
    for n in range(16):
        place = placed(0.2 - 0.8 + (n + 0.5) / 10, 0, 1.6)
        strips.append(d.Light("strip", "area", place, (1.0 * (n + 0.5) / 16, 0, 0), size=(0.1, 0.8)))
    one, other = (moments(room(lights, fog=False), SEEDS, 64, 6) for lights in ([tinted], strips))
    # Strips are even, which makes no difference that shows here.
    red = [tuple((m[..., :1], e[..., :1]) for m, e in moment) for moment in (one, other)]
    assert_same(*red, SEEDS)


def test_a_holdout_is_a_hole():
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), emission(1.0))
    scene.add(square(2, z=-1), diffuse(0.5))
    scene.add(square(1), diffuse(0.5), holdout=True)
    import nephele_native

    renderer = nephele_native.Renderer(scene.description(size=16, samples=16, **BOX_FILTER))
    renderer.start()
    assert renderer.wait(100)
    image = renderer.read_pass("Combined")
    assert np.all(image[5:11, 5:11] == 0)
    assert np.all(image[0, :, 3] == 1)
    assert image[0].mean() > 0.2


def test_light_that_a_ray_kind_does_not_see_is_no_light_of_its_lobes():
    """A lamp that glossy rays do not see lights a surface as if its glossy part were black."""
    rough = room([area(visibility=d.ALL_RAYS & ~0b101)], fog=False)
    matt = Scene(rough.camera, lights=[area()])
    matt.meshes, matt.instances, matt.materials = rough.meshes, rough.instances, []
    for material in rough.materials:
        matt.materials.append(dataclasses.replace(material, surface=diffuse(0.4)))
    bounce = {**NO_LIMIT, "max_bounces": 0, "surface_bounces": 0}
    images = [s.render(size=24, samples=256, **bounce)["Combined"].mean((0, 1)) for s in (rough, matt)]
    assert np.allclose(*images, rtol=0.01)
