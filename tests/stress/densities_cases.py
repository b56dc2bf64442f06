# SPDX-License-Identifier: GPL-3.0-or-later
"""Density grids: spikes, single voxels, tiles, emptiness, and voxels of any size."""

import numpy as np
from judge import GRIDS, TRACKED, Case, Twin
from nephele import description as d
from stages import WHITE, centred, smoke, vdb
from truth import Scene, half_world, medium, orthographic

NEAREST = {"interpolation": "nearest"}
PLAIN = Twin(settings={"integrator": "plain"})
UP = half_world(1.0)


def spike(_):
    """16^3 ones around a voxel of a million, inside one of the 8 cells that have bounds of their own."""
    values = np.ones((16, 16, 16))
    values[12, 12, 12] = 1e6
    return values


def spike_in_nothing(_):
    values = np.zeros((16, 16, 16))
    values[12, 12, 12] = 1e9
    return values


def one_voxel(grid):
    grid.fill((0, 0, 0), (0, 0, 0), 1.0)


def one_tile(grid):
    """A constant node of 8^3 voxels, and nothing else."""
    grid.fill((0, 0, 0), (7, 7, 7), 1.0)
    grid.prune()


def big_tile(grid):
    grid.fill((0, 0, 0), (127, 127, 127), 1.0)
    grid.prune()


def background_only(grid):
    return None


def ones(_):
    return np.ones((16, 16, 16))


def checkers(_):
    i, j, k = np.mgrid[:16, :16, :16]
    return np.where((i + j + k) % 2, 1e6, 1e-6)


def denormal(_):
    return np.full((16, 16, 16), 1e-42)


def huge(_):
    return np.full((16, 16, 16), 1e30)


def staircase(_):
    """From 1e-6 to 1e5 along z. Through a cell a path takes as many steps as the densest voxel makes it
    deep."""
    values = 10.0 ** np.linspace(-6, 5, 16)
    return np.broadcast_to(values, (16, 16, 16)).copy()


def balanced(values, count, sigma, albedo=0.8, **more):
    a = sigma * (1 - albedo)
    closure = d.VolumeClosure(
        (sigma * albedo,) * 3, (a,) * 3, phase=d.Phase(a=more.pop("g", 0.0)), density_grid="density"
    )
    shining = d.VolumeClosure(emission=(a,) * 3, emission_grid="density")
    voxel = more.pop("voxel", 1.0)
    view = orthographic(
        (0.3 * voxel, 0.2 * voxel, 2 * count * voxel), (0.3 * voxel, 0.2 * voxel, 0), 1e-3 * voxel
    )
    return Scene(view, WHITE).add_volume(
        vdb(values, **more), closure, shining, world_from_object=centred(count, voxel)
    )


def absorbing(values, count, sigma, voxel=1.0, beam=(0.3, 0.2), background=0.0):
    return smoke(vdb(values, 1.0, background), count, 0.0, sigma, voxel, beam=beam)


CASES = [
    # Beside the spike, by the bounds of other cells; through it.
    Case(
        "beside a spike",
        lambda: absorbing(spike, 16, 0.05, beam=(-5.2, -4.7)),
        np.exp(-0.8),
        GRIDS,
        settings=NEAREST,
        quick=True,
    ),
    # A ray that passes the spike's cell takes as many steps as the spike is deep there: fewer paths.
    Case(
        "through a spike",
        lambda: absorbing(spike, 16, 0.005, beam=(4.5, 4.5)),
        0.0,
        GRIDS,
        settings=NEAREST,
        size=4,
        samples=8,
    ),
    Case(
        "through a faint spike",
        lambda: absorbing(spike, 16, 1e-6, beam=(4.5, 4.5)),
        np.exp(-1.000015),
        GRIDS,
        settings=NEAREST,
        most=0.05,
    ),
    Case(
        "beside a spike in its cell",
        lambda: absorbing(spike, 16, 1e-3, beam=(4.5, 2.2)),
        np.exp(-0.016),
        GRIDS,
        settings=NEAREST,
        size=8,
        samples=16,
        most=0.05,
    ),
    *(
        Case(
            f"balance of a spike, {sigma:g}/m",
            lambda sigma=sigma: balanced(spike, 16, sigma),
            1.0,
            GRIDS,
            size=8,
            samples=16,
            rounding=2e-3,  # so few paths may miss what 1 in 3000 meets
            most=0.1,
            cpu=30,
        )
        for sigma in (1e-6, 1e-4)
    ),
    Case(
        "balance of a spike of 1e9 in nothing",
        lambda: balanced(spike_in_nothing, 16, 1e-6),
        1.0,
        ("default", "delta", "exact", "field"),
        size=8,
        samples=8,
        most=0.1,
        cpu=60,
    ),
    # Single voxels and tiles: 1 m of 0.7/m.
    Case(
        "one voxel",
        lambda: absorbing(one_voxel, 1, 0.7, beam=(0.2, 0.1)),
        np.exp(-0.7),
        GRIDS,
        settings=NEAREST,
        quick=True,
    ),
    Case(
        "one voxel, trilinear",
        lambda: absorbing(one_voxel, 1, 0.7, beam=(0.0, 0.0)),
        np.exp(-0.7),
        GRIDS,
        rounding=2e-3,
    ),
    Case(
        "one voxel, tricubic",
        lambda: absorbing(one_voxel, 1, 0.7, beam=(0.2, 0.1)),
        PLAIN,
        GRIDS,
        settings={"interpolation": "tricubic"},
    ),
    Case("one tile", lambda: absorbing(one_tile, 8, 0.1), np.exp(-0.8), GRIDS, settings=NEAREST),
    Case(
        "a tile of 128 voxels", lambda: absorbing(big_tile, 128, 0.01), np.exp(-1.28), GRIDS, settings=NEAREST
    ),
    Case("background alone", lambda: absorbing(background_only, 16, 1.0), 1.0, GRIDS, quick=True),
    Case("background of 5 alone", lambda: absorbing(background_only, 16, 1.0, background=5.0), 1.0, TRACKED),
    # The grid's box ends half a voxel beyond the outermost one, and holds the background there.
    Case(
        "ones in a background of 5",
        lambda: absorbing(ones, 16, 0.05, background=5.0),
        np.exp(-1.05),
        GRIDS,
        settings=NEAREST,
    ),
    Case("denormal densities", lambda: absorbing(denormal, 16, 1.0), 1.0, GRIDS),
    Case(
        "densities of 1e30 at 1e-31/m",
        lambda: absorbing(huge, 16, 0.5e-31),
        np.exp(-0.8),
        GRIDS,
        settings=NEAREST,
    ),
    Case("balance of densities of 1e30", lambda: balanced(huge, 16, 1e-27), 1.0, GRIDS),
    Case(
        "balance of checkers of 1e12",
        lambda: balanced(checkers, 16, 1.0),
        1.0,
        GRIDS,
        size=8,
        samples=16,
        most=0.1,
        cpu=30,
    ),
    Case(
        "balance of a staircase of 1e11",
        lambda: balanced(staircase, 16, 1.0),
        1.0,
        GRIDS,
        size=8,
        samples=64,
        most=0.1,
        cpu=30,
    ),
    Case(
        "staircase against its twin",
        lambda: smoke(vdb(staircase), 16, 1e-3, 1e-3, world=UP, beam=(0.3, 0.2)),
        Twin(settings={"distance_sampling": "delta", "train_field": "never"}),
        ("default", "exact", "field"),
        size=8,
        samples=64,
        most=0.1,
        cpu=30,
    ),
    # Voxels of any size at the same depths.
    *(
        Case(
            f"voxels of {voxel:g} m",
            lambda voxel=voxel: absorbing(ones, 16, 0.05 / voxel, voxel),
            np.exp(-0.8),
            GRIDS,
            settings=NEAREST,
            quick=voxel == 1e-6,
        )
        for voxel in (1e-6, 1e-3, 1e3, 1e6)
    ),
    *(
        Case(
            f"balance of voxels of {voxel:g} m",
            lambda voxel=voxel: balanced(ones, 16, 0.2 / voxel, voxel=voxel, g=0.8),
            1.0,
            GRIDS,
        )
        for voxel in (1e-6, 1.0, 1e6)
    ),
    *(
        Case(
            f"light on voxels of {voxel:g} m",
            lambda voxel=voxel: smoke(vdb(ones), 16, 0.1 / voxel, 0.02 / voxel, voxel, UP),
            Twin(lambda: smoke(vdb(ones), 16, 0.1, 0.02, 1.0, UP)),
            TRACKED,
            samples=256,
        )
        for voxel in (1e-6, 1e6)
    ),
    # Two grids of unlike scale that overlap.
    Case(
        "a spike in voxels of 1e-3 m inside voxels of 1 m",
        lambda: balanced(ones, 16, 0.2).add_volume(
            vdb(spike, 1e-3), medium(0.0, 0.0, density_grid="density")
        ),
        1.0,
        TRACKED,
    ),
]
