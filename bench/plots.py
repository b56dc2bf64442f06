# SPDX-License-Identifier: GPL-3.0-or-later
"""Plots of a benchmark's report: error against CPU time and samples, both axes logarithmic, as SVG."""

import io

import matplotlib

matplotlib.use("svg")  # before pyplot looks for a display
from matplotlib import pyplot

# Colours that are told apart on the page's dark ground; for one method the same in every scene.
COLOURS = (
    "#6fb3ff", "#ffb454", "#7fd98a", "#ff7b9c", "#c9a0ff", "#5fd7d7",
    "#e8e36b", "#ff9466", "#a8b5c4", "#8ea6ff", "#d6a57c", "#b7e28a",
)  # fmt: skip
STYLE = {
    "figure.facecolor": "#202327",
    "axes.facecolor": "#202327",
    "savefig.facecolor": "#202327",
    "axes.edgecolor": "#6a7078",
    "axes.labelcolor": "#d8dadd",
    "text.color": "#d8dadd",
    "xtick.color": "#9a9fa6",
    "ytick.color": "#9a9fa6",
    "grid.color": "#363b42",
    "font.size": 10,
    "svg.fonttype": "none",
    "svg.hashsalt": "nephele",
}
AXES = {"cpu": "CPU time, s", "samples": "samples per pixel"}


def error_plot(curves, key, noise, colours):
    """Returns the SVG of relMSE against "cpu" or "samples".

    curves: method -> points of analysis.curve(); their spread over seeds is shaded. noise: the reference's,
    which is a dotted line: what lies below is not told apart from it. The dashed line falls as 1 / x."""
    with pyplot.rc_context(STYLE):
        figure, axes = pyplot.subplots(figsize=(6.0, 4.2), layout="constrained")
        for method, points in curves.items():
            x = [point[key] for point in points]
            low, high = zip(*(point["spread"] for point in points), strict=True)
            axes.fill_between(x, low, high, color=colours[method], alpha=0.15, linewidth=0)
            error = [point["relmse"] for point in points]
            axes.plot(x, error, color=colours[method], marker="o", markersize=3.5, label=method)
        base = next(iter(curves.values()))
        start = base[0]
        ideal = [start["relmse"] * start[key] / point[key] for point in base]
        axes.plot([point[key] for point in base], ideal, color="#9a9fa6", linestyle="--", linewidth=0.8)
        if noise > 0:
            axes.axhline(noise, color="#9a9fa6", linestyle=":", linewidth=0.8)
        axes.set(xscale="log", yscale="log", xlabel=AXES[key], ylabel="relMSE")
        axes.grid(visible=True, which="both", linewidth=0.5)
        axes.legend(frameon=False, fontsize=8)
        out = io.StringIO()
        figure.savefig(out, format="svg", metadata={"Date": None, "Creator": None})
        pyplot.close(figure)
    svg = out.getvalue()
    return svg[svg.index("<svg") :]


def colours_of(methods):
    """Returns {method: colour}."""
    return {method: COLOURS[k % len(COLOURS)] for k, method in enumerate(methods)}
