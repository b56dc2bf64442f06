# SPDX-License-Identifier: GPL-3.0-or-later
"""The bundled suite of twelve scenes: each script makes the scene that is stored, every scene exports without
warnings and renders, and none is larger than its folder's README says."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from nephele import description_file

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import ours  # noqa: E402  the project's root is on the path only now

SUITE = ROOT / "blend_scenes" / "suite"
SCENES = sorted(path.stem for path in SUITE.glob("*.blend"))
HEAVY = "stress"  # takes a minute and over 1 GB
PROCESS = Path(__file__).with_name("suite_scenes.py")
CHEAP = "fog_lamps", "kitchen"  # seconds each: lamps and a mesh medium; an image and a volume program


def python(*arguments):
    """Returns what a script prints. Raises CalledProcessError where it fails."""
    command = [sys.executable, *map(str, arguments)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def exported(folder, paths):
    """Returns {name: fingerprint} of .blend files; their descriptions are in `folder`."""
    return json.loads(python(PROCESS, folder, *paths).splitlines()[-1])


def remade(folder, names):
    """Writes scenes anew by their scripts; returns their paths. Their volumes' folders stand beside."""
    for sibling in (ROOT / "blend_scenes").iterdir():
        if sibling.is_dir() and sibling != SUITE:
            (folder / sibling.name).symlink_to(sibling)
    (folder / "suite").mkdir()
    python(SUITE / "make.py", *names, "--output", folder / "suite")
    return [folder / "suite" / f"{name}.blend" for name in names]


def check_scripts(tmp_path, names):
    """Fails where a script makes another scene than the one that is stored."""
    paths = remade(tmp_path, names)
    for folder in ("old", "new"):
        (tmp_path / folder).mkdir()
    stored = exported(tmp_path / "old", [SUITE / f"{name}.blend" for name in names])
    assert exported(tmp_path / "new", paths) == stored
    for path in (tmp_path / "suite").glob("*.vdb"):
        assert path.read_bytes() == (SUITE / path.name).read_bytes()


def check_renders(folder, name):
    """Fails where a scene has warnings, or an image that is black or not finite."""
    vdbs = folder / name
    scene = description_file.load(folder / f"{name}.nephele", vdbs)
    assert scene.warnings == ()
    images, (statistics,) = ours.render(scene, (1,), samples=4, threads=2)
    image = images["Combined"][0]
    assert statistics["nonfinite_samples"] == 0
    assert np.isfinite(image).all()
    assert (image.mean((0, 1)) > 1e-4).all()


def test_make_knows_every_stored_scene():
    done = subprocess.run(
        [sys.executable, SUITE / "make.py", "nowhere"], check=False, capture_output=True, text=True
    )
    assert done.returncode == 2
    known = done.stderr.rsplit("there are ", 1)[1].strip().split(", ")
    assert sorted(known) == SCENES
    assert len(SCENES) == 12


@pytest.mark.parametrize("name", SCENES)
def test_files_are_small(name):
    assert (SUITE / f"{name}.blend").stat().st_size < 200_000
    vdb = SUITE / f"{name}.vdb"
    assert not vdb.exists() or vdb.stat().st_size < 1_000_000


def test_scripts_make_the_stored_scenes(tmp_path):
    check_scripts(tmp_path, CHEAP)


@pytest.mark.long
def test_all_scripts_make_the_stored_scenes(tmp_path):
    check_scripts(tmp_path, SCENES)


def test_every_scene_exports_without_warnings_and_renders(tmp_path):
    light = [name for name in SCENES if name != HEAVY]
    exported(tmp_path, [SUITE / f"{name}.blend" for name in light])
    for name in light:
        check_renders(tmp_path, name)


@pytest.mark.long
def test_stress_holds_what_it_says(tmp_path):
    exported(tmp_path, [SUITE / f"{HEAVY}.blend"])
    scene = description_file.load(tmp_path / f"{HEAVY}.nephele", tmp_path / "vdbs")
    assert len(scene.volumes) == 10
    assert len(scene.instances) == len(scene.meshes)
    assert sum(len(mesh.triangles) for mesh in scene.meshes) > 5_000_000
    check_renders(tmp_path, HEAVY)
