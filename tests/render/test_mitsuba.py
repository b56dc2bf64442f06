# SPDX-License-Identifier: GPL-3.0-or-later
"""Mitsuba 3's participating media test scenes against Mitsuba's own images of 32000 paths a pixel, where
shared/data/mitsuba_pm is present.

As in Mitsuba's own test: a z-test at each pixel in CIE XYZ (the references' variances were converted as
colours, from XYZ), Sidak-corrected to a significance of 0.01 over the pixels; 99.75 % of them must pass. Our
variance comes from the scatter of renders with different seeds, hence Student's t. Two stricter tests follow:
the means of blocks of 6 x 6 pixels and of the whole image, each with false alarm 1e-4 a scene (Sidak).

All seven scenes; the last has no medium, but surfaces of plastic, smooth and rough. The one of glass has more
samples: its coarse pedestal shows what smooth normals do to refraction, differences of 3 %.
"""

from pathlib import Path

import mitsuba_media
import mitsuba_xml
import numpy as np
import pytest
import scipy.stats
from truth import finished

FOLDER = Path(__file__).resolve().parents[3] / "shared/data/mitsuba_pm/tests/scenes/participating_media"
XYZ_FROM_RGB = np.array(
    [[0.412453, 0.357580, 0.180423], [0.212671, 0.715160, 0.072169], [0.019334, 0.119193, 0.950227]]
)
REFERENCE_SAMPLES = 32000
SEEDS = 16
FALSE_ALARM = 1e-4

pytestmark = pytest.mark.skipif(not FOLDER.exists(), reason="shared/data/mitsuba_pm is not there")


def xyz(rgb):
    return rgb @ XYZ_FROM_RGB.T


def blocks(image, size):
    n = image.shape[-3] // size
    return image.reshape(*image.shape[:-3], n, size, n, size, 3).mean((-4, -2))


def p_values(images, reference, variance):
    """Returns two-sided p-values. images (seeds, ...); reference and its squared standard error (...)."""
    seeds = len(images)
    own = images.var(0, ddof=1) / seeds
    both = own + variance
    t = np.abs(images.mean(0) - reference) / np.sqrt(both)
    freedom = (seeds - 1) * np.square(both / np.maximum(own, 1e-30))  # Welch and Satterthwaite
    return 2 * scipy.stats.t.sf(t, np.minimum(freedom, 1e6))


def assert_like_mitsuba(name, grid_medium, samples, **settings):
    scenes = [
        mitsuba_xml.Reader(next(FOLDER.glob(f"{name}_vol*.xml")), grid_medium).description(
            samples=samples, seed=seed, **settings
        )
        for seed in range(SEEDS)
    ]
    images = xyz(np.array([finished(scene)["Combined"] for scene in scenes]))
    reference, variance = (
        xyz(mitsuba_xml.read_exr(FOLDER / "refs" / f"{name}_ref_rgb{end}.exr")) for end in ("", "_var")
    )
    variance = np.maximum(variance, 1e-4) / REFERENCE_SAMPLES
    pixels = reference.shape[0] * reference.shape[1]
    p = p_values(images, reference, variance)
    passed = np.mean(p > 1 - (1 - 0.01) ** (1 / pixels))
    print(f"{name}: {100 * passed:.3f} % of pixels pass")
    print("means", images.mean((0, 1, 2)) / reference.mean((0, 1)) - 1)
    assert passed >= 0.9975
    for size in (6, 48):
        block_variance = blocks(variance, size) / size**2
        p = p_values(blocks(images, size), blocks(reference, size), block_variance)
        worst = np.unravel_index(p.argmin(), p.shape)
        assert p.min() > 1 - (1 - FALSE_ALARM) ** (1 / p.size), (
            f"blocks of {size}: {worst} is {blocks(images, size).mean(0)[worst]:.5g}, Mitsuba's "
            f"{blocks(reference, size)[worst]:.5g}, p = {p.min():.1e}"
        )


@pytest.mark.parametrize(
    ("name", "samples"),
    [
        ("test_homo_null_envmap", 54),
        ("test_homo_area_light", 108),
        ("test_homo_dielectric_envmap", 160),
        ("test_hetero_spectral_sigmat_no_scattering", 54),
        ("test_surf_area_light", 108),
    ],
)
def test_constant_media(name, samples):
    assert_like_mitsuba(name, None, samples)


def test_grid_of_numbers(tmp_path, openvdb):
    medium = mitsuba_media.scaled_density(openvdb, tmp_path / "sigma_t.vdb")
    assert_like_mitsuba("test_hetero_sigmat", medium, 54)


@pytest.mark.parametrize("name", ["test_hetero_sigmat", "test_hetero_spectral_sigmat"])
def test_grid_of_colors(tmp_path, openvdb, name):
    medium = mitsuba_media.colored(openvdb, tmp_path / "sigma_t.vdb")
    assert_like_mitsuba(name, medium, 54)
