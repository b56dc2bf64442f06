# SPDX-License-Identifier: GPL-3.0-or-later
"""The files Nephele keeps for itself: a JSON header and numpy arrays in one .npz, never pickled."""

import json
import tokenize
import zipfile
import zlib
from pathlib import Path

import numpy as np

from .errors import InputError
from .output import atomic


def write(path, kind, version, header, arrays):
    """Writes `header` (JSON values) and `arrays` (dict of numpy arrays) as a file of `kind` and `version` to
    `path`."""
    text = json.dumps({"kind": kind, "version": version, "content": header})
    with atomic(path) as temporary, temporary.open("wb") as file:
        # Not compressed: the bulk is VDB files, compressed already, and checkpoints, which must be written at
        # once.
        np.savez(
            file,
            header=np.frombuffer(text.encode(), np.uint8),
            **{f"array.{key}": a for key, a in arrays.items()},
        )


def read(path, kind, version):
    """Returns (header, arrays) as write() got them.

    Raises InputError naming the file where it is missing, damaged, not of `kind`, or of another version.
    """
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    try:
        with Path(path).open("rb") as file, np.load(file, allow_pickle=False) as archive:
            header = json.loads(archive["header"].tobytes())
            found = (header["kind"], header["version"])
            arrays = (
                {key[6:]: archive[key] for key in archive.files if key.startswith("array.")}
                if found == (kind, version)
                else {}
            )
            content = header["content"]
    except (
        OSError,
        EOFError,
        KeyError,
        TypeError,
        AttributeError,
        ValueError,
        zipfile.BadZipFile,
        zlib.error,
        NotImplementedError,
        SyntaxError,  # these two: numpy reads an array's header as Python
        tokenize.TokenError,
    ) as error:
        raise InputError(f"{path}: not a {kind}, or damaged ({error})") from error
    if found[0] != kind:
        raise InputError(f"{path}: holds a {found[0]}, not a {kind}")
    if found[1] != version:
        raise InputError(f"{path}: a {kind} of version {found[1]}; this Nephele reads version {version}")
    return content, arrays


def is_archive(path):
    """Tells whether the file begins as an archive of write() does."""
    with Path(path).open("rb") as file:
        return file.read(4) == b"PK\x03\x04"
