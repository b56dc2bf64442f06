# SPDX-License-Identifier: GPL-3.0-or-later
"""The page that `nephele render --report` writes: how the estimated error of a render fell with time and with
samples. One HTML file with everything inside.

Marks are the dicts of Renderer.statistics()["errors"]: seconds, cpu_seconds, samples, error.
"""

import html
import math

import numpy as np

from .false_colour import encoded
from .inspection import document, flat, number, png, table
from .maps import exposure

FIRST = 16  # samples from which on estimates of the error say something
WIDTH, HEIGHT, MARGIN = 520, 320, 56  # of a plot, px

PLOT_STYLE = """
.plots { display: flex; flex-wrap: wrap; gap: 24px; }
svg.plot { background: #202327; } svg.plot text { fill: #9a9fa6; font-size: 12px; }
svg.plot line { stroke: #363b42; } svg.plot polyline { fill: none; stroke: #6fb3ff; stroke-width: 2; }
svg.plot .ideal { stroke: #9a9fa6; stroke-dasharray: 4 4; }
"""


def page(title, native, combined, shown):
    """Returns the HTML. native: Renderer.statistics(). combined: its Combined pass, bottom row first, or
    None. shown: nested dict of what else to list."""
    marks = [dict(mark) for mark in native["errors"] if mark["error"] > 0 and math.isfinite(mark["error"])]
    parts = [f"<h1>{html.escape(title)}</h1>", f"<p>{html.escape(headline(native, marks))}</p>"]
    if combined is not None:
        height, width = combined.shape[:2]
        parts.append(f'<img alt="Combined" width="{width}" height="{height}" src="{picture(combined)}">')
    if len(marks) > 1:
        parts += [
            '<div class="plots">',
            plot(marks, "cpu_seconds", "CPU time of the render threads, s"),
            plot(marks, "samples", "samples per pixel"),
            "</div>",
        ]
    rows = (
        tuple(number(mark[key]) for key in ("samples", "seconds", "cpu_seconds", "error")) for mark in marks
    )
    parts += [
        "<p>relMSE: mean over pixels of variance / (radiance squared + 0.01), by the spread of the samples. "
        "It errs on the high side where samples are stratified, and on the low side where rare light was not "
        "seen yet. The dashed line falls as 1 / samples, as an unbiased render's error does.</p>",
        table(("samples", "seconds", "CPU seconds", "error"), rows),
        "<h2>Render</h2>",
        table(("name", "value"), flat(shown)),
    ]
    return document(title, parts, PLOT_STYLE)


def headline(native, marks):
    """Returns what came of the render in a line."""
    if not marks:
        return f"{native['samples_done']} samples per pixel; without noise, or too few to tell an error"
    last = marks[-1]
    words = [
        f"estimated error {last['error']:.3g} after {last['samples']} samples per pixel, "
        f"{last['seconds']:.1f} s ({last['cpu_seconds']:.1f} CPU s)"
    ]
    if (fitted := slope(marks)) is not None:
        words.append(f"error proportional to samples^{fitted:.2f}")
    if native["target_reached"]:
        words.append("the target is reached")
    return "; ".join(words)


def slope(marks):
    """Returns the exponent k of error ~ samples^k by least squares from FIRST samples on; None below three
    marks."""
    late = [mark for mark in marks if mark["samples"] >= FIRST]
    if len(late) < 3:
        return None
    x, y = (np.log([mark[key] for mark in late]) for key in ("samples", "error"))
    return float(np.polyfit(x, y, 1)[0])


def picture(combined):
    """Returns Combined as a PNG in a data URL, at the exposure of inspect's page."""
    white = exposure({"Combined": ("RGBA", combined)}, "")
    return f"data:image/png;base64,{png(encoded(combined[::-1, :, :3] / white))}"


def plot(marks, key, label):
    """Returns an SVG of the error against marks[key], both logarithmic."""
    points = [(mark[key], mark["error"]) for mark in marks if mark[key] > 0]
    xs, ys = (decades([point[k] for point in points]) for k in (0, 1))

    def place(x, y):
        across = (math.log10(x) - xs[0]) / (xs[-1] - xs[0])
        up = (math.log10(y) - ys[0]) / (ys[-1] - ys[0])
        return MARGIN + across * (WIDTH - 1.5 * MARGIN), HEIGHT - MARGIN - up * (HEIGHT - 1.5 * MARGIN)

    parts = [
        f'<svg class="plot" width="{WIDTH}" height="{HEIGHT}" role="img"><title>error by {label}</title>'
    ]
    for decade in xs:
        x, y = place(10.0**decade, 10.0 ** ys[0])
        parts.append(f'<line x1="{x:.1f}" y1="{MARGIN / 2}" x2="{x:.1f}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{x:.1f}" y="{y + 18:.1f}" text-anchor="middle">{10.0**decade:g}</text>')
    for decade in ys:
        x, y = place(10.0 ** xs[0], 10.0**decade)
        parts.append(f'<line x1="{x:.1f}" y1="{y:.1f}" x2="{WIDTH - MARGIN / 2}" y2="{y:.1f}"/>')
        parts.append(f'<text x="{x - 6:.1f}" y="{y + 4:.1f}" text-anchor="end">{10.0**decade:g}</text>')
    parts.append(polyline([place(x, y) for x, y in points], ""))
    last_x, last_y = points[-1]
    ideal = [(x, last_y * last_x / x) for x, _ in points]
    parts.append(polyline([place(x, y) for x, y in ideal if y <= 10.0 ** ys[-1]], ' class="ideal"'))
    parts.append(
        f'<text x="{WIDTH / 2}" y="{HEIGHT - 8}" text-anchor="middle">{html.escape(label)}</text></svg>'
    )
    return "".join(parts)


def decades(values):
    """Returns the powers of ten that enclose positive values, at least two."""
    low, high = math.floor(math.log10(min(values))), math.ceil(math.log10(max(values)))
    return list(range(low, max(high, low + 1) + 1))


def polyline(points, kind):
    """Returns the SVG of a line."""
    return f'<polyline{kind} points="{" ".join(f"{x:.1f},{y:.1f}" for x, y in points)}"/>'
