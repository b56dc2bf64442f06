# SPDX-License-Identifier: GPL-3.0-or-later
"""VDB files that exist only for a description that names them."""

import os
import tempfile
import weakref
from pathlib import Path

import bpy


class TemporaryPath(str):
    """The path of a file that is deleted with the last description that holds this path."""

    def __new__(cls, path):
        self = super().__new__(cls, path)
        weakref.finalize(self, Path(path).unlink, missing_ok=True)
        return self


def temporary_vdb():
    """Returns the TemporaryPath of a new, empty file."""
    handle, path = tempfile.mkstemp(prefix="nephele_", suffix=".vdb", dir=bpy.app.tempdir or None)
    os.close(handle)
    return TemporaryPath(path)
