# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of one pixel and of very many in a row, paths of one bounce and of thousands."""

import numpy as np
from judge import ANALOG, Case, Twin
from nephele import passes
from stages import balanced, block, stage
from truth import half_world

PLAIN = Twin(settings={"integrator": "plain"})
UP = half_world(1.0)
EVERY_PASS = tuple(row.name for row in passes.PASSES)


def bounces(n):
    return {"max_bounces": n, "surface_bounces": n, "volume_bounces": n}


def deep_white(sigma_s, depth):
    """A white cube of so many mean free paths to its sides, seen from its middle: a path scatters about
    0.67 depth^2 times on its way out."""
    scene = block(sigma_s, 0.0, depth)
    camera = scene.camera.world_from_camera.copy()
    camera[:3, 3] = 0
    object.__setattr__(scene.camera, "world_from_camera", camera)
    return scene


CASES = [
    Case("1 x 1", stage, None, ("default", "exact", "field"), size=1, samples=256, quick=True),
    Case("1 x 1, every pass", stage, None, ("default", "field"), size=1, passes=EVERY_PASS),
    Case("1 x 1, one sample", stage, None, ("default", "field"), size=1, samples=1, passes=EVERY_PASS),
    Case(
        "16,384 x 4",
        lambda: block(0.5, 0.1, world=UP),
        Twin(settings=ANALOG),
        ("default", "field"),
        size=(16384, 4),
        samples=8,
        cpu=60,
    ),
    Case(
        "16,384 x 4 of a stage, every pass",
        stage,
        None,
        ("default", "field"),
        size=(16384, 4),
        samples=4,
        cpu=60,
        passes=EVERY_PASS,
    ),
    Case(
        "4 x 16,384",
        lambda: block(0.5, 0.1, world=UP),
        Twin(settings=ANALOG),
        ("default", "field"),
        size=(4, 16384),
        samples=8,
        cpu=60,
    ),
    Case("every pass of 1e20 W", lambda: stage(power=1e20), None, ("default", "field"), passes=EVERY_PASS),
    Case(
        "every pass of a small dense stage",
        lambda: stage(size=1e-4, thickness=1e4),
        None,
        ("default", "field"),
        samples=16,
        passes=EVERY_PASS,
        cpu=30,
    ),
    # The number of scattering events is what it is said to be.
    *(
        Case(
            f"{n} bounces",
            lambda: block(1.0, 0.1, world=UP),
            PLAIN,
            ("default", "delta", "exact", "field"),
            samples=256,
            settings=bounces(n),
            most=0.05,
        )
        for n in (0, 1, 2, 4096)
    ),
    Case(
        "no bounces at all", lambda: block(0.0, 0.5), np.exp(-1.0), ("default", "field"), settings=bounces(0)
    ),
    # Energy is kept: 400 events a path, 6e6 in all.
    Case(
        "white furnace of 6e6 events",
        lambda: deep_white((1.0, 1.0, 1.0), 25.0),
        1.0,
        ("default", "delta", "exact", "field"),
        size=8,
        samples=256,
        rounding=2e-5,
        most=0.01,
        cpu=60,
    ),
    Case(
        "white furnace of three colours",
        lambda: deep_white((1.0, 1.2, 1.5), 10.0),
        1.0,
        ("default", "delta", "exact", "field"),
        size=8,
        samples=64,
        most=0.2,
        cpu=60,
    ),
    Case(
        "balance of albedo 0.995",
        lambda: balanced(1.0, 0.005, half=50.0),
        1.0,
        ("default", "delta", "field"),
        samples=16,
        most=0.05,
        cpu=60,
    ),
]
