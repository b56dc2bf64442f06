# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps, cameras, linking and geometry, each against Cycles; the comparison and its false alarms are those of
test_against_cycles.py. Hair is held to the image's mean alone: ours is tubes of six sides, Cycles' round
curves and ribbons that face each ray."""

import pytest
from scene_cases import CASES, stage
from test_against_cycles import compare, ours

from bench import cycles

QUICK = {"seen lamp", "area picture", "received", "blocked", "equisolid"}
SHARES = {"thick curves": 0.01, "ribbons": 0.03}  # case -> how far means may be apart
SIZE, THEIR_SAMPLES, OUR_SAMPLES, BOUNCES = (48, 32), 48, 96, 6


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK else pytest.mark.long) for name in CASES]
)
def test_agrees_with_cycles(bpy, name, tmp_path):
    stage(bpy)
    CASES[name](bpy)
    path = tmp_path / "case.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    if name in SHARES:
        assert_means_agree(path, SHARES[name], tmp_path)
    else:
        compare(path, SIZE, THEIR_SAMPLES, OUR_SAMPLES, BOUNCES, tmp_path)


def assert_means_agree(path, share, folder):
    """Asserts that the means of both renderers' images, noise of some 0.2 %, are within `share`."""
    seeds = (1, 2, 3, 4)
    job = cycles.Job(str(path), SIZE, THEIR_SAMPLES, seeds, BOUNCES, pixel_filter="BOX")
    theirs = cycles.render(job).passes["Combined"].mean((0, 1, 2))
    limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), BOUNCES)
    scene = ours.export(path, folder, SIZE)
    images, _ = ours.render(scene, seeds, samples=OUR_SAMPLES, pixel_filter="box", threads=2, **limits)
    ratio = images["Combined"].mean((0, 1, 2)) / theirs
    assert scene.warnings == ()
    assert abs(ratio - 1).max() < share, ratio
