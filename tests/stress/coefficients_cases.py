# SPDX-License-Identifier: GPL-3.0-or-later
"""Constant media: extinction, depth, albedo, phase and colour from one end of the numbers to the other."""

import numpy as np
from judge import GUIDED, TRACKED, Case, Twin
from nephele import description as d
from stages import balanced, block
from truth import Scene, half_world, medium, orthographic, sphere

# Where next to nothing is met, ways that only count what is met would need more samples than there are.
RARE = ("default", "exact", "field")


def ways(depth):
    return TRACKED if depth == 0 or depth > 5e-3 else RARE


SIGMA = (0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e9)
DEPTH = (1e-9, 1e-6, 1e-3, 1.0, 1e2, 1e4, 1e7)
BLACK, PLAIN = None, Twin(settings={"integrator": "plain"})
UP = half_world(1.0)


def shining(tau, albedo=0.0):
    """A cube of optical depth tau in the dark that shines at its absorption."""
    return block(
        0.5 * tau * albedo, 0.5 * tau * (1 - albedo), world=BLACK, emission=(0.5 * tau * (1 - albedo),) * 3
    )


def endless(sigma_s, sigma_a):
    """A world medium that shines at its absorption, and nothing else."""
    closure = medium(sigma_s, sigma_a, emission=tuple(np.broadcast_to(np.asarray(sigma_a, float), 3)))
    return Scene(orthographic((0, 0, 5), (0, 0, 0)), world_volume=(closure,))


def fog_ball(g, sigma, radius=0.8):
    """A ball lamp in a block of fog, which the plain integrator finds too."""
    lamp = d.Light("ball", "point", np.eye(4), (50.0, 40.0, 30.0), radius=radius)
    return block(sigma, 0.1 * sigma, lights=(lamp,), g=g, world=BLACK)


def overlapping(thin, dense):
    scene = block(0, 0.5 * thin)
    return scene.add(sphere(0.9, 3), None, (medium(0.5 * dense, 0.5 * dense, emission=(0.5 * dense,) * 3),))


CASES = [
    # What gets through 2 m that only absorb.
    *(
        Case(
            f"absorption {s:g}/m",
            lambda s=s: block(0, s),
            np.exp(-2 * s),
            ways(2 * s),
            rounding=2e-6,
            most=0.05,
            quick=s in (1e-12, 1e9),
        )
        for s in SIGMA
    ),
    # What a depth tau shines: 1 - exp(-tau), to all its digits.
    *(
        Case(
            f"emission of depth {tau:g}",
            lambda tau=tau: shining(tau),
            -np.expm1(-tau),
            ways(tau),
            rounding=2e-6,
            most=0.05,
            quick=tau == 1e-9,
        )
        for tau in DEPTH
    ),
    # Single scattering of light from above, seen from above: the surface behind is black, so only the volume
    # counts; first order in tau.
    *(
        Case(
            f"scattering of depth {tau:g}",
            lambda tau=tau: block(0.5 * tau, 0, world=UP),
            tau / 2,
            GUIDED if tau > 1e-8 else ("exact",),
            samples=256,
            rounding=3 * tau + 1e-5,
            quick=tau == 1e-9,
        )
        for tau in (1e-9, 1e-6, 1e-4)
    ),
    # White furnaces and furnaces in balance with their emission.
    *(
        Case(
            f"furnace of depth {tau:g}, g {g:g}",
            lambda tau=tau, g=g: block(0.5 * tau, 0, g=g),
            1.0,
            TRACKED,
            rounding=1e-5,
            quick=tau == 1 and g == 0.9999,
        )
        for tau in (0.0, 1e-9, 1e-3, 1.0, 10.0)
        for g in (-0.9999, 0.0, 0.9999)
    ),
    *(
        Case(
            f"balance of {s:g}/m, albedo {a:g}",
            lambda s=s, a=a: balanced(a * s, (1 - a) * s),
            1.0,
            TRACKED,
            quick=s == 1e9 and a == 0.9,
        )
        for s in SIGMA[1:]
        for a in (0.0, 0.5, 0.9)
    ),
    *(
        Case(
            f"balance of depth 1, albedo 1-1e-7, g {g:g}",
            lambda g=g: balanced(0.5, 0.5e-7, g=g),
            1.0,
            TRACKED,
        )
        for g in (-0.9999, 0.0, 0.9999)
    ),
    *(
        Case(
            f"endless world of {s:g}/m, albedo {a:g}",
            lambda s=s, a=a: endless(a * s, (1 - a) * s),
            1.0,
            TRACKED,
        )
        for s in (1e-9, 1.0, 1e9)
        for a in (0.0, 0.5)
    ),
    # Colours 1e6 apart.
    Case(
        "absorption of 3 colours",
        lambda: block(0, (1e-6, 0.5, 1e6)),
        np.exp([-2e-6, -1, -2e6]),
        TRACKED,
        quick=True,
    ),
    Case("furnace of 3 colours", lambda: block((1e-6, 1e-3, 1), 0), 1.0, TRACKED),
    Case(
        "balance of 3 colours",
        lambda: balanced((9e-4, 0.9, 900), (1e-4, 0.1, 100)),
        1.0,
        TRACKED,
        samples=256,
    ),
    Case("balance of 3 albedos", lambda: balanced((1.0, 1e-6, 0), (1e-6, 1, 1)), 1.0, TRACKED, samples=256),
    Case(
        "emission of 3 colours",
        lambda: block(0, (1e-6, 1, 1e6), world=BLACK, emission=(1e-6, 1, 1e6)),
        -np.expm1([-2e-6, -2, -2e6]),
        TRACKED,
    ),
    # Against the plain integrator.
    *(
        Case(
            f"ball lamp in fog of {sigma:g}/m, g {g:g}",
            lambda g=g, sigma=sigma: fog_ball(g, sigma),
            PLAIN,
            TRACKED if sigma > 0.1 else RARE,
            samples=256,
            most=0.12,
        )
        for g in (-0.9999, 0.9999, 0.0)
        for sigma in (1e-2, 0.5, 5.0)
    ),
    # One in the other.
    *(
        Case(
            f"thin {thin:g} around dense {dense:g}",
            lambda thin=thin, dense=dense: overlapping(thin, dense),
            1.0 if thin < 1e-6 else None,
            TRACKED,
        )
        for thin in (1e-9, 1e-3)
        for dense in (1e3, 1e9)
    ),
]
