# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, cameras, linking and geometry, each against Cycles; the comparison and its false alarms are those of
test_against_cycles.py."""

import pytest
from scene_cases import CASES, stage
from test_against_cycles import compare


@pytest.mark.parametrize("name", CASES)
def test_agrees_with_cycles(bpy, name, tmp_path):
    stage(bpy)
    CASES[name](bpy)
    path = tmp_path / "case.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    compare(path, (48, 32), 48, 96, 6, tmp_path)
