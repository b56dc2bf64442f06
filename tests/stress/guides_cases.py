# SPDX-License-Identifier: GPL-3.0-or-later
"""Guiding at its ends: volume scattering probabilities next to 0 and 1, wanted or learned, and what it may
use. The same scene without guiding is the twin."""

from itertools import product

import numpy as np
from judge import ANALOG, Case, Twin
from nephele import description as d
from stages import block, smoke, stage, vdb
from truth import box, constant_program, diffuse, emission, half_world, placed

DELTA = Twin(settings=ANALOG)
GUIDED = ("default", "exact", "field", "nds", "nds_plus")
UP = half_world(1.0)


def ramp(_):
    return np.broadcast_to(np.linspace(0, 2, 16), (16, 16, 16)).copy()


def fog(sigma_s=0.4, sigma_a=0.1, sky=UP):
    """Fog whose top is lit, over a floor that shines."""
    return block(sigma_s, sigma_a, world=sky).add(box((-2, -2, -3), (2, 2, -2)), emission(0.5))


def cloud(sky=UP):
    return smoke(vdb(ramp), 16, 0.06, 0.01, world=sky, beam=(0.3, 0.2), g=0.3)


def before(surface, sigma_s, sigma_a, sky=UP):
    """Fog before a surface."""
    return block(sigma_s, sigma_a, world=sky).add(box((-2, -2, -3), (2, 2, -2)), surface)


BLACK = diffuse(0.0)
CASES = [
    # Wanted probabilities of nearly 0 and nearly 1, pixel by pixel, whatever would be wise.
    *(
        Case(
            f"target {target}, control {control}, defensive {k:g}, {name}",
            scene,
            DELTA,
            ("default",),
            samples=1024,
            size=8,
            most=0.15,
            cpu=30,
            settings={"vsp_target": target, "vsp_control": control, "vsp_defensive": k},
            quick=target == "highest" and k == 0 and name == "fog" and control == "exact",
        )
        for target, (control, k), (name, scene) in product(
            ("lowest", "highest", "random"),
            (("conditional", 0.75), ("exact", 0.75), ("exact", 0.5)),
            (("fog", fog), ("cloud", cloud)),
        )
    ),
    # Full and no defence. At defensive 1 the chance of the unwanted branch is a thousandth.
    *(
        Case(f"defensive {k:g}, {name}", scene, DELTA, ("exact",), samples=512, settings={"vsp_defensive": k})
        for k, (name, scene) in product((0.0, 1.0), (("fog", fog), ("cloud", cloud)))
    ),
    # Learned ends: the volume black, the surface black, both, and a thin volume before black.
    Case(
        "black volume",
        lambda: before(emission(0.5), 0.0, 0.5),
        0.5 * np.exp(-1),
        GUIDED,
        samples=256,
        quick=True,
    ),
    Case("black surface", lambda: before(BLACK, 0.4, 0.1), DELTA, GUIDED, samples=512, quick=True),
    Case(
        "black volume in the dark that scatters",
        lambda: before(emission(0.5), 1e-6, 0.5, None),
        0.5 * np.exp(-1),
        GUIDED,
        samples=256,
    ),
    Case("black volume and surface", lambda: before(BLACK, 0.4, 0.1, None), 0.0, GUIDED),
    *(
        Case(
            f"thin volume of depth {tau:g} before black",
            lambda tau=tau: before(BLACK, tau / 2, 0.0),
            tau / 2,
            ("default", "exact", "field"),
            samples=512,
            rounding=2 * tau + 1e-5,
            most=0.1,
        )
        for tau in (1e-3, 1e-2)
    ),
    Case(
        "deep volume before light",
        lambda: before(emission(1e3), 10.0, 10.0),
        DELTA,
        GUIDED,
        samples=256,
        most=0.1,
    ),
    # All criteria and uses on a scene with everything.
    *(
        Case(
            f"stage, {name}={value}",
            stage,
            DELTA,
            ("default",),
            samples=128,
            most=0.1,
            cpu=20,
            settings={name: value},
        )
        for name, value in (
            ("vsp_criterion", "contribution"),
            ("vsp_cost", True),
            ("vsp_product", False),
            ("vsp_gather", False),
            ("guiding_memory", 1),
            ("guide_directions", False),
            ("vsp_secondary", False),
            ("guided_roulette", False),
            ("roulette_depth", 0),
            ("roulette_depth", 4096),
            ("sampler", "independent"),
            ("majorant", "global"),
        )
    ),
    Case(
        "stage of 1 MiB, always trained",
        stage,
        DELTA,
        ("field",),
        samples=256,
        most=0.1,
        cpu=30,
        settings={"guiding_memory": 1},
    ),
    # A field has nothing to learn, or only what is far too bright.
    Case("field in the dark", lambda: block(0.5, 0.1, world=None), 0.0, ("field",)),
    Case("field without bounces", fog, DELTA, ("field",), settings={"max_bounces": 0}, samples=256),
    Case(
        "field of mirrors",
        lambda: before(constant_program(("glossy", 1.0, 0.0, None)), 0.4, 0.1),
        DELTA,
        ("default", "field"),
        samples=512,
    ),
    *(
        Case(
            f"one spark of {w:g} W in fog",
            lambda w=w: block(
                0.4,
                0.1,
                world=None,
                lights=(d.Light("spark", "point", placed(0, 0, 0.5), (w,) * 3, radius=1e-3),),
            ),
            Twin(
                lambda: block(
                    0.4,
                    0.1,
                    world=None,
                    lights=(d.Light("spark", "point", placed(0, 0, 0.5), (1.0,) * 3, radius=1e-3),),
                ),
                scale=w,
            ),
            ("default", "field", "exact"),
            samples=256,
            most=0.1,
        )
        for w in (1e-20, 1e20, 1e-35, 1e30)
    ),
]
