# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a benchmark: one HTML file with its plots and images inside, which loads nothing else.

Where a method loses to the first one its figure is set in red, where it wins in green; a figure from
more than a tenth beyond the measured curve has a tilde.
"""

import html

import numpy as np
from nephele.inspection import document, flat, table

from bench import analysis, pictures, plots

STYLE = """
.row { display: flex; flex-wrap: wrap; gap: 16px; align-items: flex-start; }
svg { max-width: 100%; height: auto; } .pictures { overflow-x: auto; }
.pictures table td { padding: 2px 6px 2px 0; vertical-align: top; color: #9a9fa6; font-size: 12px; }
.pictures img { image-rendering: pixelated; display: block; }
td.win { color: #7fd98a; } td.loss { color: #ff7b7b; } td.failed { color: #ff7b7b; }
h3 { margin: 20px 0 6px; } section { border-top: 1px solid #363b42; margin-top: 36px; }
"""
LOSS, WIN = 0.95, 1.05  # a gain between counts as none


def page(title, scenes, about):
    """Returns the HTML. scenes: name -> (suites.BenchScene, measure.SceneResult, analysis.summary). about:
    nested dict of machine, commit and settings."""
    methods = list(
        dict.fromkeys(m for _, result, _ in scenes.values() for m in (*result.images, *result.failed))
    )
    colours = plots.colours_of(methods)
    parts = [f"<h1>{html.escape(title)}</h1>", INTRODUCTION]
    if scenes:
        parts += ["<h2>All scenes</h2>", *overview(methods, scenes)]
    for name, (scene, result, summary) in scenes.items():
        parts += ["<section>", f"<h2>{html.escape(name)}</h2>", *scene_parts(scene, result, summary, colours)]
        parts.append("</section>")
    parts += ["<section><h2>How it was measured</h2>", table(("name", "value"), flat(about)), "</section>"]
    return document(title, parts, STYLE)


INTRODUCTION = """<p>relMSE: mean of squared error over (squared reference + 0.01), the reference's own noise
taken off; trimmed: without the worst 0.1 % of the pixels, which fireflies cannot sway, and which hides them:
read both. Gain: error of the first method over that of another at the same CPU time. Speed-up: CPU time of
the first method over that of another to the same error. Slope: of error over samples; an unbiased method's is
-1. Bias: of the image's mean; z: in standard errors, beyond 4 it is real, or the two programs differ by
convention. CPU time is that of all threads from the built scene on; building is told apart.</p>"""


def overview(methods, scenes):
    """Returns the tables of gains and speed-ups, scenes by methods, with geometric means."""
    parts = []
    for figure, title in (
        ("gain", "Gain at equal CPU time (trimmed)"),
        ("speedup", "Speed-up to equal error (trimmed)"),
    ):
        rows = []
        for method in methods:
            found = [summary.get(method) for _, _, summary in scenes.values()]
            pairs = [
                (one["against_base"], one["against_base_trimmed"]) if one else (None, None) for one in found
            ]
            cells = [gain_cell(raw, trimmed, figure) for raw, trimmed in pairs]
            means = [analysis.geometric_mean([side[k][figure] for side in pairs if side[k]]) for k in (0, 1)]
            complete = all(pair[0] and pair[0][figure] for pair in pairs)
            rows.append((method, [*cells, mean_cell(means, complete)]))
        parts.append(f"<h3>{title}</h3>" + matrix(("method", *scenes, "geometric mean"), rows))
    return parts


def gain_cell(raw, trimmed, figure):
    """Returns (text, class) of a figure."""
    if raw is None or raw[figure] is None:
        return "-", ""
    sign = "~" if raw[f"{figure}_extrapolated"] else ""
    second = "-" if trimmed[figure] is None else f"{trimmed[figure]:.2f}"
    return f"{sign}{raw[figure]:.2f} ({second})", kind(raw[figure])


def mean_cell(means, complete):
    """Returns (text, class) of geometric means; in brackets where scenes are missing."""
    if means[0] is None:
        return "-", ""
    second = "-" if means[1] is None else f"{means[1]:.2f}"
    return f"{means[0]:.2f} ({second}){'' if complete else ' of the scenes measured'}", kind(means[0])


def kind(gain):
    """Returns the class of a gain's cell."""
    return "loss" if gain < LOSS else "win" if gain > WIN else ""


def matrix(head, rows):
    """Returns an HTML table of rows (name, [(text, class), ...])."""
    lines = ["<table>", "<tr>" + "".join(f"<th>{html.escape(cell)}</th>" for cell in head) + "</tr>"]
    for name, cells in rows:
        texts = "".join(f'<td class="{style}">{html.escape(text)}</td>' for text, style in cells)
        lines.append(f"<tr><td>{html.escape(name)}</td>{texts}</tr>")
    return "\n".join([*lines, "</table>"])


def scene_parts(scene, result, summary, colours):
    """Yields the HTML of one scene."""
    height, width = result.reference.image.shape[:2]
    yield f"<p>{html.escape(scene.about)}. {width} x {height} pixels, {scene.bounces} bounces.</p>"
    yield f"<p>{html.escape(provenance(result.reference))}</p>"
    for method, words in result.failed.items():
        yield f'<p class="failed">{html.escape(method)} did not render this scene: {html.escape(words)}</p>'
    if not summary:
        return
    curves = {method: told["curve"] for method, told in summary.items()}
    yield '<div class="row">'
    for key in plots.AXES:
        yield plots.error_plot(curves, key, result.reference.noise["relmse"], colours)
    yield "</div>"
    yield table(ERROR_HEAD, (error_row(method, told) for method, told in summary.items()))
    yield "<h3>What it costs</h3>"
    yield table(COST_HEAD, (cost_row(method, told["cost"]) for method, told in summary.items()))
    yield from pictures.parts(result)


def provenance(made):
    """Returns where a reference comes from, in words."""
    told = made.provenance
    words = [
        f"Reference: {told['method']}, {told['samples']} samples, version {told['version']}, "
        f"its own relMSE {made.noise['relmse']:.2g} (trimmed {made.noise['relmse_trimmed']:.2g})"
    ]
    if check := told.get("check"):
        words.append(
            f"{check['program']}: mean {100 * check['difference']:+.2f} % ({check['z']:+.1f} standard errors)"
        )
    return "; ".join(words) + f". Made by: {told['command']}"


ERROR_HEAD = (
    "method", "slope", "samples", "CPU s", "relMSE", "trimmed", "SMAPE", "MAPE", "FLIP",
    "gain (trimmed)", "speed-up (trimmed)", "bias %", "z",
)  # fmt: skip


def error_row(method, told):
    """Returns the texts of a method's row of errors, of its last slice."""
    last = told["curve"][-1]
    spread = "" if told["slope_error"] is None else f" ± {told['slope_error']:.2f}"
    errors = [number(last[name]) for name in analysis.ERRORS]
    gains = [gain_cell(told["against_base"], told["against_base_trimmed"], f)[0] for f in ("gain", "speedup")]
    return (
        method,
        "-" if told["slope"] is None else f"{told['slope']:.2f}{spread}",
        f"{last['samples']:.0f}",
        f"{last['cpu']:.2f}",
        *errors,
        *gains,
        "-" if told["bias"] is None else f"{100 * told['bias']:+.2f}",
        "-" if told["bias_z"] is None else f"{told['bias_z']:+.1f}",
    )


COST_HEAD = (
    "method", "ms CPU a sample of the image", "against the first", "segments a path",
    "density lookups a path", "training %", "peak memory MiB", "building, CPU s",
)  # fmt: skip


def cost_row(method, cost):
    """Returns the texts of a method's row of costs."""
    return (
        method,
        f"{1000 * cost['cpu_per_sample']:.1f}",
        f"{cost['sample_cost']:.2f}",
        number(cost.get("path_length")),
        number(cost.get("lookups")),
        number(None if "train_share" not in cost else 100 * cost["train_share"]),
        number(None if "peak_rss_bytes" not in cost else cost["peak_rss_bytes"] / 2**20),
        number(cost.get("build_cpu")),
    )


def number(value):
    """Returns a number in three digits, a dash for None or NaN."""
    return "-" if value is None or np.isnan(value) else f"{value:.3g}"
