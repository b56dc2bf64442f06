# SPDX-License-Identifier: GPL-3.0-or-later
"""Differences between an image A and a reference R, as the field reports them.

Images are (h, w, channels) arrays; eps = 0.01. Pixels where either is not finite are left out and counted.

relmse   mean of (A - R)^2 / (R^2 + eps) over pixels and channels; relmse_trimmed: the same without the worst
         0.1 % of pixels, which a few fireflies cannot sway (and which hides them: read both).
smape    mean of 2 |A - R| / (|A| + |R| + eps).
mape     mean of |A - R| / (|R| + eps).
flip     mean HDR-FLIP error in [0, 1] (Andersson et al. 2021, Visualizing Errors in Rendered High Dynamic
         Range Images), colour passes only.
bias     mean(A) / mean(R) - 1.
bias_z   (mean(A) - mean(R)) over its standard error as the files' Variance passes give it. Near N(0, 1)
         without bias.
"""

import math

import numpy as np

EPSILON = 0.01
TRIMMED_SHARE = 0.001
NAMES = ("relmse", "smape", "mape", "flip", "bias")


def compare(image, reference, names=NAMES, colour=True, variance=None):
    """Returns a dict of the metrics called `names`; None where one is undefined (no finite pixel, division by
    0).

    colour: the first three channels are RGB (flip is only told for those). variance: (h, w) variance of the
    pixel means of image - reference, for bias_z, or None. Raises ValueError when the shapes differ.
    """
    if image.shape != reference.shape:
        raise ValueError(f"images differ in shape: {image.shape} and {reference.shape}")
    finite = np.isfinite(image).all(axis=-1) & np.isfinite(reference).all(axis=-1)
    result = {"nonfinite_pixels": int((~finite).sum())}
    a, r = image[finite].astype(np.float64), reference[finite].astype(np.float64)  # (pixels, channels)
    for name in names:
        if name == "flip":
            if colour:
                result["flip"] = flip(image, reference, finite)
        elif len(a) == 0:
            result |= dict.fromkeys(("relmse", "relmse_trimmed") if name == "relmse" else (name,))
        else:
            result |= FUNCTIONS[name](a, r)
    if "bias" in names and variance is not None:
        result["bias_z"] = bias_z(a, r, variance[finite].astype(np.float64))
    return result


def relmse(a, r):
    """Returns relmse and relmse_trimmed."""
    errors = np.sort(((a - r) ** 2 / (r**2 + EPSILON)).mean(axis=-1))
    kept = errors[: len(errors) - int(TRIMMED_SHARE * len(errors))]
    return {"relmse": float(errors.mean()), "relmse_trimmed": float(kept.mean())}


def smape(a, r):
    """Returns smape."""
    return {"smape": float((2 * np.abs(a - r) / (np.abs(a) + np.abs(r) + EPSILON)).mean())}


def mape(a, r):
    """Returns mape."""
    return {"mape": float((np.abs(a - r) / (np.abs(r) + EPSILON)).mean())}


def bias(a, r):
    """Returns bias; None for a reference of mean 0."""
    mean = float(r.mean())
    return {"bias": float(a.mean()) / mean - 1 if mean != 0 else None}


def bias_z(a, r, variance):
    """Returns the mean difference over its standard error, or None where the variance says nothing (0 or not
    finite).

    variance: per pixel, averaged over channels; at least that of the channels' mean, so |z| errs on the small
    side.
    """
    error = math.sqrt(variance.sum()) / len(variance) if len(variance) else 0.0
    return float((a - r).mean()) / error if error > 0 and math.isfinite(error) else None


def flip(image, reference, finite):
    """Returns the mean FLIP error over `finite` pixels of the RGB channels, or None when there are none."""
    return float(flip_map(image, reference, finite)[finite].mean()) if finite.any() else None


def flip_map(image, reference, finite):
    """Returns the FLIP error of every pixel, (h, w); that of pixels that are not `finite` says nothing."""
    import flip_evaluator  # slow to load, and of no use to the other commands

    # FLIP takes non-negative linear Rec. 709.
    a, r = (np.where(finite[..., None], i[..., :3], 0).clip(0).astype(np.float32) for i in (image, reference))
    # It derives its range of exposures from the reference's luminance, which for a black one has no
    # logarithm.
    parameters = {} if r.max() > 0 else {"startExposure": 0.0, "stopExposure": 0.0}
    errors, _, _ = flip_evaluator.evaluate(r, a, "HDR", applyMagma=False, parameters=parameters)
    return np.asarray(errors).reshape(finite.shape)


FUNCTIONS = {"relmse": relmse, "smape": smape, "mape": mape, "bias": bias}
