# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as description.Image: bytes as stored, floats scene-linear, straight alpha, bottom row
first."""

import dataclasses
from pathlib import Path

import bpy
import numpy as np

from ..description import Image
from .history import uid
from .mesh import frozen, same_or

ENCODED = {"sRGB"}  # colour spaces that the native side decodes
AS_STORED = {"Non-Color", "Raw", "Linear Rec.709", "Linear", "data"}


def magenta(name):
    """Returns the one-pixel image that stands for an unreadable one."""
    return Image(name, np.array((((1.0, 0.0, 1.0, 1.0),),), np.float32))


@dataclasses.dataclass(frozen=True)
class KeptImage:
    """An image as an export read it. stamp: what tells that it is still so; None: nothing does. notes: what
    users are warned of."""

    image: Image
    notes: tuple
    stamp: tuple | None


def kept_image(image, user, block, context):
    """Returns the description.Image of Blender's `image`; magenta where it cannot be read.

    user: text naming the node that uses it, for warnings. block: the material or world of that node. What the
    last export read is taken over where it is known to be the same, or found to be.
    """
    cache = context.cache
    key, stamp = uid(image) or image.name_full, _stamp(image)
    before = cache.images.get(key)
    # A file that Blender reads again makes it evaluate what uses the image; pixels set by scripts or strokes
    # do not, but leave the image without a stamp.
    trusted = stamp is not None and _untouched(cache.history, image, block)
    if not (trusted and before is not None and before.stamp == stamp):
        found, notes = _read(image)
        if before is not None:
            found = dataclasses.replace(found, pixels=same_or(found.pixels, before.image.pixels))
        before = KeptImage(found, notes, stamp)
    cache.images.put(key, before)
    for note in before.notes:
        context.warn(f"{user}: {note}")
    return before.image


def _untouched(history, image, block):
    """Tells whether neither an image nor the material or world that uses it was evaluated anew."""
    return history.untouched(image, block, *filter(None, [block.node_tree]))


def _stamp(image):
    """Returns what changes with the pixels of a file's image; None for images that may change without."""
    if image.source != "FILE" or image.is_dirty or image.packed_file is not None or not image.filepath:
        return None
    try:
        state = Path(bpy.path.abspath(image.filepath, library=image.library)).stat()
    except OSError:
        return None
    settings = (image.name, image.filepath, image.colorspace_settings.name, image.alpha_mode, image.is_float)
    return (*settings, tuple(image.size), state.st_mtime_ns, state.st_size, state.st_ino)


def _read(image):
    """Returns (description.Image, notes)."""
    notes = []
    if image.source in ("SEQUENCE", "MOVIE"):
        notes.append(
            f"image '{image.name}' is a {image.source.lower()}; only the frame that Blender holds is used"
        )
    if image.source == "TILED":
        notes.append(f"image '{image.name}' has UDIM tiles; only the first is used")
    width, height = image.size  # reads the file
    channels = image.channels
    if width * height == 0 or channels == 0 or len(image.pixels) != width * height * channels:
        notes.append(f"image '{image.name}' ({image.filepath or 'no file'}) cannot be read; magenta is used")
        return magenta(image.name), tuple(notes)
    stored = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(stored)
    pixels = _four_channels(stored.reshape(height, width, channels))
    space = image.colorspace_settings.name
    if image.is_float:  # Blender has converted it to scene-linear
        return Image(image.name, frozen(_straight(pixels, image))), tuple(notes)
    if space not in ENCODED | AS_STORED:
        notes.append(f"colour space '{space}' of image '{image.name}' is not supported; sRGB is assumed")
    encoded = frozen(np.rint(pixels * 255).astype(np.uint8))
    return Image(image.name, encoded, srgb=space not in AS_STORED), tuple(notes)


def _four_channels(pixels):
    """Returns (h, w, 4) of an image of 1 to 4 channels: grey repeated, alpha 1 where absent."""
    height, width, channels = pixels.shape
    if channels == 4:
        return pixels
    result = np.ones((height, width, 4), np.float32)
    if channels == 2:  # grey and alpha
        result[..., :3], result[..., 3] = pixels[..., :1], pixels[..., 1]
    else:
        result[..., :3] = pixels
    return result


def _straight(pixels, image):
    """Undoes premultiplication: Blender keeps float images premultiplied unless told that the channels are
    unrelated."""
    if image.alpha_mode in ("CHANNEL_PACKED", "NONE") or np.all(pixels[..., 3] == 1):
        return pixels
    alpha = pixels[..., 3:]
    pixels[..., :3] = np.divide(pixels[..., :3], alpha, out=pixels[..., :3].copy(), where=alpha > 0)
    return pixels
