# SPDX-License-Identifier: GPL-3.0-or-later
"""Has a Blender render the bundled cloud by turns with Cycles and Nephele, and reads the pictures."""

import json
import shutil
import sys
from pathlib import Path

import numpy as np
import OpenEXR
from hosts import BUILD, INSIDE, ROOT, run

SIZE, SAMPLES = (96, 54), 4
WORK = BUILD / "test_blender"  # below the clone: it must be seen from inside the roots


def fresh(folder):
    """Returns a folder, made empty."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def read_combined(path):
    """Returns the picture in an EXR of Blender's or of the command line's, (height, width, 3), top row
    first."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        found = {name: c.pixels for part in file.parts for name, c in part.channels.items()}
    prefix = "" if "R" in found else "ViewLayer.Combined."
    return np.stack([found[prefix + c] for c in "RGB"], axis=-1)


def package(kind):
    """Returns the zip of a kind, as `make extension` left it."""
    tools = str(ROOT / "tools" / "extension")
    sys.path.insert(0, tools)
    try:
        from kinds import KINDS
    finally:
        sys.path.remove(tools)
    path = KINDS[kind].zip_path
    assert path.is_file(), f"{path} is missing: run `make extension`"
    return path


def without_blender(host, description):
    """Returns the picture that the native module in the host's zip makes of a description in its Python
    alone."""
    path = WORK / host.name / "without_blender.npy"
    script = [INSIDE / "render_description.py", "--", package(host.kind), description, path]
    run([*host.python(), *script], WORK)
    return np.load(path)


def render_by_turns(host, zip_path, blend, resources):
    """Installs a zip into a fresh user folder and renders by turns with Cycles and Nephele. Returns
    (pictures by name, what the script reported); see inside/install_and_render.py."""
    folder = fresh(WORK / host.name / "pictures")
    fresh(resources)
    host.run("install_and_render.py", zip_path, blend, folder, *SIZE, SAMPLES, resources=resources)
    pictures = {path.stem: read_combined(path) for path in Path(folder).glob("*.exr")}
    return pictures, json.loads((folder / "report.json").read_text())
