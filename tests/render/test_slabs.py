# SPDX-License-Identifier: GPL-3.0-or-later
"""Plane-parallel slabs and half-spaces against published and independently computed numbers.

The slab is a box 2000 mean free paths wide, or a grid stretched as wide, so that nothing reaches its sides.
The camera's rays are parallel; all pixels are independent estimates of one radiance. Channels carry different
albedos at the same extinction 1/m, so one render answers three cases. b: optical thickness; a:
single-scattering albedo; g: Henyey-Greenstein mean cosine; mu: cosine to the normal; matched index, black
surroundings.

False alarm: 5 standard errors, 6e-7 for each of about 150 numbers. `most` bounds the standard error, so that
a test cannot pass by noise.
"""

import numpy as np
import pytest
from slabs import (
    ADDING_DOUBLING,
    ALBEDOS,
    BEAMS,
    DOWN,
    HALF_DIGIT,
    ISOTROPIC,
    MU,
    TABLE_ALBEDOS,
    UP,
    H,
    beam,
    camera,
    closure,
    radiance,
    slab,
)  # fmt: skip
from truth import Scene, assert_mean


@pytest.mark.parametrize(("g", "b"), ADDING_DOUBLING)
@pytest.mark.parametrize("side", [0, 1], ids=["reflectance", "transmittance"])
def test_slab_under_diffuse_light_is_adding_doubling(g, b, side):
    table = np.array(ADDING_DOUBLING[g, b][side])
    for picked in ((0, 1, 2), (1, 2, 3)):
        albedos = np.array(TABLE_ALBEDOS)[list(picked)]
        scene = slab(b, closure(albedos, g), camera(b, 1.0, below=side == 1), UP)
        expected = table[list(picked)]
        assert_mean(radiance(scene, 128), expected, rounding=HALF_DIGIT / expected, most=0.01)


@pytest.mark.parametrize(
    "settings", [{"majorant": "grid"}, {"majorant": "global", "tracking": "delta"}], ids=str
)
def test_slab_of_a_grid_is_adding_doubling(tmp_path, openvdb, settings):
    """A slab knows its optical thickness alone: the ramps of interpolation at its faces change nothing."""
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.fill((0, 0, 0), (31, 31, 31), 1.0)
    openvdb.write(str(tmp_path / "slab.vdb"), [grid])
    stretch = np.diag([100.0, 100.0, 1 / 32, 1.0])  # 32 voxels are 1 m thick and 3200 m wide
    stretch[:3, 3] = -1550, -1550, 0.5 / 32
    medium = closure((0.5, 0.9, 1.0), 0.5, density_grid="density")
    for side, world in enumerate((UP, DOWN)):
        scene = Scene(camera(1, 1.0), world).add_volume(
            tmp_path / "slab.vdb", medium, world_from_object=stretch
        )
        expected = np.array(ADDING_DOUBLING[0.5, 1][side])[[0, 1, 3]]
        assert_mean(radiance(scene, 64, **settings), expected, rounding=HALF_DIGIT / expected, most=0.01)


@pytest.mark.parametrize("case", BEAMS)
@pytest.mark.parametrize("below", [False, True], ids=["above", "below"])
def test_slab_under_a_beam_is_disort(case, below):
    b, albedos, g, mu0, above_table, below_table = BEAMS[case]
    samples, most = (40, 0.1) if b == 32 else (64, 0.02)
    for mu, values in zip(MU, below_table if below else above_table, strict=True):
        scene = slab(b, closure(albedos, g), camera(b, mu, below), lights=(beam(mu0, np.pi / mu0),))
        expected = [values[0], values[-1], values[-1]]
        assert_mean(radiance(scene, samples), expected, rounding=1e-5, most=most)


@pytest.mark.parametrize("b", ISOTROPIC)
@pytest.mark.parametrize("below", [False, True], ids=["above", "below"])
def test_slab_under_isotropic_light_is_disort(b, below):
    for mu, value in zip(MU, ISOTROPIC[b][below], strict=True):
        scene = slab(b, closure((0.99,) * 3), camera(b, mu, below), UP)
        assert_mean(radiance(scene, 32 if b == 32 else 128), value, rounding=2e-5, most=0.02)


@pytest.mark.parametrize(("mu", "mu0"), [(1.0, 1.0), (0.5, 1.0), (1.0, 0.1), (0.1, 0.5)])
def test_half_space_under_a_beam_is_chandrasekhar(mu, mu0):
    a = np.array(ALBEDOS)
    brf = a * np.array(H[mu]) * np.array(H[mu0]) / (4 * (mu + mu0))
    scene = slab(1000, closure(ALBEDOS), camera(1000, mu), lights=(beam(mu0, np.pi / mu0),))
    assert_mean(radiance(scene), brf, rounding=2e-6, most=0.01)


@pytest.mark.parametrize("mu", [0.1, 0.5, 1.0])
def test_half_space_under_diffuse_light_is_chandrasekhar(mu):
    reflectance = 1 - np.sqrt(1 - np.array(ALBEDOS)) * np.array(H[mu])
    scene = slab(1000, closure(ALBEDOS), camera(1000, mu), UP)
    assert_mean(radiance(scene), reflectance, rounding=5e-6, most=0.01)
