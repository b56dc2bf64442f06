# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour of a blackbody: Planck's law times the CIE 1931 observer, in linear Rec. 709, luminance 1.

Colour matching by the sums of Gaussians of Wyman, Sloan and Shirley, "Simple Analytic Approximations to the
CIE XYZ Color Matching Functions", JCGT 2(2), 2013 (multi-lobe fit). Colours outside Rec. 709 are cut at zero.
"""

import numpy as np

SECOND_RADIATION_CONSTANT = 1.438776877e7  # h c / k, nm K
WAVELENGTHS = np.arange(360.0, 831.0, 5.0)  # nm

# rows: weight, mean nm, width below and above the mean nm
LOBES = {
    "x": ((1.056, 599.8, 37.9, 31.0), (0.362, 442.0, 16.0, 26.7), (-0.065, 501.1, 20.4, 26.2)),
    "y": ((0.821, 568.8, 46.9, 40.5), (0.286, 530.9, 16.3, 31.1)),
    "z": ((1.217, 437.0, 11.8, 36.0), (0.681, 459.0, 26.0, 13.8)),
}

REC709_FROM_XYZ = np.array(
    (
        (3.2404542, -1.5371385, -0.4985314),
        (-0.9692660, 1.8760108, 0.0415560),
        (0.0556434, -0.2040259, 1.0572252),
    )
)


def blackbody_rgb(kelvin):
    """Returns (3,) linear Rec. 709 at `kelvin` (held to [800, 12000] as Blender does), luminance 1."""
    kelvin = min(max(float(kelvin), 800.0), 12000.0)
    exponent = SECOND_RADIATION_CONSTANT / (WAVELENGTHS * kelvin)
    radiance = (WAVELENGTHS / 560.0) ** -5 / np.expm1(exponent)
    xyz = np.array([radiance @ _response(lobes) for lobes in LOBES.values()])
    return np.maximum(REC709_FROM_XYZ @ (xyz / xyz[1]), 0.0)


def _response(lobes):
    """Returns a colour matching function at WAVELENGTHS."""
    total = np.zeros_like(WAVELENGTHS)
    for weight, mean, below, above in lobes:
        width = np.where(mean > WAVELENGTHS, below, above)
        total += weight * np.exp(-0.5 * ((WAVELENGTHS - mean) / width) ** 2)
    return total
