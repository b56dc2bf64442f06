# SPDX-License-Identifier: GPL-3.0-or-later
"""Maps: the passes that tell how a render came about, each with the scale to show it by.

Images are dicts of pass name -> (channel letters, (h, w, channels) array) as exr.read() returns them; rows
keep their order. Knows neither bpy nor files, so that Blender and the command line show the same.
"""

from dataclasses import dataclass

import numpy as np

from .false_colour import Scale, encoded
from .passes import BY_NAME

TARGET, ACHIEVED = "VSP Target", "VSP Achieved"
DIFFERENCE = "VSP Achieved - Target"
SHARES = (TARGET, ACHIEVED, "Transmittance")  # in [0, 1]
DECADES = (
    "Variance",
    "Volume Variance",
    "Surface Variance",
    "Majorant Optical Depth",
)  # shown by their logarithm
AMOUNTS = ("Cost",)  # from 0
PICTURES = ("Combined", "Volume", "Surface")
ORDER = (
    "Combined", "Volume", "Surface", TARGET, ACHIEVED, DIFFERENCE, "Variance", "Volume Variance",
    "Surface Variance", "Transmittance", "Majorant Optical Depth", "Cost",
)  # fmt: skip
FALSE_COLOURED = tuple(name for name in ORDER if name not in PICTURES)

MOST_DECADES = 6  # that a logarithmic scale spans
HIGHEST_SHARE = 99.5  # percentile that scales reach up to: a few outliers may not darken the rest
WHITE_SHARE = 99  # percentile of the largest channel that a picture shows as white


@dataclass(frozen=True)
class Map:
    """values: (h, w), of a colour the mean over RGB. colours: (h, w, 3), 8-bit sRGB, by `scale` except for
    pictures. name: the pass's, with its layer where there are several."""

    name: str
    unit: str
    doc: str
    values: np.ndarray
    scale: Scale
    colours: np.ndarray
    is_picture: bool = False


def needs(base):
    """Returns the names of the passes that the map `base` is made of."""
    return (ACHIEVED, TARGET) if base == DIFFERENCE else (base,)


def doc(base):
    """Returns what the map `base` shows, without final stop."""
    return f"{ACHIEVED} less {TARGET}" if base == DIFFERENCE else BY_NAME[base].doc


def maps_of(images):
    """Returns the Maps that `images` hold, in the order of ORDER; none where they hold only other passes or
    Combined alone."""
    found = [
        (ORDER.index(base), prefix, base, name)
        for name in images
        for prefix, base in [split(name)]
        if base in ORDER and is_ours(base, images[name][0])
    ]
    found += [
        (ORDER.index(DIFFERENCE), prefix, DIFFERENCE, prefix + DIFFERENCE)
        for _, prefix, base, _ in found
        if base == TARGET and (ACHIEVED, images[prefix + TARGET][1].shape) in shapes(images, prefix)
    ]
    if {base for _, _, base, _ in found} <= {"Combined"}:
        return []
    exposures = {prefix: exposure(images, prefix) for _, prefix, _, _ in found}
    return [
        make_map(images, prefix, base, name, exposures[prefix]) for _, prefix, base, name in sorted(found)
    ]


def split(name):
    """Returns (the layer with its dot, or "", and the pass) of a pass's full name."""
    layer, dot, base = name.rpartition(".")
    return layer + dot, base


def shapes(images, prefix):
    """Yields (pass, shape) of one layer's passes."""
    for name, (_, pixels) in images.items():
        if name.startswith(prefix):
            yield name[len(prefix) :], pixels.shape


def is_ours(base, letters):
    """Tells whether a pass has the channels that ours of that name has."""
    return set(BY_NAME[base].channels) - {"A"} <= set(letters)


def make_map(images, prefix, base, name, white):
    """Returns the Map of the pass `base` of one layer. white: radiance that pictures show as white."""
    if base == DIFFERENCE:
        target, achieved = (scalar(*images[prefix + side]) for side in (TARGET, ACHIEVED))
        unit, values = "1", achieved - target
    else:
        unit, values = BY_NAME[base].unit, scalar(*images[name])
    scale = scale_of(base, values)
    if base not in PICTURES:
        return Map(name, unit, doc(base), values, scale, scale.colours(values))
    letters, pixels = images[name]
    return Map(name, unit, doc(base), values, scale, encoded(rgb(letters, pixels) / white), True)


def rgb(letters, pixels):
    """Returns the channels R, G, B."""
    return pixels[..., [letters.index(letter) for letter in "RGB"]]


def scalar(letters, pixels):
    """Returns a pass as one number a pixel, (h, w) in double precision: the mean over RGB, or its only
    channel."""
    return (rgb(letters, pixels) if "R" in letters else pixels[..., :1]).astype(float).mean(axis=-1)


def scale_of(base, values):
    """Returns the Scale that shows the values of the pass `base`."""
    finite = values[np.isfinite(values)]
    if base in SHARES:
        return Scale(0.0, 1.0)
    if base == DIFFERENCE:
        most = percentile(np.abs(finite), HIGHEST_SHARE)
        return Scale(-most, most, diverging=True)
    if base in AMOUNTS:
        return Scale(0.0, percentile(finite, HIGHEST_SHARE))
    positive = finite[finite > 0]
    if not positive.size:
        return Scale(0.0, 1.0)
    high, low = percentile(positive, HIGHEST_SHARE), float(positive.min())
    return Scale(min(max(low, high / 10**MOST_DECADES), high / 10), high, logarithmic=True)


def percentile(values, share):
    """Returns the percentile, the largest value where that is 0, and 1 where all are."""
    if not values.size:
        return 1.0
    return float(np.percentile(values, share)) or float(values.max()) or 1.0


def exposure(images, prefix):
    """Returns the radiance that the pictures of one layer show as white: the same for all of them, so that
    they can be compared."""
    for name in PICTURES:
        if prefix + name in images and is_ours(name, images[prefix + name][0]):
            pixels = rgb(*images[prefix + name]).max(axis=-1)
            return percentile(pixels[np.isfinite(pixels)], WHITE_SHARE)
    return 1.0
