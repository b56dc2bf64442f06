# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files: where they go, that they can be written, and that each appears whole or not at all."""

import contextlib
import os
import re
from pathlib import Path

from .errors import InputError


@contextlib.contextmanager
def atomic(path):
    """Yields a path beside `path` to write to; afterwards renames it to `path`. On any failure `path` is left
    as it was.

    Raises InputError naming `path` where the operating system refuses to write.
    """
    path = Path(path)
    # The suffix stays last because some writers choose the format by it.
    temporary = path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")
    try:
        yield temporary
        temporary.replace(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def check_writable(path):
    """Raises InputError where a file `path` could not be written, by writing and removing a file beside
    it."""
    path = Path(path)
    if path.is_dir():
        raise InputError(f"{path}: is a directory; name a file")
    if not path.parent.is_dir():
        raise InputError(f"{path}: its directory {path.parent} does not exist; create it first")
    probe = path.with_name(f".{path.stem}.{os.getpid()}.probe")
    try:
        probe.touch(exist_ok=False)
        probe.unlink()
    except OSError as error:
        raise InputError(
            f"{path}: its directory {path.parent} cannot be written: {error.strerror}"
        ) from error


def check_suffix(path, suffix, option):
    """Raises InputError where the file given to `option` does not end in `suffix`."""
    if Path(path).suffix.lower() != suffix:
        raise InputError(f"{path}: {option} writes a file that ends in {suffix}")


def frame_path(path, frame, several):
    """Returns `path` for one frame: the last run of # becomes the padded number; without one the number (four
    digits, as Blender does) goes before the suffix where there are `several` frames. frame None: `path` as it
    is."""
    if frame is None:
        return Path(path)
    path = Path(path)
    runs = list(re.finditer("#+", path.name))
    if runs:
        begin, end = runs[-1].span()
        return path.with_name(f"{path.name[:begin]}{frame:0{end - begin}d}{path.name[end:]}")
    return path.with_name(f"{path.stem}{frame:04d}{path.suffix}") if several else path
