# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps that move while the shutter is open: closed forms, and the mean of what they give standing still."""

import numpy as np
from comparison import assert_same
from nephele import description as d
from truth import BOX_FILTER, NO_LIMIT, Scene, diffuse, orthographic, placed

ALBEDO = 0.5


def floor(half=2.0):
    corners = half * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float32)
    return d.Mesh("floor", corners, np.array([(0, 1, 2), (0, 2, 3)], np.int32))


def turned(angle, place=(0, 0, 0)):
    """Returns the matrix of a turn about y and a move."""
    c, s = np.cos(angle), np.sin(angle)
    m = placed(*place)
    m[:3, :3] = (c, 0, s), (0, 1, 0), (-s, 0, c)
    return m


def lit(*lights):
    """Returns a scene of a floor, 4 m wide, seen from above."""
    return Scene(orthographic((0, 0, 9), (0, 0, 0), 4), lights=lights).add(floor(), diffuse(ALBEDO))


def test_a_point_lamp_on_its_way_gives_the_mean_over_time():
    start, end, power = np.array((-1.5, -0.5, 1.0)), np.array((1.0, 1.0, 2.0)), 40.0
    motion = np.stack([placed(*start), placed(*end)])
    lamp = d.Light("lamp", "point", placed(0, 0, 1), (power,) * 3, motion=motion)
    image = lit(lamp).render(size=16, samples=256, seed=2, **BOX_FILTER)["Combined"][..., 0]
    x = (np.arange(16) + 0.5) / 4 - 2
    t = (np.arange(400) + 0.5) / 400
    way = start + t[:, None] * (end - start)
    to = way[:, None, None] - np.stack(np.meshgrid(x, x), -1)[None] @ np.eye(2, 3)
    cosine_over_square = to[..., 2] / np.linalg.norm(to, axis=-1) ** 3
    expected = ALBEDO / np.pi * power / (4 * np.pi) * cosine_over_square.mean(0)
    assert np.abs(image / expected - 1).max() < 0.03  # 256 stratified times and places a pixel
    assert abs(image.mean() / expected.mean() - 1) < 3e-3


def test_a_sun_that_turns_gives_the_mean_of_its_cosines():
    motion = np.stack([turned(angle) for angle in np.linspace(-0.2, 1.0, 5)])
    lamp = d.Light("sun", "sun", np.eye(4), (2.0,) * 3, angle=0.05, motion=motion)
    image = lit(lamp).render(size=8, samples=256, seed=1, **BOX_FILTER)["Combined"]
    expected = ALBEDO / np.pi * 2.0 * (np.sin(1.0) + np.sin(0.2)) / 1.2  # mean of cos over the turn
    assert abs(image.mean() / expected - 1) < 2e-3


def blocks(scene, seeds, **settings):
    images = [
        scene.render(size=16, samples=64, seed=seed, **NO_LIMIT, **settings)["Combined"]
        for seed in range(seeds)
    ]
    return np.array(images).reshape(seeds, 4, 4, 4, 4, 3).mean((2, 4))


def moments_of(images):
    whole = images.mean((1, 2))
    return tuple((x.mean(0), x.var(0, ddof=1) / len(images)) for x in (images, whole))


def test_among_many_lamps_area_and_spot_lamps_give_the_mean_of_their_stills():
    """More lamps than are weighed one by one, so that a tree chooses; fog, so that rays of volumes meet them.
    False alarm 1e-4 (comparison.py)."""
    times = (np.arange(12) + 0.5) / 12

    def area(t):
        return turned(-0.6 + 1.2 * t, (-1 + 2 * t, 0.3, 1.2))

    def spot(t):
        return turned(0.5 - 0.8 * t, (0.5, -1 + t, 1.5))

    def scene(place_area, place_spot, **moving):
        area_motion, spot_motion = moving.get("area"), moving.get("spot")
        lamps = [
            d.Light("area", "area", place_area, (20.0,) * 3, size=(0.8, 0.4), motion=area_motion),
            d.Light("spot", "spot", place_spot, (10.0,) * 3, radius=0.1, spot_size=0.9, motion=spot_motion),
        ]
        for n in range(20):
            place = placed(np.cos(n) * 1.5, np.sin(n) * 1.5, 0.5)
            lamps.append(d.Light(f"lamp {n}", "point", place, (0.2,) * 3, radius=0.05))
        result = lit(*lamps)
        result.world = d.World(None, (d.VolumeClosure((0.1,) * 3, (0.05,) * 3),))
        return result

    steps = np.linspace(0, 1, 33)
    moving = scene(
        area(0.5), spot(0.5), area=np.stack([area(t) for t in steps]), spot=np.stack([spot(t) for t in steps])
    )
    one = blocks(moving, 8)
    stills = np.mean([blocks(scene(area(t), spot(t)), 8) for t in times], axis=0)
    assert_same(moments_of(one), moments_of(stills), 8)
