# SPDX-License-Identifier: GPL-3.0-or-later
"""A description file as the source of a scene for the command line: blend_source.py's twin, without bpy."""

import dataclasses
import tempfile
import time

import numpy as np
from PIL import Image

from . import description_file
from .errors import InputError


class DescriptionSource:
    """An opened description file; its VDB files are unpacked to a temporary folder until the with statement
    ends."""

    layer = "ViewLayer"
    start_seconds = 0.0
    frame = None
    warnings = ()

    def __init__(self, path, resolution=None):
        """resolution: (width, height) instead of the file's. Raises InputError naming the file and its
        fault."""
        self.path = path
        begin = time.perf_counter()
        self._directory = tempfile.TemporaryDirectory(prefix="nephele-")
        try:
            self._scene = description_file.load(path, self._directory.name)
            if resolution:
                self._scene = resized(self._scene, resolution, path)
        except BaseException:
            self._directory.cleanup()
            raise
        self.open_seconds = time.perf_counter() - begin

    def export(self, frame=None):
        """Returns the description.Scene. Raises InputError where a frame is asked for, since the file holds
        only one."""
        if frame is not None:
            raise InputError(
                f"{self.path}: a description file holds one frame; leave --frame and --frames out"
            )
        return self._scene

    def save_png(self, path, pixels):
        """Writes (h, w, 4) float32 linear premultiplied `pixels`, bottom row first, as sRGB with straight
        alpha."""
        Image.fromarray(srgb_bytes(pixels[::-1], self._scene.film.transparent)).save(path, format="PNG")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._directory.cleanup()


def srgb_bytes(pixels, transparent):
    """Returns (h, w, 4 or 3) uint8 of linear premultiplied (h, w, 4) pixels; IEC 61966-2-1 transfer
    function."""
    alpha = pixels[..., 3:].clip(0, 1)
    colour = pixels[..., :3]
    if transparent:
        colour = np.divide(colour, alpha, out=np.zeros_like(colour), where=alpha > 0)
    colour = np.nan_to_num(colour, nan=0.0, posinf=1.0, neginf=0.0).clip(0, 1)
    encoded = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055)
    return np.rint(255 * np.concatenate([encoded, alpha] if transparent else [encoded], axis=-1)).astype(
        np.uint8
    )


def resized(scene, resolution, path):
    """Returns `scene` for another number of pixels. Raises InputError where the picture's shape would change,
    since which side Blender would keep is not in the description."""
    film, (width, height) = scene.film, resolution
    if abs(width * film.height - height * film.width) > max(film.width, film.height):
        raise InputError(
            f"{path}: --resolution {width}x{height} has another shape than its {film.width}x{film.height}; "
            "save the description from the .blend at that resolution"
        )
    crop = film.crop
    if crop:
        x0, y0, x1, y1 = (
            round(c * n / o)
            for c, n, o in zip(crop, resolution * 2, (film.width, film.height) * 2, strict=True)
        )
        x0, y0 = min(x0, width - 1), min(y0, height - 1)
        crop = (x0, y0, max(x1, x0 + 1), max(y1, y0 + 1))  # at least a pixel
    return dataclasses.replace(scene, film=dataclasses.replace(film, width=width, height=height, crop=crop))
