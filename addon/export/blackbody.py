# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour of a blackbody: Planck's law times the CIE 1931 observer, in linear Rec. 709, luminance 1.

The same table and sums as native/shading/color_math.cpp: what the exporter folds and what a program computes
while rendering agree to 1e-4. Colours outside Rec. 709 are cut at zero.
"""

import numpy as np

SECOND_RADIATION_CONSTANT = 1.438776877e7  # h c / k, nm K
LOWEST_K, HIGHEST_K, STEP_K = 800.0, 12000.0, 25.0  # colours are tabulated so, held beyond as Blender does
WAVELENGTHS = np.arange(380.0, 761.0, 10.0)  # nm

# Colour matching functions x, y, z of the 2 degree observer at WAVELENGTHS.
OBSERVER = np.array(
    (
        (0.0014, 0.0000, 0.0065), (0.0042, 0.0001, 0.0201), (0.0143, 0.0004, 0.0679),
        (0.0435, 0.0012, 0.2074), (0.1344, 0.0040, 0.6456), (0.2839, 0.0116, 1.3856),
        (0.3483, 0.0230, 1.7471), (0.3362, 0.0380, 1.7721), (0.2908, 0.0600, 1.6692),
        (0.1954, 0.0910, 1.2876), (0.0956, 0.1390, 0.8130), (0.0320, 0.2080, 0.4652),
        (0.0049, 0.3230, 0.2720), (0.0093, 0.5030, 0.1582), (0.0633, 0.7100, 0.0782),
        (0.1655, 0.8620, 0.0422), (0.2904, 0.9540, 0.0203), (0.4334, 0.9950, 0.0087),
        (0.5945, 0.9950, 0.0039), (0.7621, 0.9520, 0.0021), (0.9163, 0.8700, 0.0017),
        (1.0263, 0.7570, 0.0011), (1.0622, 0.6310, 0.0008), (1.0026, 0.5030, 0.0003),
        (0.8544, 0.3810, 0.0002), (0.6424, 0.2650, 0.0000), (0.4479, 0.1750, 0.0000),
        (0.2835, 0.1070, 0.0000), (0.1649, 0.0610, 0.0000), (0.0874, 0.0320, 0.0000),
        (0.0468, 0.0170, 0.0000), (0.0227, 0.0082, 0.0000), (0.0114, 0.0041, 0.0000),
        (0.0058, 0.0021, 0.0000), (0.0029, 0.00105, 0.0000), (0.0014, 0.00052, 0.0000),
        (0.0007, 0.00025, 0.0000), (0.0003, 0.00012, 0.0000), (0.0002, 0.00006, 0.0000),
    )
)  # fmt: skip

REC709_FROM_XYZ = np.array(
    (
        (3.2404542, -1.5371385, -0.4985314),
        (-0.9692660, 1.8760108, 0.0415560),
        (0.0556434, -0.2040259, 1.0572252),
    )
)


def _integrated(kelvin):
    """Returns (n, 3), the colours at temperatures (n,)."""
    exponent = SECOND_RADIATION_CONSTANT / (WAVELENGTHS * kelvin[:, None])
    xyz = ((560.0 / WAVELENGTHS) ** 5 / np.expm1(exponent)) @ OBSERVER
    return np.maximum((xyz / xyz[:, 1:2]) @ REC709_FROM_XYZ.T, 0.0)


TEMPERATURES = np.arange(LOWEST_K, HIGHEST_K + 1, STEP_K)
COLORS = _integrated(TEMPERATURES)


def blackbody_rgb(kelvin):
    """Returns (3,) linear Rec. 709 at `kelvin`, luminance 1."""
    return np.array([np.interp(kelvin, TEMPERATURES, COLORS[:, k]) for k in range(3)])
