# SPDX-License-Identifier: GPL-3.0-or-later
"""A grid of voxels at random, full or empty and each several mean free paths deep, lit by a sun: light
scattered once against quadrature that shares nothing with the renderer. Dense detail is where an error of
interpolation, of majorants or of shadow rays would show."""

import numpy as np
import pytest
from nephele import description as d
from nephele import vdb_info
from scipy.ndimage import map_coordinates
from truth import BOX_FILTER, Scene, assert_blocks, assert_mean, facing, medium

CORNERS, DEPTH = 13, 6.0  # voxels along an edge, the outer ones empty; optical depth of a full one
PIXELS = 2 * (CORNERS - 1)  # two a voxel


@pytest.fixture(scope="module")
def density():
    """(CORNERS,) * 3, 0 or 1 at the voxels' centres, 3 of 10 full."""
    inner = np.random.default_rng(3).random((CORNERS - 2,) * 3) < 0.3
    return np.pad(inner.astype(np.float32), 1)


def single_scattering(density, fine):
    """Returns the radiance of an isotropic medium of albedo 1 under a sun of irradiance 4 pi from +z, seen
    along +y, (PIXELS, PIXELS), rows upwards: rays through `fine` x `fine` points of a pixel."""
    step = 1 / (2 * fine)  # in voxels; steps end at the voxels' centres, between which density is trilinear
    at = np.arange(step / 2, CORNERS - 1, step)
    radiance = np.empty((len(at), len(at)))
    for column, x in enumerate(at):
        y, z = np.meshgrid(at, at, indexing="ij")
        tau = DEPTH * step * map_coordinates(density, (np.full_like(y, x), y, z), order=1)
        above = np.cumsum(tau[:, ::-1], axis=1)[:, ::-1] - tau
        before = np.cumsum(tau, axis=0) - tau
        within = -np.expm1(-tau)
        lit = np.exp(-above) * np.divide(within, tau, out=np.ones_like(tau), where=tau > 0)  # over the step
        radiance[:, column] = (np.exp(-before) * within * lit).sum(axis=0)
    return radiance.reshape(PIXELS, fine, PIXELS, fine).mean(axis=(1, 3))


@pytest.fixture(scope="module")
def truth(density):
    """The radiance, its steps' error of second order taken off."""
    coarse, good = (single_scattering(density, fine) for fine in (6, 12))
    assert abs(good.mean() / coarse.mean() - 1) < 1e-2
    return (good + (good - coarse) / 3)[..., None]


@pytest.mark.parametrize(
    "way",
    [
        {},
        {"distance_sampling": "delta", "transmittance": "residual_ratio"},
        {"distance_sampling": "nds"},
        {"distance_sampling": "delta", "tracking": "decomposition"},
    ],
)
def test_light_scattered_once(way, density, truth, tmp_path):
    openvdb = vdb_info.module()
    grid = openvdb.FloatGrid()
    grid.copyFromArray(density)
    grid.name, grid.transform = "density", openvdb.createLinearTransform(1.0)
    openvdb.write(str(tmp_path / "rough.vdb"), grids=[grid])

    middle = (CORNERS - 1) / 2
    view = np.array([[1, 0, 0, middle], [0, 0, -1, -10], [0, 1, 0, middle], [0, 0, 0, 1]], float)
    camera = d.Camera("camera", "orthographic", view, (-middle, middle, -middle, middle))
    sun = d.Light("sun", "sun", facing((0, 0, 1), (0, 0, 0)), (4 * np.pi,) * 3)
    scene = Scene(camera, lights=(sun,))
    scene.add_volume(tmp_path / "rough.vdb", medium(DEPTH, density_grid="density"))
    image = scene.render(size=PIXELS, samples=1536, max_bounces=0, **BOX_FILTER, **way)["Combined"]
    deviation = image - truth  # of one expectation, unlike the pixels
    assert_mean(deviation + truth.mean(), truth.mean(), most=0.003)
    assert_blocks(deviation, 0.0)
