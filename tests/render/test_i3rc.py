# SPDX-License-Identifier: GPL-3.0-or-later
"""Case 1 of the I3RC (Intercomparison of 3D Radiation Codes, Cahalan et al. 2005): a step cloud.

0.25 km thick, endless in y, a period of 0.5 km in x: 16 columns of vertical optical thickness 2, then 16 of
18. Henyey-Greenstein g = 0.85, black below and above, a sun overhead or 60 degrees off, travelling towards
+x. One unit is 1 km. The boundaries are periodic there; here the middle one of 41 periods is looked at. The
thick half is a second medium in the first one's slab.

Reflectance, transmittance and absorptance are fluxes relative to the sun's on the horizontal; transmittance
counts unscattered light. Their domain means come by reciprocity: what a camera in the sun's place sees under
a sky of radiance 1. Each column's flux is the radiance of a white diffuse screen that camera rays alone see,
next to the cloud; radiances count as pi L / flux.

Against the consensus of the participants. The short tests: 5 standard errors (false alarm 6e-7 a number)
beyond what the consensus leaves open, 0.1 % for the mean, COLUMN for a column: their own Monte Carlo noise.
The long ones hold means to 3 standard errors and 0.3 % (0.3 % a number, with seeds that are fixed).
"""

from pathlib import Path

import numpy as np
import pytest
from nephele import description as d
from truth import BOX_FILTER, NO_LIMIT, RAY, Scene, box, diffuse, estimate, facing, half_world, joined

FOLDER = Path(__file__).resolve().parents[3] / "shared/data/i3rc_case1/consensus_results"
PERIOD, THICKNESS, SIDE, COLUMNS, G = 0.5, 0.25, 20, 32, 0.85
OVERHEAD, SLANTED = 1.0, 0.5  # cosines of the sun's zenith angle
# Means over the domain: reflectance, transmittance; albedo 1 and 0.99 by channel.
MEANS = {OVERHEAD: ((0.32760,), (0.67240,)), SLANTED: ((0.58044, 0.47654), (0.41956, 0.32490))}
ALBEDOS = (1.0, 0.99, 1.0)
COLUMN = 0.01


def medium(optical_thickness):
    sigma_t, a = optical_thickness / THICKNESS, np.array(ALBEDOS)
    return d.VolumeClosure(tuple(sigma_t * a), tuple(sigma_t * (1 - a)), phase=d.Phase(a=G))


def to_sun(mu0):
    return np.array([-np.sqrt(1 - mu0 * mu0), 0.0, mu0])


def cloud(view, **scene):
    end, wide = SIDE * PERIOD, 100.0
    slab = box((-end, -wide, 0), (end + PERIOD, wide, THICKNESS), "thin")
    steps = [
        box((k * PERIOD + PERIOD / 2, -wide, 0), ((k + 1) * PERIOD, wide, THICKNESS))
        for k in range(-SIDE, SIDE + 1)
    ]
    return Scene(view, **scene).add(slab, None, (medium(2),)).add(joined(*steps), None, (medium(16),))


def period_seen(position, target, shrink=1.0):
    """Returns a camera of parallel rays that meet one period of the cloud; first pixel column at x = 0 where
    it looks down, at x = PERIOD where it looks up."""
    half = PERIOD / 2 * shrink
    return d.Camera("camera", "orthographic", facing(position, target), (-half, half, -0.001, 0.001))


def domain_mean(mu0, side, size, samples):
    """Returns the Estimate of the flux averaged over the domain, reflected (side 0) or transmitted (1)."""
    target = np.array([PERIOD / 2, 0, THICKNESS])
    view = period_seen(target + 3 * to_sun(mu0), target, mu0)
    scene = cloud(view, world=half_world(1.0 - side, float(side)))
    image = scene.render(size=size, samples=samples, seed=5, **NO_LIMIT, **BOX_FILTER)["Combined"]
    return estimate(image.mean(1, keepdims=True))  # rows are alike, and independent; columns are not alike


def sun(mu0):
    """Returns a sun whose flux on the horizontal is 1."""
    return d.Light("sun", "sun", facing(to_sun(mu0), (0, 0, 0)), (1 / mu0,) * 3)


def column_flux(mu0, side, rows, samples):
    """Returns (rows, COLUMNS, 3) estimates of the flux leaving each column above (side 0) or below (1)."""
    gap = 0.001
    face, outwards = (0.0, -1.0) if side else (THICKNESS, 1.0)
    near, far = face + 2 * gap * outwards, face + 3 * gap * outwards
    screen = box((-1, -1, min(near, far)), (2, 1, max(near, far)), "screen")
    eye = np.array([PERIOD / 2, 0, face + gap * outwards])
    scene = cloud(period_seen(eye, eye + np.array([0, 0, outwards])), lights=(sun(mu0),))
    scene.add(screen, diffuse(1.0), visibility=RAY["camera"])
    image = scene.render(size=(COLUMNS, rows), samples=samples, seed=5, **NO_LIMIT, **BOX_FILTER)["Combined"]
    return np.pi * (image if side else image[:, ::-1])


# Where light leaves to; azimuth 0 is the way the sunlight travels.
EXITS = {"Iu": (0.0, 1.0), "Id": (0.0, -1.0), "I601": (0.75**0.5, 0.5), "I602": (-(0.75**0.5), 0.5)}


def column_radiance(mu0, what, rows, samples):
    """Returns (rows, COLUMNS, 3) estimates of pi L / flux where light leaves each column for EXITS[what]."""
    x, z = EXITS[what]
    target = np.array([PERIOD / 2, 0, THICKNESS if z > 0 else 0.0])
    view = period_seen(target + np.array([x, 0, z]), target, abs(z))
    scene = cloud(view, lights=(sun(mu0),))
    image = scene.render(size=(COLUMNS, rows), samples=samples, seed=5, **NO_LIMIT, **BOX_FILTER)["Combined"]
    return np.pi * (image if z > 0 else image[:, ::-1])


def consensus(experiment, what):
    path = FOLDER / f"I3RC_cons_res_case1_exp{experiment}_{what}.txt"
    if not path.exists():
        pytest.skip("shared/data/i3rc_case1 is not there")
    return np.loadtxt(path)


SUNS = pytest.mark.parametrize("mu0", [OVERHEAD, SLANTED], ids=["overhead", "slanted"])
SIDES = pytest.mark.parametrize("side", [0, 1], ids=["reflectance", "transmittance"])
# (experiment, quantity); experiment 4 is 2 with albedo 0.99, the second channel.
FLUXES = [(1, "R"), (1, "T"), (2, "R"), (4, "R"), (4, "T")]
RADIANCES = [(1, "Iu"), (1, "I602"), (2, "Iu"), (2, "Id"), (2, "I602"), (4, "Iu"), (4, "Id"), (4, "I601")]


@SUNS
@SIDES
def test_domain_mean(mu0, side):
    e, expected = domain_mean(mu0, side, 48, 128), np.array(MEANS[mu0][side])
    n = len(expected)
    assert np.all(e.error[:n] < 0.005 * expected), f"too noisy to tell: {e}"
    assert np.all(np.abs(e.mean[:n] - expected) < 5 * e.error[:n] + 1e-3 * expected), f"{e}, not {expected}"


@pytest.mark.long
@SUNS
@SIDES
def test_domain_mean_within_three_per_mille(mu0, side):
    e, expected = domain_mean(mu0, side, 96, 384), np.array(MEANS[mu0][side])
    n = len(expected)
    assert np.all(e.error[:n] < 0.0011 * expected), f"too noisy to tell: {e}"
    off = np.abs(e.mean[:n] - expected)
    assert np.all(off < np.minimum(3 * e.error[:n], 0.003 * expected)), f"{e}, not {expected}"


def relative_spread(pixels):
    """pixels: (rows, COLUMNS), relative to what is expected. Returns each column's standard deviation, at
    least that of its half of the cloud: few bright pixels hold most of the variance, and a column that misses
    them is both too dark and too sure of it."""
    half = COLUMNS // 2
    pooled = [np.sqrt(pixels[:, part].var(0, ddof=1).mean()) for part in (slice(half), slice(half, None))]
    return np.maximum(pixels.std(0, ddof=1), np.repeat(pooled, half))


def assert_columns(image, experiment, what, most):
    """image (rows, COLUMNS, 3); most: largest standard error of a column, relative."""
    pixels = image[..., 1 if experiment == 4 else 0]
    expected = consensus(experiment, what)
    mean, error = pixels.mean(0), relative_spread(pixels / expected) * expected / np.sqrt(len(pixels))
    assert np.all(error < most * expected), f"too noisy to tell: {error / expected}"
    off = np.abs(mean - expected)
    assert np.all(off < 5 * error + COLUMN * expected), f"columns off by {mean / expected - 1} +- {error}"
    domain, noise = pixels.mean(), pixels.mean(1).std(ddof=1) / np.sqrt(len(pixels))
    assert abs(domain - expected.mean()) < 5 * noise + 0.003 * expected.mean()


def column_flux_of(experiment, what, rows, samples):
    return column_flux(OVERHEAD if experiment == 1 else SLANTED, int(what == "T"), rows, samples)


def column_radiance_of(experiment, what, rows, samples):
    return column_radiance(OVERHEAD if experiment == 1 else SLANTED, what, rows, samples)


@pytest.mark.parametrize(("experiment", "what"), FLUXES)
def test_flux_by_column(experiment, what):
    assert_columns(column_flux_of(experiment, what, 128, 64), experiment, what, 0.2)


@pytest.mark.parametrize(("experiment", "what"), RADIANCES)
def test_radiance_by_column(experiment, what):
    assert_columns(column_radiance_of(experiment, what, 128, 64), experiment, what, 0.2)


@pytest.mark.long
@pytest.mark.parametrize(("experiment", "what"), FLUXES)
def test_flux_by_column_within_percents(experiment, what):
    assert_columns(column_flux_of(experiment, what, 512, 256), experiment, what, 0.05)


@pytest.mark.long
@pytest.mark.parametrize(("experiment", "what"), RADIANCES)
def test_radiance_by_column_within_percents(experiment, what):
    assert_columns(column_radiance_of(experiment, what, 512, 256), experiment, what, 0.05)
