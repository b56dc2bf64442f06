# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip as far as `make test` can: packed from the module that is built, installed into Blender's module
alone.

What takes other Blenders is in test_modules.py and test_executables.py, run by `make test-blender`.
"""

import subprocess
import sys
import tomllib
import zipfile

import numpy as np
import pytest
from checks import check_report, check_turns
from hosts import ROOT, VenvModule
from turns import WORK, package, render_by_turns

TOOLS = ROOT / "tools" / "extension"


@pytest.fixture(scope="module")
def zip_path():
    """Returns the zip for this machine, made from build/release; Blender's own tool has validated it."""
    subprocess.run([ROOT / "scripts" / "setup.sh", "extension"], check=True, cwd=ROOT)
    for script in ("make_wheel.py", "make_zip.py"):
        subprocess.run([sys.executable, TOOLS / script, "development"], check=True, cwd=ROOT)
    return package("development")


def test_manifest_asks_for_no_network_and_names_its_blenders(zip_path):
    with zipfile.ZipFile(zip_path) as file:
        manifest = tomllib.loads(file.read("blender_manifest.toml").decode())
        names = file.namelist()
    assert manifest["schema_version"] == "1.0.0"
    assert manifest["license"] == ["SPDX:GPL-3.0-or-later"]
    assert set(manifest["permissions"]) == {"files"}
    assert (manifest["blender_version_min"], manifest["blender_version_max"]) == ("4.2.0", "5.1.0")
    assert [f"./{name}" for name in names if name.endswith(".whl")] == manifest["wheels"]
    assert not [name for name in names if name.startswith(("commands/", "cli", "exr"))]


def test_installs_and_renders_between_cycles(zip_path, from_venv):
    host = VenvModule("development", "development")
    pictures, told = render_by_turns(host, zip_path, ROOT / "blend_scenes/cloud/cloud.blend", WORK / "user")
    check_report(told, WORK / "user")
    check_turns(pictures, from_venv[0])
    assert np.isfinite(from_venv[0]).all()


@pytest.fixture
def guard(tmp_path):
    """Returns a function that imports the guard for a first Python in a process of its own, with a stand-in
    for the module, and runs a line after it. Returns (status, last line on stderr)."""

    def run(first, line="", processor="native"):
        package = tmp_path / "nephele_native"
        package.mkdir()
        (package / "__init__.py").write_text((TOOLS / "guard.py").read_text())
        (package / "_built_for.py").write_text(
            f"FIRST_PYTHON = {first}\nLAST_PYTHON = None\nPROCESSOR = {processor!r}\n"
        )
        (package / "nephele_native.py").write_text("__version__ = '0'\n")
        code = f"import nephele_native as n\n{line}"
        done = subprocess.run(
            [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False
        )
        return done.returncode, done.stderr.strip().split("\n")[-1]

    return run


def test_another_python_is_refused_before_the_module_loads(guard):
    status, words = guard((3, 99))
    assert (
        status == 1
        and "this is the build for Python 3.99 and newer, and this Blender has Python 3.11" in words
    )


def test_an_older_processor_is_refused_before_the_module_loads(guard):
    old = "'flags : fpu sse4_2 popcnt avx f16c'"
    status, words = guard((3, 11), f"n.PROCESSOR = 'x86-64-v3'; n._require((3, 11), {old})")
    assert status == 1
    assert "this processor lacks abm, avx2, bmi1, bmi2, fma, movbe" in words and "level x86-64-v3" in words


def test_this_processor_is_accepted(guard):
    assert guard((3, 11)) == (0, "")
