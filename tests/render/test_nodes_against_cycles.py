# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader nodes beside Cycles 5.0: every tile of node_cases.py shines with one output, so that pictures are
compared pixel by pixel, without noise. Both renderers sample pixels at their middles (a filter 0.01 pixels
wide).

Most cases read the middle of the pixel, which is the same number in both. Values agree to TOLERANCE of the
larger of 1 and themselves; where a pattern jumps, the last bit of a coordinate decides, so that up to
OUTLIERS of a tile's pixels may differ. What reads the surface itself sees the pixel's place as the filter
draws it, to 2e-3 units of a tile that is 2 wide: PLACED."""

import numpy as np
import pytest
from node_cases import CASES, PIXELS, build, tile_of
from nodes_inputs import CASES as INPUTS
from tiles import both

TOLERANCE, PLACED, OUTLIERS = 2e-4, 6e-3, 2 / PIXELS**2
LOOSE = {
    # Tangents are smooth in Cycles (MikkTSpace), constant over a triangle here.
    "tangent of a uv map": 0.06,
    "normal map TANGENT": 0.02,
    "bump of an attribute on a normal map": 0.02,
    "vector displacement TANGENT": 0.02,
    # Tangents of circles around an axis turn fast near it.
    "tangent X": 0.02,
    "tangent Y": 0.02,
    # The object's normals are those of the place, and so are the image's coordinates.
    "image BOX 0.0": PLACED,
    "image BOX 0.4": PLACED,
    "blackbody": 2e-3,  # Planck's law against a fit of it
    # Cycles keeps other colour spaces as half floats, and bytes multiplied by alpha as bytes.
    "image AgX Base sRGB": 0.01,
    "image Filmic sRGB": 0.01,
    "image Linear Rec.2020": 0.01,
    "image sRGB beside alpha": 0.06,
    "image Non-Color beside alpha": 0.01,
    "image sRGB translucent": 0.01,
}


def tolerance_of(name):
    return LOOSE.get(name, PLACED if name in INPUTS else TOLERANCE)


@pytest.fixture(scope="module")
def renders(tmp_path_factory):
    """Returns (our image, Cycles' image, columns) of all cases."""
    import bpy

    return both(bpy, tmp_path_factory.mktemp("nodes"), lambda host: build(host, CASES), PIXELS)


@pytest.mark.parametrize("name", CASES)
def test_node_agrees_with_cycles(renders, name):
    number, columns = list(CASES).index(name), renders[2]
    mine, theirs = (tile_of(image, number, columns) for image in renders[:2])
    wrong = (np.abs(mine - theirs) > tolerance_of(name) * np.maximum(1, np.abs(theirs))).any(-1)
    assert wrong.mean() <= OUTLIERS, f"{wrong.mean():.0%} differ, by up to {np.abs(mine - theirs).max():.3g}"
