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
    DOWN,
    HALF_DIGIT,
    TABLE_ALBEDOS,
    UP,
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


# DISORT's test suite (Stamnes et al. 1988; disotest of nanodisort and cdisort), problem 1 after van de Hulst
# 1980, volume 1 table 12, problem 3 after volume 2 table 37. Beams carry flux pi onto the slab. Radiance at
# mu = 0.1, 0.5, 1 upwards above the slab and (diffuse) downwards below it.
BEAMS = {
    "1a 1b": (0.03125, (0.2, 1.0, 1.0), 0.0, 0.1,
        ((0.117771, 0.622884), (0.0264170, 0.139763), (0.0134041, 0.0709192)),
        ((0.115898, 0.613458), (0.0263324, 0.139337), (0.0133826, 0.0708109))),
    "1d 1e": (32, (0.2, 1.0, 1.0), 0.0, 0.1,
        ((0.262972, 1.93321), (0.0906967, 1.02732), (0.0502853, 0.797199)),
        ((0.0, 0.0116385), (0.0, 0.0187805), (0.0, 0.0271316))),
    "3a": (1, (1.0, 1.0, 1.0), 0.75, 1.0,
        ((0.151159,), (0.101103,), (0.0395460,)), ((0.213750,), (0.266648,), (3.05855,))),
    "3b": (8, (1.0, 1.0, 1.0), 0.75, 1.0,
        ((0.379740,), (0.519598,), (0.493302,)), ((0.236362,), (0.422350,), (0.669581,))),
}  # fmt: skip
MU = (0.1, 0.5, 1.0)


@pytest.mark.parametrize("case", BEAMS)
@pytest.mark.parametrize("below", [False, True], ids=["above", "below"])
def test_slab_under_a_beam_is_disort(case, below):
    b, albedos, g, mu0, above_table, below_table = BEAMS[case]
    samples, most = (40, 0.1) if b == 32 else (64, 0.02)
    for mu, values in zip(MU, below_table if below else above_table, strict=True):
        scene = slab(b, closure(albedos, g), camera(b, mu, below), lights=(beam(mu0, np.pi / mu0),))
        expected = [values[0], values[-1], values[-1]]
        assert_mean(radiance(scene, samples), expected, rounding=1e-5, most=most)


# DISORT's problem 1, isotropic light of radiance 1 from above, a = 0.99; below, unscattered light counts.
ISOTROPIC = {0.03125: ((0.133177, 0.0299879, 0.0152233), (0.863946, 0.969363, 0.984447)),
             32: ((0.877510, 0.815136, 0.752715), (0.000779280, 0.00126492, 0.00186840))}  # fmt: skip


@pytest.mark.parametrize("b", ISOTROPIC)
@pytest.mark.parametrize("below", [False, True], ids=["above", "below"])
def test_slab_under_isotropic_light_is_disort(b, below):
    for mu, value in zip(MU, ISOTROPIC[b][below], strict=True):
        scene = slab(b, closure((0.99,) * 3), camera(b, mu, below), UP)
        assert_mean(radiance(scene, 32 if b == 32 else 128), value, rounding=2e-5, most=0.02)


# Chandrasekhar's H function for isotropic scattering (400-point Gauss quadrature; H(1) at a = 1 is 2.9078):
# BRF(mu, mu0) = a H(mu) H(mu0) / (4 (mu + mu0)) = pi L / E; R(mu0) = 1 - sqrt(1 - a) H(mu0).
H = {
    0.1: (1.072369, 1.172143, 1.224875),
    0.5: (1.187735, 1.556034, 1.848601),
    1.0: (1.251260, 1.850099, 2.472793),
}


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
