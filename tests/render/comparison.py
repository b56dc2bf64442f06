# SPDX-License-Identifier: GPL-3.0-or-later
"""Holds renders of the same scene against each other. Each side is rendered with several seeds; pixels are
averaged over blocks, whose standard errors come from the scatter between seeds, so nothing is assumed of the
samples within a render."""

import numpy as np
import scipy.stats
from truth import NO_LIMIT

FALSE_ALARM = 1e-4  # of the blocks together, and of the image's means together


def moments(scene, seeds, samples, block, size=24, **settings):
    """Returns (means, squared standard errors), each of all blocks and channels, then the same of the
    whole image. size: of the film, block: of its blocks, pixels. Seeds count up from settings' `seed`."""
    images, first, n = [], settings.pop("seed", 0), size // block
    for seed in range(first, first + seeds):
        image = scene.render(size=size, samples=samples, seed=seed, **NO_LIMIT, **settings)["Combined"]
        images.append(image.reshape(n, block, n, block, 3).mean((1, 3)))
    images = np.array(images)
    whole = images.mean((1, 2))
    return tuple((x.mean(0), x.var(0, ddof=1) / seeds) for x in (images, whole))


def assert_same(one, other, seeds, error=0.015):
    """Asserts that two results of `moments` have the same expectations: Welch's t over all blocks and
    channels, and over the channels of the whole image, each with false alarm FALSE_ALARM (Sidak).

    error: the largest standard error of the images' difference, relative, at which the test can see enough.
    """
    for (mean, error2), (mean2, error22), what in zip(one, other, ("blocks", "image"), strict=True):
        sum2 = error2 + error22
        t = np.abs(mean - mean2) / np.sqrt(np.maximum(sum2, 1e-30))
        freedom = (seeds - 1) * sum2**2 / np.maximum(error2**2 + error22**2, 1e-60)  # Welch and Satterthwaite
        p = np.where(sum2 > 0, 2 * scipy.stats.t.sf(t, np.maximum(freedom, 1)), mean == mean2)
        limit = 1 - (1 - FALSE_ALARM) ** (1 / p.size)
        worst = np.unravel_index(p.argmin(), p.shape)
        assert p.min() > limit, (
            f"{what} {worst}: {mean[worst]:.5g} against {mean2[worst]:.5g}, "
            f"t = {t[worst]:.1f}, p = {p.min():.1e}"
        )
        if what == "image":
            assert np.all(np.sqrt(sum2) < error * mean), f"too noisy to tell: {np.sqrt(sum2) / mean}"
