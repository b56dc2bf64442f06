# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes small VDB files for the loader's fuzz target to start from: `seeds.py FOLDER`.

The other targets start from the scenes and states that they make themselves.
"""

import sys
from pathlib import Path

import bpy
import numpy as np

bpy.utils.expose_bundled_modules()
import openvdb  # noqa: E402 - Blender's own

KINDS = (
    "FloatGrid",
    "DoubleGrid",
    "Int32Grid",
    "Int64Grid",
    "BoolGrid",
    "Vec3SGrid",
    "Vec3DGrid",
    "Vec3IGrid",
)


def small(kind, name="density", half=False):
    """Returns a grid of a leaf or two and a tile, or None where this OpenVDB has no such type."""
    if not hasattr(openvdb, kind):
        return None
    grid = getattr(openvdb, kind)()
    grid.name = name
    grid.saveFloatAsHalf = half
    numbers = np.arange(4 * 3 * 2).reshape(4, 3, 2) % 7
    if kind.startswith("Vec"):
        values, tile = np.stack([numbers] * 3, -1), (1, 2, 3)
    else:
        values, tile = numbers, kind == "BoolGrid" or 1
    grid.copyFromArray(values.astype(bool if kind == "BoolGrid" else float), ijk=(-2, 0, 5))
    grid.fill((64, 0, 0), (71, 7, 7), tile, active=True)
    return grid


def write_all(folder):
    openvdb.write(str(folder / "half.vdb"), grids=[small("FloatGrid", half=True)])
    openvdb.write(str(folder / "two.vdb"), grids=[small("BoolGrid", "first"), small("Vec3SGrid", "velocity")])
    for kind in KINDS:
        if grid := small(kind):
            openvdb.write(str(folder / f"{kind}.vdb"), grids=[grid])


if __name__ == "__main__":
    write_all(Path(sys.argv[1]))
