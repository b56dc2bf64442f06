# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes of any size: geometry, media and lights scaled together look the same."""

import numpy as np
from judge import TRACKED, Case, Twin
from stages import block, stage
from truth import half_world

UP = half_world(1.0)
SIZES = (1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6)

CASES = [
    *(
        Case(
            f"stage {size:g} times as large",
            lambda size=size: stage(size=size),
            Twin(stage),
            TRACKED if size in (1e-4, 1e6) else ("default",),
            samples=128,
            most=0.05,
            rounding=1e-3,
            cpu=20,
            quick=size == 1e-4,
        )
        for size in SIZES
    ),
    *(
        Case(
            f"cube of {2 * half:g} m",
            lambda half=half: block(0.0, 0.5 / half, half),
            np.exp(-1.0),
            TRACKED,
            rounding=1e-5,
        )
        for half in (1e-9, *SIZES, 1e9, 1e12)
    ),
    *(
        Case(
            f"light in a cube of {2 * half:g} m",
            lambda half=half: block(0.8 / half, 0.2 / half, half, UP),
            Twin(lambda: block(0.8, 0.2, 1.0, UP)),
            TRACKED,
            samples=256,
        )
        for half in (1e-9, 1e-4, 1e6, 1e12)
    ),
]
