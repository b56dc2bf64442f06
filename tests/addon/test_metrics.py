# SPDX-License-Identifier: GPL-3.0-or-later
"""Image metrics against values worked out by hand."""

import numpy as np
import pytest
from nephele import metrics


def image(value, height=20, width=50):
    return np.full((height, width, 3), value, np.float32)


def test_values_of_constant_images():
    result = metrics.compare(image(3.0), image(2.0))
    assert result["nonfinite_pixels"] == 0
    assert result["relmse"] == pytest.approx(1 / 4.01)
    assert result["relmse_trimmed"] == pytest.approx(1 / 4.01)
    assert result["smape"] == pytest.approx(2 / 5.01)
    assert result["mape"] == pytest.approx(1 / 2.01)
    assert result["bias"] == pytest.approx(0.5)
    assert 0 < result["flip"] < 1


def test_equal_images_do_not_differ():
    noise = np.random.default_rng(1).random((8, 9, 3), np.float32)
    assert metrics.compare(noise, noise) == {
        "nonfinite_pixels": 0,
        "relmse": 0,
        "relmse_trimmed": 0,
        "smape": 0,
        "mape": 0,
        "flip": 0,
        "bias": 0,
    }


def test_trimming_drops_one_firefly_in_a_thousand_pixels():
    a = image(1.0)
    a[3, 4, 1] = 1000
    result = metrics.compare(a, image(1.0), ["relmse"])
    assert result["relmse"] == pytest.approx(999**2 / 1.01 / 3000)
    assert result["relmse_trimmed"] == 0


def test_nonfinite_pixels_are_counted_and_left_out():
    a = image(3.0)
    a[0, 0, 0], a[1, 1, 2] = np.nan, np.inf
    result = metrics.compare(a, image(2.0))
    assert result["nonfinite_pixels"] == 2
    assert result["mape"] == pytest.approx(1 / 2.01)
    assert np.isfinite(result["flip"])
    nothing = metrics.compare(image(np.nan), image(2.0))
    assert nothing["nonfinite_pixels"] == 1000
    assert all(
        nothing[name] is None for name in ("relmse", "relmse_trimmed", "smape", "mape", "flip", "bias")
    )


def test_black_reference():
    result = metrics.compare(image(1.0), image(0.0))
    assert result["relmse"] == pytest.approx(100)
    assert result["bias"] is None
    assert 0 < result["flip"] <= 1
    assert metrics.compare(image(0.0), image(0.0))["flip"] == 0


def test_shapes_must_agree():
    with pytest.raises(ValueError, match="shape"):
        metrics.compare(image(1.0), image(1.0, width=51))


def test_bias_z_is_calibrated_and_sees_a_bias():
    """400 images of unbiased noise: the mean of z^2 is 1 within 0.3. Its standard deviation is sqrt(2 / 400)
    = 0.07, so the false-alarm rate is below 1e-4. A bias of 5 standard errors must show as z of about 5."""
    generator = np.random.default_rng(3)
    reference, sigma = image(1.0), 0.2
    variance = np.full(reference.shape[:2], sigma**2, np.float32)
    values = []
    for _ in range(400):
        noise = generator.normal(0, sigma, (*reference.shape[:2], 1)).astype(np.float32)
        values.append(metrics.compare(reference + noise, reference, ["bias"], variance=variance)["bias_z"])
    assert np.mean(np.square(values)) == pytest.approx(1, abs=0.3)
    shift = 5 * sigma / np.sqrt(variance.size)
    biased = metrics.compare(reference + np.float32(shift), reference, ["bias"], variance=variance)
    assert biased["bias_z"] == pytest.approx(5, abs=0.01)


def test_bias_z_without_variance_is_undefined():
    assert metrics.compare(image(1.0), image(1.0), ["bias"], variance=np.zeros((20, 50)))["bias_z"] is None
    assert "bias_z" not in metrics.compare(image(1.0), image(1.0), ["bias"])
