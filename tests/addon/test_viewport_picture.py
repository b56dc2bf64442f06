# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D view shows of each pass."""

import sys
import types

import numpy as np
import pytest
from nephele import maps, passes, viewport_picture
from nephele.viewport_picture import CHOICES, passes_for, picture


def images(shown, denoise=False, value=0.25):
    """Returns the passes that a choice needs, each full of one number."""
    return {
        name: np.full((3, 5, len(passes.BY_NAME[name].channels)), value, np.float32)
        for name in passes_for(shown, denoise)
    }


@pytest.mark.parametrize("shown", CHOICES)
def test_every_choice_is_a_picture(shown):
    pixels, legend = picture(shown, images(shown))
    assert pixels.shape == (3, 5, 4) and pixels.dtype == np.float32 and pixels.flags.c_contiguous
    assert np.isfinite(pixels).all()
    colour = passes.BY_NAME[shown].kind == "COLOR" if shown in passes.BY_NAME else False
    assert bool(legend) != (shown == "Normal" or (colour and shown != "Transmittance"))
    assert viewport_picture.doc(shown)


def test_colours_are_left_as_they_are():
    given = images("Combined")
    given["Combined"][1, 2] = (3.0, 0.5, 0.0, 0.75)
    pixels, _ = picture("Combined", given)
    np.testing.assert_array_equal(pixels, given["Combined"])


def test_what_no_half_float_holds():
    given = images("Combined")
    given["Combined"][0, 0] = (np.inf, np.nan, -np.inf, 1.0)
    pixels, _ = picture("Combined", given)
    np.testing.assert_array_equal(pixels[0, 0], np.float32((6e4, 0, -6e4, 1)))


def test_false_colours_are_scene_linear():
    """The colour of a ramp's end comes back as the 8-bit sRGB that it is stored as."""
    given = images(maps.TARGET, value=1.0)
    pixels, legend = picture(maps.TARGET, given)
    linear = pixels[0, 0, :3]
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.rint(255 * encoded).tolist() == [255, 242, 166]
    assert legend == "VSP Target: 0 (dark) to 1 (bright)"


def test_depths_leave_out_where_nothing_is():
    given = images("Depth", value=4.0)
    given["Depth"][0, 0], given["Depth"][1, 1] = 1e10, 2.0
    _, legend = picture("Depth", given)
    assert "to 4 (bright)" in legend


def test_the_denoiser_sees_colour_and_guides():
    seen = []

    def denoise(color, albedo, normal):
        seen.append((color.shape, albedo[0, 0, 0], normal[0, 0, 0]))
        return color * 2

    given = images("Combined", denoise=True)
    given[viewport_picture.GUIDES[0]][:] = 0.5
    pixels, _ = picture("Combined", given, denoise)
    assert seen == [((3, 5, 3), 0.5, 0.25)]
    np.testing.assert_array_equal(pixels[0, 0], np.float32((0.5, 0.5, 0.5, 0.25)))


def test_only_combined_is_denoised():
    assert passes_for("Combined", True) == ("Combined", *viewport_picture.GUIDES)
    assert passes_for("Volume", True) == ("Volume",)


@pytest.mark.parametrize("there", [True, False])
def test_the_denoiser_may_be_missing(monkeypatch, there):
    module = types.SimpleNamespace(available=lambda: there, denoise=len)
    monkeypatch.setitem(sys.modules, "nephele.denoising", module)
    import nephele

    monkeypatch.setattr(nephele, "denoising", module, raising=False)
    assert viewport_picture.denoiser() is (len if there else None)
    monkeypatch.delattr(nephele, "denoising")
    monkeypatch.setitem(sys.modules, "nephele.denoising", None)  # as if it could not be imported
    assert viewport_picture.denoiser() is None
