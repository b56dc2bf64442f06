# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as description.Image: bytes as stored, floats scene-linear, straight alpha, bottom row
first."""

import numpy as np

from ..description import Image

ENCODED = {"sRGB"}  # colour spaces that the native side decodes
AS_STORED = {"Non-Color", "Raw", "Linear Rec.709", "Linear", "data"}


def magenta(name):
    """Returns the one-pixel image that stands for an unreadable one."""
    return Image(name, np.array((((1.0, 0.0, 1.0, 1.0),),), np.float32))


def read_image(image, user, warn):
    """Returns the description.Image of Blender's `image`; magenta where it cannot be read.

    user: text naming the node that uses it. warn: function that takes a sentence.
    """
    if image.source in ("SEQUENCE", "MOVIE"):
        warn(
            f"{user}: image '{image.name}' is a {image.source.lower()}; only the frame that Blender "
            "holds is used"
        )
    if image.source == "TILED":
        warn(f"{user}: image '{image.name}' has UDIM tiles; only the first is used")
    width, height = image.size  # reads the file
    channels = image.channels
    if width * height == 0 or channels == 0 or len(image.pixels) != width * height * channels:
        warn(f"{user}: image '{image.name}' ({image.filepath or 'no file'}) cannot be read; magenta is used")
        return magenta(image.name)
    stored = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(stored)
    pixels = _four_channels(stored.reshape(height, width, channels))
    space = image.colorspace_settings.name
    if image.is_float:  # Blender has converted it to scene-linear
        return Image(image.name, _straight(pixels, image))
    if space not in ENCODED | AS_STORED:
        warn(f"{user}: colour space '{space}' of image '{image.name}' is not supported; sRGB is assumed")
    return Image(image.name, np.rint(pixels * 255).astype(np.uint8), srgb=space not in AS_STORED)


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
