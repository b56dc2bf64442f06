# SPDX-License-Identifier: GPL-3.0-or-later
"""What the runs of a benchmark say: medians over seeds, slopes, gains at equal time, time to equal error.

Curves are of medians over seeds, straight between measured points where both axes are logarithmic, and go on
beyond them as error ~ 1 / time; a figure from more than a tenth beyond is marked as extrapolated.
"""

import math
import statistics

import numpy as np

FAR = math.log(1.1)  # beyond a curve, on a logarithmic axis
ERRORS = ("relmse", "relmse_trimmed", "smape", "mape", "flip")


def median(rows, key):
    """Returns the median over rows, None where one has no value."""
    values = [row[key] for row in rows]
    return None if None in values else statistics.median(values)


def by_slice(rows, method):
    """Returns the rows of a method, a list for each slice."""
    own = [row for row in rows if row["method"] == method]
    return [[row for row in own if row["slice"] == k] for k in sorted({row["slice"] for row in own})]


def curve(rows, method):
    """Returns a dict for each slice of a method: the medians of CPU seconds, samples and errors, and as
    "spread" the least and greatest relMSE of the seeds."""
    points = []
    for group in by_slice(rows, method):
        point = {key: median(group, key) for key in ("cpu", "samples", *ERRORS)}
        relmse = [row["relmse"] for row in group]
        points.append(point | {"spread": [min(relmse), max(relmse)], "seeds": len(group)})
    return points


def slope(xs, ys):
    """Returns the exponent k of y ~ x^k by least squares; None below two positive points."""
    pairs = [(x, y) for x, y in zip(xs, ys, strict=True) if y is not None and x > 0 and y > 0]
    if len(pairs) < 2:
        return None
    x, y = np.log(np.array(pairs)).T
    return float(np.polyfit(x, y, 1)[0]) if np.ptp(x) > 0 else None


def slopes(rows, method, key="relmse"):
    """Returns (exponent of error ~ samples^k, its standard error over seeds or None)."""
    own = [row for row in rows if row["method"] == method]
    each = []
    for seed in sorted({row["seed"] for row in own}):
        one = [row for row in own if row["seed"] == seed]
        each.append(slope([row["samples"] for row in one], [row[key] for row in one]))
    each = [value for value in each if value is not None]
    if not each:
        return None, None
    error = float(np.std(each, ddof=1) / math.sqrt(len(each))) if len(each) > 1 else None
    return statistics.fmean(each), error


def error_at(points, cpu, key="relmse"):
    """Returns (error of a curve at a CPU time, whether that is extrapolated); None where noise has made an
    error 0 or less."""
    x, y = logarithms(points, key)
    if x is None:
        return None, False
    at = math.log(cpu)
    if at < x[0] or at > x[-1]:
        end = 0 if at < x[0] else -1
        return math.exp(y[end] - (at - x[end])), bool(abs(at - x[end]) > FAR)
    return math.exp(np.interp(at, x, y)), False


def time_to(points, error, key="relmse"):
    """Returns (CPU seconds in which a curve comes down to an error, whether that is extrapolated)."""
    x, y = logarithms(points, key)
    if x is None:
        return None, False
    wanted = math.log(error)
    if wanted > y[0]:
        return math.exp(x[0] + (y[0] - wanted)), bool(wanted - y[0] > FAR)
    for k in range(1, len(x)):
        if y[k] <= wanted:
            share = (y[k - 1] - wanted) / (y[k - 1] - y[k]) if y[k - 1] > y[k] else 1.0
            return math.exp(x[k - 1] + share * (x[k] - x[k - 1])), False
    return math.exp(x[-1] + (y[-1] - wanted)), bool(y[-1] - wanted > FAR)


def logarithms(points, key):
    """Returns (log CPU seconds, log errors) of a curve, (None, None) where an error is not positive."""
    errors = [point[key] for point in points]
    if not errors or any(error is None or error <= 0 for error in errors):
        return None, None
    return np.log([point["cpu"] for point in points]), np.log(errors)


def compared(points, base, key="relmse"):
    """Returns how a curve compares with that of the base method: "gain", the base's error over its own at the
    CPU time of the base's last slice; "speedup", the base's CPU time over its own to the base's last error;
    for each whether it is from beyond the measured curve. None where noise has made an error 0 or less."""
    result = {"gain": None, "speedup": None, "gain_extrapolated": False, "speedup_extrapolated": False}
    last = base[-1]
    if last[key] is None or last[key] <= 0:
        return result
    error, beyond = error_at(points, last["cpu"], key)
    seconds, further = time_to(points, last[key], key)
    if error is None:
        return result
    return {
        "gain": last[key] / error,
        "speedup": last["cpu"] / seconds,
        "gain_extrapolated": beyond,
        "speedup_extrapolated": further,
    }


def summary(result):
    """Returns {method: what its runs say} of a measure.SceneResult, JSON values. The first method is the one
    that the others are compared with."""
    methods = list(result.images)
    curves = {method: curve(result.rows, method) for method in methods}
    told = {}
    for method in methods:
        fitted, spread = slopes(result.rows, method)
        base = curves[methods[0]]
        told[method] = {
            "curve": curves[method],
            "slope": fitted,
            "slope_error": spread,
            "against_base": compared(curves[method], base),
            "against_base_trimmed": compared(curves[method], base, "relmse_trimmed"),
            "bias": median([row for row in result.rows if row["method"] == method], "bias"),
            "bias_z": result.reference.bias_z(result.images[method][:, -1]),
            "cost": cost(result.told[method], curves[method], base),
        }
    return told


def cost(told, points, base):
    """Returns medians over seeds of what the runs tell of themselves, and "sample_cost", CPU seconds of a
    sample over those of the base method."""
    result = {
        key: statistics.median(run[key] for run in told)
        for key in ("build_cpu", "peak_rss_bytes", "path_length", "lookups", "train_share")
        if all(key in run for run in told)
    }
    per_sample = [curve[-1]["cpu"] / curve[-1]["samples"] for curve in (points, base)]
    return result | {"cpu_per_sample": per_sample[0], "sample_cost": per_sample[0] / per_sample[1]}


def geometric_mean(values):
    """Returns it over the values that are there, None where there are none."""
    values = [value for value in values if value is not None]
    return math.prod(values) ** (1 / len(values)) if values else None
