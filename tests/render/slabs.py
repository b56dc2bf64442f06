# SPDX-License-Identifier: GPL-3.0-or-later
"""Slabs for the tests of fluxes and radiances, and published numbers of them.

A slab fills 0 < z < b, a box 2000 mean free paths wide, extinction 1/m; nothing reaches its sides. Channels
carry different albedos at the same extinction, so one render answers three cases. b: optical thickness; a:
single-scattering albedo; g: Henyey-Greenstein mean cosine; mu: cosine to the normal; matched index, black
surroundings.
"""

import numpy as np
from nephele import description as d
from truth import (
    BOX_FILTER,
    NO_LIMIT,
    RAY,
    Scene,
    box,
    diffuse,
    estimate,
    facing,
    half_world,
    orthographic,
)  # fmt: skip

ALBEDOS = (0.5, 0.9, 0.99)
UP, DOWN = half_world(1.0), half_world(0.0, 1.0)


def closure(albedos, g=0.0, **more):
    """Returns a medium of extinction 1/m and these albedos by channel."""
    a = np.array(albedos, float)
    return d.VolumeClosure(tuple(a), tuple(1 - a), phase=d.Phase(a=g), **more)


def camera(b, mu, below=False, azimuth=0.6):
    """Returns a camera that sees the slab 0 < z < b from above, or from below, along a line of cosine mu."""
    s = np.sqrt(1 - mu * mu)
    away = np.array([s * np.cos(azimuth), s * np.sin(azimuth), -mu if below else mu])
    target = np.array([0, 0, 0.0 if below else b])
    return orthographic(target + 5 * away, target)


def slab(b, medium, view, world=None, lights=()):
    wide = box((-1000, -1000, 0), (1000, 1000, b), "slab")
    return Scene(view, world, lights=lights).add(wide, None, (medium,))


def beam(mu0, irradiance):
    """Returns a sun without extent; irradiance: on a plane normal to the beam. Its own limit of bounces is no
    lower than the paths'."""
    to_sun = (np.sqrt(1 - mu0 * mu0), 0.0, mu0)
    bounces = NO_LIMIT["max_bounces"]
    return d.Light("beam", "sun", facing(to_sun, (0, 0, 0)), (irradiance,) * 3, max_bounces=bounces)


def under_screen(b, medium, below=False, **scene):
    """Returns a Scene whose pixels are estimates of the flux, over pi, that leaves the slab above, or below:
    the radiance of a white diffuse screen beside the slab that camera rays alone see."""
    face, outwards = (0.0, -1) if below else (b, 1)
    near, far = (face + k * outwards for k in (2.0, 3.0))
    view = orthographic((0, 0, face + outwards), (0, 0, near))
    screen = box((-10, -10, min(near, far)), (10, 10, max(near, far)), "screen")
    return slab(b, medium, view, **scene).add(screen, diffuse(1.0), visibility=RAY["camera"])


def radiance(scene, samples=64, seed=7, **settings):
    return scene.render(size=48, samples=samples, seed=seed, **NO_LIMIT, **BOX_FILTER, **settings)["Combined"]


# Adding-doubling: iadpython 0.5.3 (S. Prahl), 16 quadrature points, converged to 1e-5, by g and b; rows UR1,
# UT1, URU, UTU, columns by TABLE_ALBEDOS. UR1, UT1: reflectance and transmittance (unscattered light
# included) of a beam along the normal; URU, UTU: of diffuse light. By reciprocity UR1 and UT1 are the
# radiance at mu = 1 above the slab and below it, where radiance 1 falls on its top from everywhere. The rows
# a = 1, b = 1 agree with van de Hulst 1980, volume 1 table 12 (g = 0: R 0.34133) and volume 2 table 35 (g =
# 0.5: T 0.82389); a = 0.9, b = 2, g = 0.75 with Wang, Jacques, Zheng 1995 (diffuse R 0.09739).
TABLE_ALBEDOS = (0.5, 0.9, 0.99, 1.0)
ADDING_DOUBLING = {
    (0, 0.5): (
        (0.07295, 0.16904, 0.19892, 0.20251),
        (0.67423, 0.76538, 0.79405, 0.79749),
        (0.10768, 0.24749, 0.29066, 0.29583),
        (0.53499, 0.65992, 0.69942, 0.70417),
    ),
    (0, 1): (
        (0.09912, 0.26741, 0.33292, 0.34133),
        (0.44606, 0.59163, 0.65098, 0.65867),
        (0.13417, 0.35271, 0.43596, 0.44659),
        (0.30671, 0.47475, 0.54435, 0.55341),
    ),
    (0, 2): (
        (0.11283, 0.36165, 0.49749, 0.51751),
        (0.18932, 0.35650, 0.46570, 0.48249),
        (0.14509, 0.43715, 0.58800, 0.60994),
        (0.10705, 0.26558, 0.37335, 0.39006),
    ),
    (0, 8): (
        (0.11523, 0.41484, 0.72875, 0.82180),
        (0.00082, 0.01602, 0.12207, 0.17820),
        (0.14654, 0.47795, 0.77577, 0.85847),
        (0.00028, 0.01103, 0.09568, 0.14153),
    ),
    (0.5, 0.5): (
        (0.02676, 0.07204, 0.08785, 0.08980),
        (0.73004, 0.86720, 0.90569, 0.91020),
        (0.05954, 0.15241, 0.18375, 0.18758),
        (0.58286, 0.75498, 0.80633, 0.81242),
    ),
    (0.5, 1): (
        (0.03824, 0.12979, 0.17073, 0.17611),
        (0.52007, 0.73909, 0.81452, 0.82389),
        (0.07428, 0.22795, 0.29288, 0.30133),
        (0.36119, 0.59855, 0.68742, 0.69867),
    ),
    (0.5, 2): (
        (0.04567, 0.20451, 0.30527, 0.32030),
        (0.25363, 0.52327, 0.66030, 0.67970),
        (0.08119, 0.30254, 0.43026, 0.44896),
        (0.14660, 0.39217, 0.53093, 0.55104),
    ),
    (0.5, 8): (
        (0.04754, 0.27700, 0.60013, 0.68897),
        (0.00230, 0.05439, 0.24383, 0.31103),
        (0.08244, 0.35961, 0.67313, 0.75417),
        (0.00091, 0.03772, 0.19022, 0.24583),
    ),
    (0.75, 0.5): (
        (0.01044, 0.02940, 0.03646, 0.03734),
        (0.75702, 0.91537, 0.95775, 0.96266),
        (0.03205, 0.09058, 0.11245, 0.11519),
        (0.61194, 0.81707, 0.87763, 0.88481),
    ),
    (0.75, 1): (
        (0.01511, 0.05595, 0.07603, 0.07874),
        (0.56461, 0.82792, 0.91118, 0.92126),
        (0.03955, 0.13836, 0.18561, 0.19197),
        (0.39676, 0.68855, 0.79469, 0.80803),
    ),
    (0.75, 2): (
        (0.01846, 0.09740, 0.15440, 0.16318),
        (0.30533, 0.66096, 0.81604, 0.83682),
        (0.04323, 0.19109, 0.28918, 0.30404),
        (0.17668, 0.50182, 0.67199, 0.69596),
    ),
    (0.75, 8): (
        (0.01953, 0.16298, 0.43305, 0.50642),
        (0.00539, 0.13061, 0.41633, 0.49358),
        (0.04401, 0.24727, 0.53715, 0.61089),
        (0.00203, 0.08652, 0.32202, 0.38911),
    ),
}
HALF_DIGIT = 1.5e-5  # the tables' last digit, and their convergence

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

# DISORT's problem 1, isotropic light of radiance 1 from above, a = 0.99; below, unscattered light counts.
ISOTROPIC = {0.03125: ((0.133177, 0.0299879, 0.0152233), (0.863946, 0.969363, 0.984447)),
             32: ((0.877510, 0.815136, 0.752715), (0.000779280, 0.00126492, 0.00186840))}  # fmt: skip

# Chandrasekhar's H function for isotropic scattering (400-point Gauss quadrature; H(1) at a = 1 is 2.9078):
# BRF(mu, mu0) = a H(mu) H(mu0) / (4 (mu + mu0)) = pi L / E; R(mu0) = 1 - sqrt(1 - a) H(mu0).
H = {
    0.1: (1.072369, 1.172143, 1.224875),
    0.5: (1.187735, 1.556034, 1.848601),
    1.0: (1.251260, 1.850099, 2.472793),
}


def precisely(scene, expected, rounding=0.0, most_batches=400, **render):
    """Asserts that the mean of a scene's pixels, all estimates of one number a channel, is `expected` within
    0.3 % and the reference's `rounding` (absolute). Renders with seed after seed until the standard error is
    a third of that: false alarm 0.3 % a number at worst, with seeds that are fixed."""
    expected = np.broadcast_to(np.asarray(expected, float), 3)
    allowed = 0.003 * expected + rounding
    means, squares = np.zeros((2, 3))
    for batch in range(1, most_batches + 1):
        e = estimate(radiance(scene, seed=1000 + batch, **render))
        means, squares = means + e.mean, squares + e.error**2
        mean, error = means / batch, np.sqrt(squares) / batch
        if np.all(error <= allowed / 3):
            break
    assert np.all(error <= allowed / 3), f"too noisy to tell: {mean} +- {error}"
    off = np.abs(mean - expected)
    assert np.all(off <= allowed), f"got {mean} +- {error}, expected {expected}: off {off / expected}"
