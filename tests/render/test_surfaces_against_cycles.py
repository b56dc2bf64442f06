# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shaders beside Cycles 5.0. Every tile of surface_cases.py has one shader: under a sun without size
and without bounces, once before and once behind the tiles, pixels are compared one by one, without noise.

Values agree to TOLERANCE of themselves, or of FLOOR of the tile's brightest pixel where that is more. Pixels
at edges of triangles may see another triangle than Cycles' do: OUTLIERS of a tile.

Left out behind the tiles: directions that no facet on the surface's side refracts into, where Cycles' glass
shines though it never samples them. That sun stands straight behind."""

import numpy as np
import pytest
from surface_cases import CASES, PIXELS, build, tile_of
from tiles import both

TOLERANCE, FLOOR, OUTLIERS = 0.01, 0.02, 4 / PIXELS**2
SUNS = {"before": (-0.5, -0.35, -0.8), "behind": (0.1, 0.05, 1.0)}  # directions that they shine in
LOOSE = {
    # Around the pole of the radial tangent it turns fast, and stretched facets with it.
    "anisotropic": 0.04,
    "anisotropy": 0.04,
    # Other fits of the eye's sensitivity.
    "film": 0.03,
}


def tolerance_of(name):
    return max([TOLERANCE] + [value for word, value in LOOSE.items() if word in name])


@pytest.fixture(scope="module", params=SUNS)
def renders(request, tmp_path_factory):
    """Returns (our image, Cycles' image, columns) of all cases."""
    import bpy

    folder, sun = tmp_path_factory.mktemp("surfaces"), SUNS[request.param]
    return both(bpy, folder, lambda host: build(host, CASES, sun), PIXELS, max_bounces=0)


@pytest.mark.parametrize("name", CASES)
def test_shader_agrees_with_cycles(renders, name):
    number, columns = list(CASES).index(name), renders[2]
    mine, theirs = (tile_of(image, number, columns) for image in renders[:2])
    scale = np.maximum(np.abs(theirs), FLOOR * np.abs(theirs).max() + 1e-7)
    off = (np.abs(mine - theirs) / scale).max(-1)
    wrong = off > tolerance_of(name)
    assert wrong.mean() <= OUTLIERS, f"{wrong.mean():.0%} differ; the median by {np.median(off):.2g}"
