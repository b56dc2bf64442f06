# SPDX-License-Identifier: GPL-3.0-or-later
"""One extreme upon another: scale and density, distance and thinness, guiding and light, colour and shape."""

import numpy as np
from judge import GRIDS, TRACKED, Case, Twin
from nephele import description as d
from stages import WHITE, balanced, block, centred, floor, stage, vdb
from truth import Scene, box, diffuse, glass, half_world, medium, orthographic, perspective, placed, sphere

SOME = ("default", "delta", "exact", "field")
NEAREST = {"interpolation": "nearest"}
UP = half_world(1.0)
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
SHEAR = np.array([(1, 3, 0, 0), (0, 1, 0, 0), (0, 0, 1e-3, 0), (0, 0, 0, 1.0)])


def ones(_):
    return np.ones((16, 16, 16))


def spike(_):
    values = np.ones((16, 16, 16))
    values[12, 12, 12] = 1e6
    return values


def far_sheared_smoke(offset, sigma_t, voxel):
    """A grid of small voxels, sheared, flattened and mirrored, far from the origin."""
    o = np.array(offset)
    place = placed(*offset) @ MIRROR @ SHEAR @ centred(16, voxel)
    above, aim = np.array((0.02, 0.2, 40)) * voxel, np.array((0.02, 0.2, 0)) * voxel
    view = orthographic(o + above, o + aim, 1e-3 * voxel)
    closure = medium(0.0, sigma_t, density_grid="density")
    return Scene(view, WHITE).add_volume(vdb(ones), closure, world_from_object=place)


def planet():
    """A ball of 6.4e6 m in thin air of some km, seen from its ground; a sun, and a grain of 1 mm in front."""
    r = 6.4e6
    sun = d.Light("sun", "sun", np.eye(4), (1e3,) * 3, angle=0.0093)
    scene = Scene(perspective((0, 0, 2), (1, 0, 2), 0.3), lights=(sun,))
    scene.add(sphere(r, 6, "ground"), diffuse(0.3), (), placed(0, 0, -r))
    air = medium((5e-6, 1.2e-5, 3e-5), 1e-7, 0.0)
    scene.add(sphere(r + 1e4, 6, "air"), None, (air,), placed(0, 0, -r))
    return scene.add(
        box((-1e-3, -1e-3, -1e-3), (1e-3, 1e-3, 1e-3), "grain"), diffuse(0.9), (), placed(0.1, 0, 2)
    )


def galaxy_in_a_box(power):
    """Lamps of unlike power over 1e12 in a fog."""
    lights = tuple(
        d.Light(
            f"star {i}",
            "point",
            placed(np.sin(i), np.cos(2 * i), np.sin(3 * i)),
            (power * 10.0**-i,) * 3,
            radius=1e-3,
        )
        for i in range(13)
    )
    return block(0.4, 0.1, world=None, lights=lights)


def spike_in_balance(voxel):
    """A spike of 1e6 times what is around it that shines at its absorption."""
    closure = medium(4e-6 / voxel, 1e-6 / voxel, 0.5, density_grid="density")
    shining = d.VolumeClosure(emission=(1e-6 / voxel,) * 3, emission_grid="density")
    view = orthographic((4.5 * voxel, 4.5 * voxel, 40 * voxel), (4.5 * voxel, 4.5 * voxel, 0), 1e-3 * voxel)
    return Scene(view, WHITE).add_volume(vdb(spike), closure, shining, world_from_object=centred(16, voxel))


def glass_in_dense_fog(size):
    """A ball of glass full of milk in a fog, in balance."""
    s = 5.0 / size
    fog = d.VolumeClosure((0.8 * s,) * 3, (0.2 * s,) * 3, (0.2 * s,) * 3)
    milk = d.VolumeClosure((8 * s,) * 3, (2 * s,) * 3, (2 * s,) * 3)
    scene = Scene(perspective((0, -4 * size, size), (0, 0, 0), 0.1), WHITE)
    scene.add(box((-size,) * 3, (size,) * 3, "fog"), None, (fog,))
    return scene.add(sphere(0.5 * size, 3, "glass"), glass(1.5), (milk,))


def unlike_lamps():
    """A floor under 10,000 lamps of 1e-20 W and one of 1e20 W."""
    lamps = [
        d.Light(f"{i}", "point", placed(np.sin(i), np.cos(i), 1 + i / 1e4), (1e-20,) * 3)
        for i in range(10_000)
    ]
    lamps.append(d.Light("bright", "point", placed(0, 0, 1), (4e20 * np.pi,) * 3))
    return floor(0.7, tuple(lamps))


CASES = [
    *(
        Case(
            f"sheared smoke of {voxel:g} m 1e7 m off",
            lambda voxel=voxel, o=o: far_sheared_smoke(o, 50 / voxel, voxel),
            np.exp(-0.8),
            TRACKED,
            settings=NEAREST,
            rounding=2e-3,
            quick=voxel == 1e-2,
        )
        for voxel, o in ((1e-2, (1e7, -1e7, 1e7)), (1.0, (1e7, -1e7, 1e7)), (1e3, (-1e7, 0, 0)))
    ),
    *(
        Case(
            f"balance of a spike in {voxel:g} m",
            lambda voxel=voxel: spike_in_balance(voxel),
            1.0,
            GRIDS,
            size=8,
            samples=16,
            most=0.1,
            cpu=30,
        )
        for voxel in (1e-6, 1e4)
    ),
    Case(
        "a planet",
        planet,
        Twin(settings={"train_field": "never", "distance_sampling": "delta"}),
        SOME,
        samples=128,
        most=0.1,
        cpu=30,
    ),
    *(
        Case(
            f"stars of {p:g} W and less",
            lambda p=p: galaxy_in_a_box(p),
            Twin(lambda: galaxy_in_a_box(1.0), settings={"train_field": "never"}, scale=p),
            SOME,
            samples=256,
            most=0.1,
            cpu=20,
        )
        for p in (1e-20, 1e20)
    ),
    *(
        Case(
            f"glass of milk in fog, {size:g} m",
            lambda size=size: glass_in_dense_fog(size),
            1.0,
            SOME,
            samples=128,
            most=0.05,
            rounding=1e-3,
            cpu=30,
        )
        for size in (1e-4, 1.0, 1e6)
    ),
    *(
        Case(
            f"thin stage of 1e20 W 1e7 m off, {size:g} m",
            lambda size=size: stage((1e7, -1e7, 1e7), size, 1e-3, 1e20),
            Twin(lambda: stage(thickness=1e-3), scale=1e20),
            SOME,
            samples=128,
            most=0.06,
            rounding=2e-3,
            cpu=30,
        )
        for size in (1.0, 1e4)
    ),
    *(
        Case(
            f"dense stage of {p:g} W, {size:g} m",
            lambda size=size, p=p: stage(size=size, thickness=100.0, power=p),
            Twin(lambda: stage(thickness=100.0), scale=p),
            SOME,
            samples=128,
            most=0.06,
            rounding=2e-3,
            cpu=60,
        )
        for size, p in ((1e-4, 1e20), (1e6, 1e-20))
    ),
    Case(
        "balance of colours 1e6 apart far off",
        lambda: balanced((9e-4, 0.9, 900), (1e-4, 0.1, 100), at=(1e7, 1e7, -1e7)),
        1.0,
        TRACKED,
        samples=256,
    ),
    Case(
        "balance of 1e9/m forwards 1e-4 m",
        lambda: balanced(0.8e9, 0.2e9, half=1e-4, g=0.9999),
        1.0,
        TRACKED,
        samples=256,
        cpu=60,
        most=0.05,
    ),
    Case("furnace of colours 1e6 apart", lambda: block((1e-6, 1e-3, 1.0), 0.0, g=-0.9999), 1.0, TRACKED),
    Case(
        "colours 1e6 apart under a sky",
        lambda: block((9e-4, 0.9, 900), (1e-4, 0.1, 100), world=UP),
        Twin(settings={"distance_sampling": "delta", "train_field": "never"}),
        ("default", "exact", "field"),
        samples=256,
        cpu=30,
    ),
    Case(
        "absorption of colours 1e12 apart",
        lambda: block(0.0, (1e-6, 0.5, 1e6)),
        np.exp([-2e-6, -1.0, -2e6]),
        GRIDS,
    ),
    Case(
        "lamp of 1e6 m in a fog of 1e-4 m",
        lambda: block(
            5e3, 1e3, 1e-4, None, (d.Light("wide", "area", placed(0, 0, 1e3), (1e13,) * 3, size=(1e6, 1e6)),)
        ),
        None,
        SOME,
    ),
    Case(
        "10,000 faint lamps and one of 1e20 W",
        unlike_lamps,
        0.7e20 / np.pi,
        ("default", "field"),
        rounding=1e-4,
    ),
]
