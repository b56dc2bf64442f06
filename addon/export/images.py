# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's images as description.Image: bytes as stored, floats scene-linear, bottom row first."""

import dataclasses
import re
import tempfile
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import bpy
import numpy as np

from ..description import Image
from .history import uid
from .mesh import frozen, same_or

ENCODED = {"sRGB"}  # colour spaces that the native side decodes
AS_STORED = {"Non-Color", "Raw", "Linear Rec.709", "Linear", "data"}
UNRELATED = {"CHANNEL_PACKED", "NONE"}  # alpha modes where alpha is no coverage


@dataclass(frozen=True)
class ImageUse:
    """How a node reads an image. associated: colours come multiplied by alpha, as Cycles has them where no
    node reads alpha. frame: number in the file names of a sequence; tile: UDIM number; None where the image
    has none."""

    image: Any
    associated: bool = False
    frame: int | None = None
    tile: int | None = None

    @property
    def key(self):
        return self.image.name_full, self.associated, self.frame, self.tile


def magenta(name):
    """Returns the one-pixel image that stands for an unreadable one."""
    return Image(name, np.array((((1.0, 0.0, 1.0, 1.0),),), np.float32))


@dataclass(frozen=True)
class KeptImage:
    """An image as an export read it. stamp: what tells that it is still so; None: nothing does. notes: what
    users are warned of."""

    image: Image
    notes: tuple
    stamp: tuple | None


def tile_numbers(image):
    """Returns the UDIM numbers of a tiled image, else (None,)."""
    return tuple(tile.number for tile in image.tiles) if image.source == "TILED" else (None,)


def sequence_frame(image, user, frame):
    """Returns the number of the file that an image sequence shows at the scene's `frame`; None for other
    images.

    user: Blender's ImageUser of the node."""
    if image.source != "SEQUENCE":
        return None
    count = max(user.frame_duration, 1)
    shown = frame - user.frame_start + 1
    if user.use_cyclic:
        shown = (shown - 1) % count + 1
    return min(max(shown, 1), count) + user.frame_offset


def kept_image(use, user, block, context):
    """Returns the description.Image of an ImageUse; magenta where it cannot be read.

    user: text naming the node that uses it, for warnings. block: the material or world of that node. What the
    last export read is taken over where it is known to be the same, or found to be.
    """
    cache = context.cache
    key, stamp = (uid(use.image), *use.key), _stamp(use)
    before = cache.images.get(key)
    # A file that Blender reads again makes it evaluate what uses the image; pixels set by scripts or strokes
    # do not, but leave the image without a stamp.
    trusted = stamp is not None and _untouched(cache.history, use.image, block)
    if not (trusted and before is not None and before.stamp == stamp):
        found, notes = _read(use)
        pixels = same_or(found.pixels, None if before is None else before.image.pixels)
        before = KeptImage(dataclasses.replace(found, pixels=pixels), notes, stamp)
    cache.images.put(key, before)
    for note in before.notes:
        context.warn(f"{user}: {note}")
    return before.image


def kept_picture(name, settings, pixels, cache):
    """Returns the description.Image of a picture that is computed. settings: they determine `pixels`, (h, w,
    3)."""
    key = (name, settings)
    kept = cache.images.get(key)
    if kept is None:
        opaque = np.ones((*pixels.shape[:2], 4), np.float32)
        opaque[..., :3] = pixels
        kept = KeptImage(Image(name, frozen(opaque)), (), None)
    return cache.images.put(key, kept).image


def _untouched(history, image, block):
    """Tells whether neither an image nor the material or world that uses it was evaluated anew."""
    return history.untouched(image, block, *filter(None, [block.node_tree]))


def _stamp(use):
    """Returns what changes with the pixels of a file; None for images that may change without."""
    image = use.image
    from_file = image.source in ("FILE", "SEQUENCE", "TILED") and bool(image.filepath)
    if not from_file or image.is_dirty or image.packed_file is not None or len(image.packed_files) > 0:
        return None
    path = _path_of(use)
    try:
        state = Path(path).stat()
    except OSError:
        return None
    held = (image.is_float, tuple(image.size)) if image.source == "FILE" else ()
    settings = (image.name, path, image.colorspace_settings.name, image.alpha_mode, *held)
    return (*settings, state.st_mtime_ns, state.st_size, state.st_ino)


def _path_of(use):
    """Returns the path of the one file that is used."""
    path = bpy.path.abspath(use.image.filepath, library=use.image.library)
    if use.tile is not None:
        return _tile_path(path, use.tile)
    return path if use.frame is None else numbered_path(path, use.frame)


def _read(use):
    """Returns (description.Image, notes)."""
    image, notes = use.image, []
    if image.source == "MOVIE":
        notes.append(f"image '{image.name}' is a movie; only the frame that Blender holds is used")
    with _file_of(use) as opened:
        pixels = None if opened is None else _stored(opened)
        if pixels is None:
            path = image.filepath or "no file"
            notes.append(f"image '{image.name}' ({path}{_part(use)}) cannot be read; magenta is used")
            return magenta(image.name), tuple(notes)
        return _described(pixels, opened, image, use.associated), tuple(notes)


def _part(use):
    """Returns what a warning says of the one of an image's files that is used."""
    if use.tile is not None:
        return f", tile {use.tile}"
    return "" if use.frame is None else f", frame {use.frame}"


@contextmanager
def _file_of(use):
    """Gives Blender's image of the one file that is used, or None where there is none."""
    image = use.image
    if use.tile is None and use.frame is None:
        yield image
        return
    opened = _open_packed(image, use.tile) if use.tile is not None else None
    path = _path_of(use)
    if opened is None and Path(path).is_file():
        opened = bpy.data.images.load(path)
    if opened is not None:
        opened.colorspace_settings.name = image.colorspace_settings.name
        opened.alpha_mode = image.alpha_mode
    try:
        yield opened
    finally:
        if opened is not None:
            bpy.data.images.remove(opened)


def _tile_path(path, tile):
    column, row = (tile - 1001) % 10 + 1, (tile - 1001) // 10 + 1
    return path.replace("<UDIM>", str(tile)).replace("<UVTILE>", f"u{column}_v{row}")


def _open_packed(image, tile):
    """Returns an image of a tile that is packed into the .blend, or None."""
    for packed in image.packed_files:
        if packed.packed_file is not None and str(tile) in Path(packed.filepath).name:
            opened = bpy.data.images.new("tile", 1, 1)
            opened.pack(data=packed.packed_file.data, data_len=packed.packed_file.size)
            opened.source = "FILE"
            return opened
    return None


def numbered_path(path, frame):
    """Returns the path of a sequence's file of that number: the last digits of its name are replaced."""
    folder, name = Path(path).parent, Path(path).name
    stem, suffix = Path(name).stem, Path(name).suffix
    found = list(re.finditer(r"\d+", stem))
    if not found:
        return path
    start, end = found[-1].span()
    return str(folder / f"{stem[:start]}{frame:0{end - start}d}{stem[end:]}{suffix}")


def _stored(image):
    """Returns the (h, w, 4) float32 pixels that Blender holds, or None where it cannot read the file."""
    width, height = image.size  # reads the file
    channels = image.channels
    if width * height == 0 or channels == 0 or len(image.pixels) != width * height * channels:
        return None
    stored = np.empty(width * height * channels, np.float32)
    image.pixels.foreach_get(stored)
    return _four_channels(stored.reshape(height, width, channels))


def _described(pixels, opened, image, associated):
    space = opened.colorspace_settings.name
    coverage = image.alpha_mode not in UNRELATED and space not in ("Non-Color", "Raw", "data")
    if image.alpha_mode == "NONE":
        pixels[..., 3] = 1.0
    if opened.is_float:  # Blender has converted it to scene-linear, multiplied by alpha
        return Image(image.name, pixels if associated or not coverage else _straight(pixels))
    if associated and coverage:
        pixels[..., :3] = (
            np.floor(pixels[..., :3] * pixels[..., 3:] * 255 + 1e-3) / 255
        )  # in bytes, as Cycles has it
    if space not in ENCODED | AS_STORED:
        return Image(image.name, _linear(pixels, space))
    return Image(image.name, np.rint(pixels * 255).astype(np.uint8), srgb=space not in AS_STORED)


def _linear(pixels, space):
    """Returns pixels of any colour space that Blender knows in scene-linear: by way of a file, as it
    converts what it reads."""
    height, width = pixels.shape[:2]
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder, "stored.exr"))
        stored = bpy.data.images.new("Stored", width, height, alpha=True, float_buffer=True, is_data=True)
        try:
            stored.alpha_mode = "CHANNEL_PACKED"
            stored.pixels.foreach_set(np.ascontiguousarray(pixels, np.float32).reshape(-1))
            stored.filepath_raw, stored.file_format = path, "OPEN_EXR"
            stored.save()
        finally:
            bpy.data.images.remove(stored)
        image = bpy.data.images.load(path)
        try:
            image.alpha_mode = "CHANNEL_PACKED"
            image.colorspace_settings.name = space
            return _stored(image)
        finally:
            bpy.data.images.remove(image)


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


def _straight(pixels):
    """Undoes premultiplication."""
    alpha = pixels[..., 3:]
    pixels[..., :3] = np.divide(pixels[..., :3], alpha, out=pixels[..., :3].copy(), where=alpha > 0)
    return pixels
