# SPDX-License-Identifier: GPL-3.0-or-later
"""Case 1 of the I3RC (Intercomparison of 3D Radiation Codes, Cahalan et al. 2005): a step cloud.

0.25 km thick, endless in y, a period of 0.5 km in x: 16 columns of vertical optical thickness 2, then 16 of
18. Henyey-Greenstein g = 0.85, black below and above, a sun overhead or 60 degrees off, travelling towards
+x. One unit is 1 km. The boundaries are periodic there; here the middle one of 41 periods is looked at. The
thick half is a second medium in the first one's slab.

Reflectance, transmittance and absorptance are fluxes relative to the sun's on the horizontal; transmittance
counts unscattered light. Their domain means come by reciprocity: what a camera in the sun's place sees under
a sky of radiance 1. Each column's flux is the radiance of a white diffuse screen that camera rays alone see,
next to the cloud; nadir reflectivity is pi L / flux.

The consensus of the participants: means within 0.3 % and 3 standard errors (false alarm 0.3 % each; seeds are
fixed). Columns: within 5 standard errors (6e-7 each) and COLUMN, which the participants' own noise sets.
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
NADIR = {OVERHEAD: (0.25640,), SLANTED: (0.40607, 0.32256)}
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
    """Returns (rows, COLUMNS, 3) estimates of the flux that leaves above (side 0) or below (1) each column."""
    gap = 0.001
    face, outwards = (0.0, -1.0) if side else (THICKNESS, 1.0)
    near, far = face + 2 * gap * outwards, face + 3 * gap * outwards
    screen = box((-1, -1, min(near, far)), (2, 1, max(near, far)), "screen")
    eye = np.array([PERIOD / 2, 0, face + gap * outwards])
    scene = cloud(period_seen(eye, eye + (0, 0, outwards)), lights=(sun(mu0),))
    scene.add(screen, diffuse(1.0), visibility=RAY["camera"])
    image = scene.render(size=(COLUMNS, rows), samples=samples, seed=5, **NO_LIMIT, **BOX_FILTER)["Combined"]
    return np.pi * (image if side else image[:, ::-1])


def column_nadir(mu0, rows, samples):
    """Returns (rows, COLUMNS, 3) estimates of the nadir reflectivity."""
    eye = np.array([PERIOD / 2, 0, 1.0])
    scene = cloud(period_seen(eye, eye - (0, 0, 1)), lights=(sun(mu0),))
    image = scene.render(size=(COLUMNS, rows), samples=samples, seed=5, **NO_LIMIT, **BOX_FILTER)["Combined"]
    return np.pi * image


def consensus(experiment, what):
    path = FOLDER / f"I3RC_cons_res_case1_exp{experiment}_{what}.txt"
    if not path.exists():
        pytest.skip("shared/data/i3rc_case1 is not there")
    return np.loadtxt(path)
