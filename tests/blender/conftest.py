# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures of the tests that install the extension into Blenders: scenes, and the reference picture."""

import subprocess
import sys

import pytest
from hosts import MODULES, ROOT
from turns import SAMPLES, SIZE, WORK, fresh, read_combined

SCENES = ("cloud", "smoke")


def scene_file(name):
    """Returns the path of a bundled scene."""
    return ROOT / "blend_scenes" / name / f"{name}.blend"


@pytest.fixture(scope="session")
def from_venv():
    """Returns (picture, description file) of the bundled cloud as `nephele render` in .venv renders and
    saves it."""
    folder = fresh(WORK / "from_venv")
    path, saved = folder / "cloud.exr", folder / "cloud.nephele"
    command = [
        sys.executable,
        "-m",
        "nephele",
        "render",
        str(scene_file("cloud")),
        "--quiet",
        "-o",
        str(path),
    ]
    command += ["--samples", str(SAMPLES), "--resolution", f"{SIZE[0]}x{SIZE[1]}"]
    subprocess.run([*command, "--save-description", str(saved)], check=True, cwd=ROOT)
    return read_combined(path), saved


@pytest.fixture(scope="session")
def scene_for():
    """Returns a function (host, name) -> the .blend of a bundled scene that the host can open. Blenders
    before 4.5 get one that 4.5 saved."""
    folder = WORK / "scenes"

    def choose(host, name):
        if host.same_scene:
            return scene_file(name)
        if not (folder / f"{name}.blend").is_file():
            fresh(folder)
            saver = next(module for module in MODULES if module.name == "bpy-4.5.15")
            saver.run("resave.py", folder, *map(scene_file, SCENES), resources=fresh(WORK / "resaver"))
        return folder / f"{name}.blend"

    return choose
