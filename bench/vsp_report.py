# SPDX-License-Identifier: GPL-3.0-or-later
"""Markdown of what bench/vsp.py measured."""

import math

HEADER = [
    "| configuration | CPU s | relMSE | trimmed | efficiency | trimmed | equal time: spp | CPU s | relMSE | "
    "trimmed | gain | trimmed | bias % |",
    "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
]


def number(value, digits=".2f"):
    """Returns a number as text, a dash for None."""
    return "-" if value is None else format(value, digits)


def bias(row):
    """Returns the difference of the image's mean in per cent, with its standard error."""
    error = row["bias_error"]
    return f"{100 * row['bias']:+.2f}" + ("" if error is None else f" ± {100 * error:.2f}")


def cells(row, gain):
    """Returns the texts of the columns CPU s, relMSE, trimmed, gain, trimmed; dashes for None."""
    if row is None:
        return ["-"] * 5
    errors = [number(row[name], ".3g") for name in ("relmse", "relmse_trimmed")]
    return [number(row["cpu"]), *errors, number(row[gain]), number(row[f"{gain}_trimmed"])]


def scene_table(name, results):
    """Returns the table of one scene: a line for each configuration."""
    scene, options = results["scenes"][name], results["options"]
    width, height = options["resolution"]
    per_sample = scene["summary"]["delta"]["equal_samples"]["cpu"] / options["samples"]
    noise = scene["reference_noise"]
    lines = [
        f"### {name} ({scene['wants']})",
        "",
        f"{width}x{height}, {options['samples']} samples at equal samples, {scene['bounces']} bounces, "
        f"medians of {options['seeds']} seeds.",
        f"Delta tracking: {1000 * per_sample:.1f} ms CPU a sample of the image.",
        "",
        *HEADER,
    ]
    uncertain = []
    for config, row in scene["summary"].items():
        equal, timed = row.get("equal_samples"), row.get("equal_time")
        texts = cells(equal, "efficiency")
        texts += [number(timed and timed["samples"], ".0f"), *cells(timed, "gain"), bias(timed or equal)]
        lines.append(f"| {config} | {' | '.join(texts)} |")
        uncertain += [part["relative_error"] for part in (equal, timed) if part and part["relative_error"]]
    lines += [
        "",
        f"The reference's own relMSE, {noise['relmse']:.2g} (trimmed {noise['relmse_trimmed']:.2g}), is "
        "taken off; trimmed: without the worst 0.1 % of the pixels; bias: of the image's mean, with its "
        "standard error.",
    ]
    if uncertain:
        lines.append(f"Standard errors of trimmed relMSE: up to {100 * max(uncertain):.0f} %.")
    lines.append("")
    return "\n".join(lines)


def overview(results):
    """Returns tables of efficiencies at equal samples and of gains at equal CPU time, trimmed in brackets:
    scenes by configurations, with geometric means."""
    tables = [table(results, "Efficiency", "equal_samples", "efficiency")]
    if any("equal_time" in row for scene in results["scenes"].values() for row in scene["summary"].values()):
        tables.append(table(results, "Gain at equal CPU time", "equal_time", "gain"))
    return "\n".join(tables)


def table(results, title, part, figure):
    """Returns the table of one figure; configurations that were never measured so are left out."""
    rows = {name: scene["summary"] for name, scene in results["scenes"].items()}
    lines = [
        f"### {title} against delta tracking (without the worst 0.1 % of the pixels)",
        "",
        f"| configuration | {' | '.join(rows)} | geometric mean |",
        "|---" * (len(rows) + 2) + "|",
    ]
    for config in dict.fromkeys(config for summary in rows.values() for config in summary):
        measured = [summary.get(config, {}).get(part) for summary in rows.values()]
        if not any(measured):
            continue
        pairs = [(row[figure], row[f"{figure}_trimmed"]) if row else (None, None) for row in measured]
        pairs.append(tuple(geometric_mean(values) for values in zip(*pairs, strict=True)))
        texts = [f"{number(raw)} ({number(trimmed)})" for raw, trimmed in pairs]
        lines.append(f"| {config} | {' | '.join(texts)} |")
    return "\n".join([*lines, ""])


def geometric_mean(values):
    """Returns it, None if one of the values is."""
    return None if None in values else math.prod(values) ** (1 / len(values))
