# SPDX-License-Identifier: GPL-3.0-or-later
"""Checks a reference image against a second renderer, Cycles."""

import numpy as np

from bench import cycles

SEEDS = (401, 402, 403, 404)
SHARE = 16  # the second renderer takes this part of the reference's samples, in all


def against_cycles(made, bench):
    """Returns {"program", "samples", "seeds", "difference", "error", "z", "block_z"} of a Reference: by how
    much the mean of Cycles is above it, relatively, and the largest deviation among 8 x 8 parts of the image
    in standard errors, by the spread over seeds.

    bench: the measure.SceneBench that made it."""
    samples = max(1, made.provenance["samples"] // (SHARE * len(SEEDS)))
    done = cycles.render(bench.cycles_job(samples, SEEDS, guided=False))
    images = done.passes["Combined"].astype(np.float64)
    mean = made.image.mean()
    parts = [blocks(image) for image in (*images, made.image)]
    spread = np.std(parts[:-1], axis=0, ddof=1) / np.sqrt(len(SEEDS))
    z = made.bias_z(images)
    return {
        "program": done.version,
        "samples": samples,
        "seeds": list(SEEDS),
        "difference": float(images.mean() / mean - 1),
        "z": z,
        "block_t": float(np.abs((np.mean(parts[:-1], axis=0) - parts[-1]) / np.maximum(spread, 1e-12)).max()),
    }


def blocks(image, parts=8):
    """Returns the means of parts x parts blocks of an image over its pixels and channels."""
    rows = np.array_split(image.mean(axis=-1), parts, axis=0)
    return np.array([[block.mean() for block in np.array_split(row, parts, axis=1)] for row in rows])
