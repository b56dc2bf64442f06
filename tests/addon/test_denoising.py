# SPDX-License-Identifier: GPL-3.0-or-later
"""The denoiser: it is Blender's own, takes noise away and keeps what features show, and refuses what does not
fit."""

import numpy as np
import pytest
from nephele import denoising


@pytest.fixture
def noisy():
    """Returns (truth, noisy, albedo): stripes of 8 pixels, light of an exponential distribution."""
    rng = np.random.default_rng(1)
    albedo = np.zeros((96, 128, 3), np.float32)
    albedo[:] = np.where(np.arange(128) // 8 % 2 == 0, 0.2, 0.8)[None, :, None]
    truth = 5 * albedo
    noise = rng.exponential(1.0, (96, 128, 3)).astype(np.float32)
    return truth, truth * noise, albedo


def error(image, truth):
    return float(np.sqrt(np.mean((image - truth) ** 2)))


def test_blender_brings_a_denoiser():
    assert denoising.available()


def test_noise_goes_and_features_stay(noisy):
    truth, picture, albedo = noisy
    before = picture.copy()
    plain = denoising.denoise(picture)
    assert plain.shape == picture.shape and plain.dtype == np.float32
    guided = denoising.denoise(picture, albedo, np.zeros_like(albedo))
    assert np.array_equal(picture, before)
    assert error(plain, truth) < 0.5 * error(picture, truth)
    # The stripes are known to the albedo alone: with it they are as sharp as they were.
    assert error(guided, truth) < 0.5 * error(plain, truth)
    assert error(guided, truth) < 0.1 * error(picture, truth)


def test_what_is_not_finite_stays_out(noisy):
    _, picture, _ = noisy
    picture[40, 60] = np.nan
    picture[41, 60] = np.inf
    assert np.isfinite(denoising.denoise(picture)).all()


def test_what_does_not_fit_is_refused(noisy):
    _, picture, albedo = noisy
    with pytest.raises(ValueError, match="albedos"):
        denoising.denoise(picture, None, albedo)
    with pytest.raises(ValueError, match="albedo is"):
        denoising.denoise(picture, albedo[1:])
    with pytest.raises(ValueError, match="color is"):
        denoising.denoise(picture[..., :2])


def test_without_the_library_the_message_says_what_to_do(monkeypatch, noisy):
    monkeypatch.setattr(denoising, "_candidates", lambda: iter(()))
    denoising._library.cache_clear()
    denoising._device.cache_clear()
    try:
        assert not denoising.available()
        with pytest.raises(denoising.DenoisingError, match=r"blender\.org"):
            denoising.denoise(noisy[1])
    finally:
        denoising._library.cache_clear()
        denoising._device.cache_clear()
