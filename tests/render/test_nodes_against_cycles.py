# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes beside Cycles 5.0: every tile of node_cases.py shines with one output, so that pictures are compared
pixel by pixel, without noise. Both renderers sample pixels at their centres (a pixel filter 0.01 pixels wide).

Values agree to TOLERANCE of the larger of 1 and themselves; where a pattern jumps, the last bit of a coordinate
decides, so that up to OUTLIERS of a tile's pixels may differ."""

import sys
from pathlib import Path

import numpy as np
import pytest
from node_cases import CASES, PIXELS, build, tile_of

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import cycles, ours  # noqa: E402  the project's root is on the path only now

TOLERANCE, OUTLIERS = 1e-3, 2 / PIXELS**2
LOOSE = {}  # case -> its own tolerance, and why


@pytest.fixture(scope="module")
def renders(tmp_path_factory):
    """Returns (our image, Cycles' image, columns) of all cases."""
    import bpy

    folder = tmp_path_factory.mktemp("nodes")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    columns, rows = build(bpy, CASES)
    path, size = folder / "nodes.blend", (columns * PIXELS, rows * PIXELS)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    job = cycles.Job(str(path), size, 1, (1,), 0, pixel_filter="GAUSSIAN", filter_width=0.01)
    theirs = cycles.render(job).passes["Combined"][0]
    scene = ours.export(path, folder, size)
    images, _ = ours.render(scene, (1,), samples=1, pixel_filter="gaussian", filter_width=0.01, threads=2)
    return images["Combined"][0], theirs, columns


@pytest.mark.parametrize("name", CASES)
def test_node_agrees_with_cycles(renders, name):
    number, columns = list(CASES).index(name), renders[2]
    mine, theirs = (tile_of(image, number, columns) for image in renders[:2])
    tolerance = LOOSE.get(name, TOLERANCE) * np.maximum(1, np.abs(theirs))
    wrong = (np.abs(mine - theirs) > tolerance).any(-1)
    assert wrong.mean() <= OUTLIERS, f"{wrong.mean():.0%} differ, by up to {np.abs(mine - theirs).max():.3g}"
