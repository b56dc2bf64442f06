# SPDX-License-Identifier: GPL-3.0-or-later
"""Reference images of scenes, kept in a folder, and errors against them without the reference's own noise.

A reference R is the mean of two independent halves A and B. Its own noise shows in their difference:
E[((A - B) / 2)^2] = Var[R]. An image I that is independent of it has E[(I - R)^2] = Var[I] + Var[R] + bias^2,
so that what is reported is the error of I less the noise of R.
"""

import hashlib
from dataclasses import dataclass

import numpy as np
from nephele import description_file, metrics

from bench import ours

HALF_SEEDS = (1_000_001, 1_000_002)  # far from any seed that is measured


@dataclass(frozen=True)
class Reference:
    """halves: (2, height, width, 3), each of half the samples; image: their mean; noise: the relMSE of the
    image against the truth, {"relmse", "relmse_trimmed"}."""

    halves: np.ndarray
    image: np.ndarray
    noise: dict

    @classmethod
    def of(cls, halves):
        """Returns the Reference of two halves."""
        image = halves.astype(np.float64).mean(axis=0)
        return cls(halves, image, errors(image + (halves[0].astype(np.float64) - halves[1]) / 2, image))

    def error(self, image):
        """Returns {"relmse", "relmse_trimmed", "bias"} of an image (height, width, 3). The noise is taken
        off, so that an image as good as the reference may come out below 0."""
        measured = errors(image, self.image)
        bias = float(image.mean(dtype=np.float64) / self.image.mean()) - 1
        return {name: measured[name] - self.noise[name] for name in measured} | {"bias": bias}


def errors(image, truth):
    """Returns {"relmse", "relmse_trimmed"} of (height, width, 3) images. The trimmed one leaves out the worst
    0.1 % of the pixels. Raises ValueError where a pixel is not finite."""
    if not (np.isfinite(image).all() and np.isfinite(truth).all()):
        raise ValueError("an image has pixels that are not finite")
    return metrics.relmse(image.reshape(-1, 3).astype(np.float64), truth.reshape(-1, 3).astype(np.float64))


def load_or_render(folder, name, scene, samples, **settings):
    """Returns the Reference of a description.Scene of `samples` samples a pixel.

    It comes from FOLDER/NAME-....npz where one of the same content, resolution, samples and settings is
    there, and is left there otherwise. A renderer that has changed does not show in that name: remove the
    folder's files then.
    """
    size = (scene.film.width, scene.film.height)
    key = f"{description_file.fingerprint(scene)} {size} {samples} {sorted(settings.items())}"
    path = (
        folder / f"{name}-{size[0]}x{size[1]}-{samples}-{hashlib.sha256(key.encode()).hexdigest()[:12]}.npz"
    )
    if path.exists():
        with np.load(path) as stored:
            return Reference.of(stored["halves"])
    halves = ours.render(scene, HALF_SEEDS, samples=max(1, samples // 2), **settings)[0]["Combined"]
    folder.mkdir(parents=True, exist_ok=True)
    temporary = path.with_suffix(".part.npz")
    np.savez(temporary, halves=halves)
    temporary.rename(path)
    return Reference.of(halves)
