# SPDX-License-Identifier: GPL-3.0-or-later
"""Images of a benchmark's report: what every method made of the scene in the same time, where its errors are,
and the volume scattering probabilities that it used."""

import html

import numpy as np
from nephele import metrics
from nephele.false_colour import Scale, encoded
from nephele.inspection import png
from nephele.maps import HIGHEST_SHARE, WHITE_SHARE, percentile

WIDTH = 320  # of an image on the page, px
INSET, INSET_WIDTH = 0.2, 160  # of the frame's width; px
INSETS = 2
FLIP_SCALE = Scale(0.0, 1.0)


def parts(result):
    """Yields the HTML of the images of a measure.SceneResult: those of the first seed at the last budget."""
    reference = result.reference.image
    white = percentile(reference.max(axis=-1), WHITE_SHARE)
    images = {method: stack[0, -1].astype(float) for method, stack in result.images.items()}
    errors = {method: relative_error(image, reference) for method, image in images.items()}
    first = next(iter(errors.values()))
    scale = Scale(0.0, percentile(first, HIGHEST_SHARE))
    places = inset_places(first)
    yield "<h3>Images at equal CPU time</h3>"
    yield f"<p>Squared error over (squared reference + 0.01): {html.escape(scale.text())}. FLIP: 0 to 1.</p>"
    rows = [picture_row("reference", reference, white, places, "", "")]
    for method, image in images.items():
        finite = np.ones(image.shape[:2], bool)
        flip = metrics.flip_map(image, reference, finite)
        rows.append(
            picture_row(
                method,
                image,
                white,
                places,
                tag(scale.colours(errors[method]), f"error of {method}"),
                tag(FLIP_SCALE.colours(flip), f"FLIP of {method}"),
            )
        )
    yield framed(("", "image", *("inset",) * len(places), "squared error", "FLIP"), rows)
    if result.maps:
        yield "<h3>Volume scattering probability</h3>"
        yield "<p>Share of camera rays that scatter in the volume, 0 (dark) to 1 (bright).</p>"
        yield framed(
            ("", "target", "achieved"),
            [map_row(method, passes) for method, passes in result.maps.items()],
        )


def relative_error(image, reference):
    """Returns the squared error of each pixel as relMSE has it, (h, w)."""
    return ((image - reference) ** 2 / (reference**2 + metrics.EPSILON)).mean(axis=-1)


def inset_places(errors):
    """Returns slices (rows, columns) of the blocks that hold most of the first method's error, apart from
    each other; an inset is INSET of the frame wide."""
    height, width = errors.shape
    w = max(4, round(INSET * width))
    h = max(3, min(round(w * 9 / 16), height))
    left = np.minimum(errors, percentile(errors, HIGHEST_SHARE))  # a firefly is not a region
    places = []
    for _ in range(INSETS):
        sums = np.lib.stride_tricks.sliding_window_view(left, (h, w)).sum(axis=(2, 3))
        y, x = np.unravel_index(int(sums.argmax()), sums.shape)
        places.append((slice(y, y + h), slice(x, x + w)))
        left = left.copy()
        left[max(0, y - h // 2) : y + h, max(0, x - w // 2) : x + w] = 0
    return places


def picture_row(name, image, white, places, error, flip):
    """Returns the cells of one row of images."""
    shown = encoded(image / white)
    insets = [tag(shown[place], f"inset of {name}", INSET_WIDTH) for place in places]
    return [html.escape(name), tag(shown, name), *insets, error, flip]


def map_row(method, passes):
    """Returns the cells of one row of VSP maps."""
    return [
        html.escape(method),
        *(tag(Scale(0.0, 1.0).colours(m), f"{n} of {method}") for n, m in passes.items()),
    ]


def tag(colours, name, width=WIDTH):
    """Returns the <img> of an 8-bit sRGB image."""
    height = round(width * colours.shape[0] / colours.shape[1])
    source = f"data:image/png;base64,{png(np.ascontiguousarray(colours))}"
    return f'<img alt="{html.escape(name)}" width="{width}" height="{height}" src="{source}">'


def framed(head, rows):
    """Returns a table of HTML cells."""
    lines = ['<div class="pictures"><table>']
    lines.append("<tr>" + "".join(f"<th>{cell}</th>" for cell in head) + "</tr>")
    lines += ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows]
    return "\n".join([*lines, "</table></div>"])
