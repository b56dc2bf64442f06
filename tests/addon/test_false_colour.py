# SPDX-License-Identifier: GPL-3.0-or-later
"""False colour: ramps that are ordered to the eye, and scales from numbers to them."""

import numpy as np
import pytest
from nephele.false_colour import DIVERGING, NOT_FINITE, SEQUENTIAL, Scale, encoded


def lightness(colours):
    """Returns CIE L* of 8-bit sRGB colours."""
    linear = np.array(colours) / 255
    linear = np.where(linear <= 0.04045, linear / 12.92, ((linear + 0.055) / 1.055) ** 2.4)
    y = linear @ [0.2126, 0.7152, 0.0722]
    return np.where(y > 216 / 24389, 116 * np.cbrt(y) - 16, y * 24389 / 27)


def test_the_sequential_ramp_grows_evenly_in_lightness():
    values = lightness(Scale(0, 1).colours(np.linspace(0, 1, 1000)))
    steps = np.diff(lightness(SEQUENTIAL))
    assert values[0] < 5 and values[-1] > 93
    assert steps.min() > 0.5 * steps.mean() and steps.max() < 1.5 * steps.mean()
    assert (np.diff(values) > -0.2).all()  # 8 bits round


def test_the_diverging_ramp_is_as_dark_at_both_ends_and_grey_in_the_middle():
    values = lightness(DIVERGING)
    assert np.abs(values - values[::-1]).max() < 2
    assert (np.diff(values[:7]) > 5).all()
    assert len(set(DIVERGING[6])) == 1
    assert DIVERGING[0][2] > DIVERGING[0][0] and DIVERGING[-1][0] > DIVERGING[-1][2]


@pytest.mark.parametrize(
    ("scale", "values", "positions"),
    [
        (Scale(2, 4), [2, 3, 4, 0, 9], [0, 0.5, 1, 0, 1]),
        (Scale(0.01, 100, logarithmic=True), [0.01, 1, 10, 0, -1, 1e9], [0, 0.5, 0.75, 0, 0, 1]),
        (Scale(-3, 3, diverging=True), [-3, 0, 1.5], [0, 0.5, 0.75]),
    ],
)
def test_scales(scale, values, positions):
    np.testing.assert_allclose(scale.position(np.array(values, np.float32)), positions, atol=1e-6)
    for position in (0, 0.3, 1):
        assert scale.position(np.array(scale.value(position))) == pytest.approx(position)


def test_ends_and_what_is_not_finite_have_their_own_colours():
    colours = Scale(0, 1).colours(np.array([[0, 1], [np.nan, np.inf]]))
    assert colours.dtype == np.uint8 and colours.shape == (2, 2, 3)
    assert tuple(colours[0, 0]) == SEQUENTIAL[0] and tuple(colours[0, 1]) == SEQUENTIAL[-1]
    assert (colours[1] == NOT_FINITE).all()


def test_pictures_are_encoded_as_srgb():
    colours = encoded(np.array([[0, 0.5, 1], [2, -1, 0.001], [np.inf, 0, 0]]))
    assert colours.tolist() == [[0, 188, 255], [255, 0, 3], [255, 0, 255]]
