# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a render: the native passes, and Combined without noise where the settings ask for that."""

import dataclasses

import numpy as np

from . import denoising
from .passes import PASSES

FEATURES = ("Denoising Albedo", "Denoising Normal")


def needed(scene):
    """Returns a description.Scene whose film has all that pictures() takes: `scene` or a copy."""
    if not denoises(scene):
        return scene
    wanted = {*scene.film.passes, *FEATURES}
    film = dataclasses.replace(scene.film, passes=tuple(row.name for row in PASSES if row.name in wanted))
    return dataclasses.replace(scene, film=film)


def denoises(scene):
    """Tells whether Combined is asked for, without noise. Raises DenoisingError where that cannot be had."""
    wanted = scene.settings["denoise"] and "Combined" in scene.film.passes
    if wanted and not denoising.available():
        raise denoising.DenoisingError(denoising.UNAVAILABLE)
    return wanted


def pictures(renderer, scene):
    """Returns pass name -> (h, w, channels) float32, bottom row first, of a renderer of needed(scene). Raises
    DenoisingError."""
    images = {name: renderer.read_pass(name) for name in scene.film.passes}
    if denoises(scene):
        noisy = images["Combined"]
        features = (renderer.read_pass(name) for name in FEATURES)
        clean = denoising.denoise(noisy[..., :3], *features)
        images["Combined"] = np.concatenate([clean, noisy[..., 3:]], axis=-1)
    return images
