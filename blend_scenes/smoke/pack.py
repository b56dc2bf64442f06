# SPDX-License-Identifier: GPL-3.0-or-later
"""Repack frames of a baked fluid cache as small VDB files (run by bake.sh).

    python pack.py CACHE_DIRECTORY FRAME FRAME...

Writes smoke_0001.vdb, smoke_0002.vdb, ... beside this file, with the grids
    density      dimensionless, in [0, 1];
    temperature  kelvin, only where something burns;
both in world coordinates of the bake. A cache's voxel (i, j, k) is a cell whose *centre* stands at
domain minimum + (i + 1/2, j + 1/2, k + 1/2) cells, although the file's own transform says (i, j, k).
"""

import json
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now

LEAST_DENSITY = 0.02
LEAST_FLAME = 0.05
COOLEST_FLAME_K, HOTTEST_FLAME_K = 800.0, 2000.0


def dense(grid, shape):
    """Values of all cells of the domain, float32 `shape`."""
    array = np.zeros(shape, np.float32)
    grid.copyToArray(array, ijk=(0, 0, 0))
    return array


def pack(cache_directory, frame, path):
    """Read one frame of the cache and write it to `path`."""
    domain = json.loads((cache_directory / "domain.json").read_text(encoding="utf-8"))
    source = cache_directory / "data" / f"fluid_data_{frame:04d}.vdb"
    grids = {grid.name: grid for grid in common.openvdb.readAll(str(source))[0]}
    cell = grids["density"].transform.voxelSize()[0]
    low, high = np.array(domain["min"]), np.array(domain["max"])
    shape = tuple(np.round((high - low) / cell).astype(int))

    density = dense(grids["density"], shape)
    density = np.where(density < LEAST_DENSITY, 0, density)
    flame = np.clip(dense(grids["flame"], shape), 0, 1)
    kelvin = COOLEST_FLAME_K + (HOTTEST_FLAME_K - COOLEST_FLAME_K) * flame
    kelvin = np.where(flame < LEAST_FLAME, 0, kelvin)
    arrays = {"density": common.quantise(density, 128), "temperature": common.quantise(kelvin, 1 / 16)}
    common.write_vdb(path, arrays, cell, low + cell / 2)


def main(cache_directory, frames):
    """Pack the frames in order; number the files from 1."""
    for number, frame in enumerate(frames, start=1):
        path = FOLDER / f"smoke_{number:04d}.vdb"
        pack(cache_directory, frame, path)
        print(path, path.stat().st_size, "bytes")


main(Path(sys.argv[1]), [int(frame) for frame in sys.argv[2:]])
