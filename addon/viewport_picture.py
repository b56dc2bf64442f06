# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D view shows of a render: a pass as it is, denoised, or in false colour. Knows no bpy.

Pictures are scene-linear, (h, w, 4) float32 with premultiplied alpha, bottom row first; Blender puts its
display transform over them.
"""

import numpy as np

from . import maps
from .false_colour import Scale
from .passes import BY_NAME, PASSES

COMBINED = "Combined"
# What the denoiser looks at beside Combined: passes of its own, where there are such.
GUIDES = tuple(
    f"Denoising {name}" if f"Denoising {name}" in BY_NAME else name for name in ("Albedo", "Normal")
)
CHOICES = (*(row.name for row in PASSES if not row.denoised), maps.DIFFERENCE)
AS_THEY_ARE = {row.name for row in PASSES if row.kind == "COLOR"} - {"Transmittance"}
LARGEST = 6e4  # of the half floats on the graphics card
FARTHEST = 1e9  # depths from there on mean that nothing is there


def doc(shown):
    """Returns what a choice shows, without final stop."""
    return maps.doc(shown)


def passes_for(shown, denoise):
    """Returns the names of the passes that a choice is made of."""
    if shown == COMBINED and denoise:
        return (COMBINED, *GUIDES)
    return maps.needs(shown)


def denoiser():
    """Returns the function denoise(color, albedo, normal), or None where there is none."""
    try:
        from . import denoising
    except ImportError:
        return None
    return denoising.denoise if denoising.available() else None


def picture(shown, images, denoise=None):
    """Returns (pixels, legend) of a choice. images: pass name -> (h, w, channels) array. denoise: see
    denoiser(); None: as it is. legend: what false colours stand for, "" without."""
    if shown in AS_THEY_ARE:
        pixels = images[shown]
        if denoise is not None and shown == COMBINED:
            color = np.ascontiguousarray(pixels[..., :3])
            albedo, normal = (np.ascontiguousarray(images[name]) for name in GUIDES)
            pixels = np.concatenate([denoise(color, albedo, normal), pixels[..., 3:]], axis=-1)
        return _finished(pixels), ""
    if shown == "Normal":  # from -1..1, as normal maps have it
        return _finished(0.5 + 0.5 * images[shown]), ""
    values = _values(shown, images)
    scale = _scale(shown, values)
    colours = _linear(scale.colours(values))
    if shown == "Depth":
        colours[np.isnan(values)] = 0
    return _finished(colours), f"{shown}: {scale.text()}"


def _values(shown, images):
    """Returns (h, w) numbers; NaN where there is nothing to show."""
    if shown == maps.DIFFERENCE:
        achieved, target = (images[name] for name in maps.needs(shown))
        return (achieved - target)[..., 0].astype(float)
    values = maps.scalar(BY_NAME[shown].channels, images[shown])
    return np.where(values < FARTHEST, values, np.nan) if shown == "Depth" else values


def _scale(shown, values):
    if shown == "Mist":
        return Scale(0.0, 1.0)
    if shown == "Sample Count":
        return Scale(0.0, float(values.max()) or 1.0)
    return maps.scale_of(shown, values)


def _linear(colours):
    """Returns 8-bit sRGB as scene-linear colours."""
    encoded = colours / np.float32(255)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def _finished(pixels):
    """Returns pixels that a graphics card can hold, opaque where they have no alpha."""
    if pixels.shape[-1] == 3:
        pixels = np.concatenate([pixels, np.ones((*pixels.shape[:2], 1), pixels.dtype)], axis=-1)
    finite = np.nan_to_num(pixels, nan=0.0, posinf=LARGEST, neginf=-LARGEST)
    return np.ascontiguousarray(np.clip(finite, -LARGEST, LARGEST), np.float32)
