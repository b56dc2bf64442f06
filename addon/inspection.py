# SPDX-License-Identifier: GPL-3.0-or-later
"""The page that `nephele inspect` writes: one HTML file with its images inside, which loads nothing else."""

import base64
import html
import io
import json
from pathlib import Path

import numpy as np

from .errors import InputError
from .maps import rgb, split
from .passes import BY_NAME

BINS = 64  # of a histogram
BAR_HEIGHT = 40  # of a histogram, in its own units

STYLE = """
body { font: 14px/1.4 sans-serif; margin: 24px; background: #16181b; color: #d8dadd; }
h1 { font-size: 20px; } h2 { font-size: 16px; margin-top: 32px; } h3 { font-size: 14px; margin: 0; }
.maps { display: grid; grid-template-columns: repeat(auto-fill, minmax(340px, 1fr)); gap: 20px; }
figure { margin: 0; } figcaption { color: #9a9fa6; font-size: 12px; }
figure img { width: 100%; image-rendering: pixelated; display: block; }
.bar { height: 12px; } .histogram { width: 100%; height: 48px; display: block; background: #202327; }
.ticks { display: flex; justify-content: space-between; font-size: 12px; }
table { border-collapse: collapse; } td, th { padding: 2px 14px 2px 0; text-align: left; }
td.number, th.number { text-align: right; font-variant-numeric: tabular-nums; }
"""


def page(title, images, maps, render, statistics=None):
    """Returns the HTML of one rendered image.

    images: as exr.read() returns them; maps: maps.maps_of(images). render: what read_render() returned.
    statistics: what STATS.json holds.
    """
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        f"<p>{html.escape(headline(images, render))}</p>",
        '<div class="maps">',
        *(figure(shown) for shown in maps),
        "</div>",
        "<h2>Values</h2>",
        "<p>Over all pixels whose value is finite; colours by their mean over RGB.</p>",
        table(("pass", "unit", "min", "median", "mean", "max", "not finite"), figures(images)),
    ]
    if render:
        parts += ["<h2>Settings</h2>", table(("setting", "value"), flat(render["settings"]))]
    if statistics is not None:
        shown = {key: value for key, value in statistics.items() if key not in ("settings", "passes")}
        parts += ["<h2>Statistics</h2>", table(("name", "value"), flat(shown))]
    return document(title, parts)


def document(title, parts, style=""):
    """Returns the HTML of a page of these parts. style: CSS besides STYLE."""
    return "\n".join(
        [
            "<!DOCTYPE html>",
            f'<html lang="en"><head><meta charset="utf-8"><title>{html.escape(title)}</title>',
            f"<style>{STYLE}{style}</style></head><body>",
            *parts,
            "</body></html>\n",
        ]
    )


def headline(images, render):
    """Returns the render in one line."""
    height, width = next(iter(images.values()))[1].shape[:2]
    words = [f"{width} x {height} pixels"]
    if not render:
        return f"{words[0]}; the file's header does not tell of a render by nephele"
    film = render["film"]
    if film["crop"]:
        words.append(f"from {film['crop'][:2]} on, of a frame of {film['width']} x {film['height']}")
    words.append(f"{render['samples']} samples per pixel")
    words.append(f"Nephele {render['version']}")
    return ", ".join(words)


def figure(shown):
    """Returns the HTML of one maps.Map: the image, its legend and its histogram."""
    height, width = shown.values.shape
    name = html.escape(shown.name)
    legend = (
        "Linear sRGB, the pictures of a layer at one exposure; below: mean over RGB"
        if shown.is_picture
        else ""
    )
    bar = "" if shown.is_picture else f'<div class="bar" style="background:{gradient(shown.scale)}"></div>'
    ticks = "".join(f"<span>{shown.scale.value(at):.3g}</span>" for at in (0, 0.25, 0.5, 0.75, 1))
    kind = "logarithmic" if shown.scale.logarithmic else "linear"
    return (
        f'<figure><h3>{name}</h3><img alt="{name}" width="{width}" height="{height}" '
        f'src="data:image/png;base64,{png(shown.colours)}">{histogram(shown)}{bar}'
        f'<div class="ticks">{ticks}</div>'
        f"<figcaption>{html.escape(shown.doc)} [{html.escape(shown.unit)}], {kind} scale. {legend}"
        "</figcaption></figure>"
    )


def png(colours):
    """Returns an 8-bit sRGB image as a PNG in base64."""
    from PIL import Image  # the other commands need not wait for it

    out = io.BytesIO()
    Image.fromarray(colours).save(out, "PNG")
    return base64.b64encode(out.getvalue()).decode("ascii")


def gradient(scale):
    """Returns a Scale's ramp in CSS: equal distances, linear in sRGB between, as Scale.colours() does."""
    return f"linear-gradient(to right,{','.join(f'rgb{colour}'.replace(' ', '') for colour in scale.ramp)})"


def histogram(shown):
    """Returns an SVG of how many pixels have which value, over the scale's whole length; pixels beyond it are
    in the first and the last bar."""
    position = shown.scale.position(shown.values)
    counts, _ = np.histogram(position[np.isfinite(position)], bins=BINS, range=(0, 1))
    heights = BAR_HEIGHT * np.sqrt(counts / max(counts.max(), 1))
    bars = "".join(f"M{k} {BAR_HEIGHT}v-{h:.4g}h1v{h:.4g}z" for k, h in enumerate(heights) if h > 0)
    return (
        f'<svg class="histogram" viewBox="0 0 {BINS} {BAR_HEIGHT}" preserveAspectRatio="none" role="img">'
        f"<title>Pixels by value; heights are square roots of the counts, up to {counts.max()}</title>"
        f'<path fill="#aab2bd" d="{bars}"/></svg>'
    )


def figures(images):
    """Yields a row of the table of values for each pass; a pass that is neither a colour nor a single number
    has a row for each channel."""
    for name, (letters, pixels) in images.items():
        known = BY_NAME.get(split(name)[1])
        unit = known.unit if known else ""
        if set("RGB") <= set(letters):
            rows = {name: rgb(letters, pixels).astype(float).mean(axis=-1)}
        elif len(letters) == 1:
            rows = {name: pixels[..., 0].astype(float)}
        else:
            rows = {f"{name}.{letter}": pixels[..., k].astype(float) for k, letter in enumerate(letters)}
        for row, values in rows.items():
            finite = values[np.isfinite(values)]
            measures = [f(finite) if finite.size else np.nan for f in (np.min, np.median, np.mean, np.max)]
            yield (row, unit, *(number(measure) for measure in measures), str(values.size - finite.size))


def number(value):
    """Returns a number in six digits."""
    return f"{value:.6g}"


def flat(values, prefix=""):
    """Yields (name, text) of every value in nested dicts and lists, names joined by points."""
    for key, value in values.items():
        if isinstance(value, dict):
            yield from flat(value, f"{prefix}{key}.")
        elif isinstance(value, list) and any(isinstance(item, dict) for item in value):
            yield from flat({str(k): item for k, item in enumerate(value)}, f"{prefix}{key}.")
        else:
            text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
            yield prefix + key, text


def table(head, rows):
    """Returns an HTML table of texts; columns that hold numbers alone are set as such."""
    rows = list(rows)
    numeric = [len(head) > 2 and k > 1 for k in range(len(head))]

    def line(tag, cells):
        kinds = (' class="number"' if right else "" for right in numeric)
        cells = (f"<{tag}{kind}>{html.escape(cell)}</{tag}>" for kind, cell in zip(kinds, cells, strict=True))
        return f"<tr>{''.join(cells)}</tr>"

    return "\n".join(["<table>", line("th", head), *(line("td", row) for row in rows), "</table>"])


def read_render(path, attributes):
    """Returns what the EXR's header (exr.read_attributes()) says of the render as a dict: the identity, see
    checkpoint.py, and "samples". Empty where it says nothing, as in Blender's files. Raises InputError naming
    the file."""
    if "identity" not in attributes:
        return {}
    try:
        found = json.loads(attributes["identity"]) | {"samples": int(attributes["samples"])}
        if not (isinstance(found["settings"], dict) and isinstance(found["version"], str)):
            raise TypeError("settings or version are of another type")
        film = found["film"]
        found["film"] = {"width": int(film["width"]), "height": int(film["height"]), "crop": film["crop"]}
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: what its header says of the render is damaged: {error}") from error
    return found


def read_statistics(path):
    """Returns what a STATS.json holds. Raises InputError naming the file."""
    try:
        content = json.loads(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except ValueError as error:
        raise InputError(f"{path}: not a STATS.json that nephele render wrote: {error}") from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: not a STATS.json that nephele render wrote")
    return content
