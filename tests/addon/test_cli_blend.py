# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line on .blend files: opening, frames, colour management. Exporter and renderer are fakes, each
run is a process of its own, because bpy cannot be started twice."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from nephele import description_file, exr
from PIL import Image

MAKE_SCENES = """
import bpy
scene = bpy.context.scene
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 32, 16, 100
scene.view_settings.view_transform = "Standard"
scene.frame_set(3)
bpy.ops.wm.save_as_mainfile(filepath="plain.blend", compress=True)
second = scene.view_layers.new("Second")
bpy.data.objects["Cube"].hide_viewport = True
bpy.ops.wm.save_as_mainfile(filepath="layers.blend")
scene.camera = None
bpy.ops.wm.save_as_mainfile(filepath="blind.blend")
scene.camera = bpy.data.objects["Camera"]
scene.render.resolution_percentage, scene.render.resolution_x = 1, 16
bpy.ops.wm.save_as_mainfile(filepath="empty.blend")
scene.render.resolution_percentage = 100
volume = bpy.data.volumes.new("Smoke")
volume.filepath = "/nowhere/smoke.vdb"
scene.collection.objects.link(bpy.data.objects.new("Smoke", volume))
bpy.ops.wm.save_as_mainfile(filepath="novdb.blend")
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Returns a folder with .blend files."""
    path = tmp_path_factory.mktemp("blends")
    subprocess.run([sys.executable, "-c", MAKE_SCENES], cwd=path, check=True, capture_output=True)
    data = (path / "layers.blend").read_bytes()
    (path / "cut.blend").write_bytes(data[: len(data) // 2])
    (path / "head.blend").write_bytes(b"BLENDER17-01v0500" + bytes(1000))
    return path


HERE = Path(__file__).parent
COMMAND = (sys.executable, str(HERE / "fake_native.py"))
# Without what bpy adds once it is imported here: there, its parts cannot be imported before itself.
PATHS = [path for path in sys.path if path and "bpy" not in Path(path).parts]
ENVIRONMENT = os.environ | {"PYTHONPATH": os.pathsep.join([str(HERE), *PATHS])}


def run(folder, *arguments):
    """Runs the command line on fakes in `folder`; returns the finished process."""
    command = [*COMMAND, *map(str, arguments)]
    return subprocess.run(
        command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True, check=False, timeout=120
    )


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("blind.blend", ["blind.blend", "'Scene'", "no camera"]),
        ("empty.blend", ["empty.blend", "0x0"]),
        ("cut.blend", ["cut.blend", "cannot open"]),
        ("head.blend", ["head.blend", "cannot open"]),
        ("novdb.blend", ["/nowhere/smoke.vdb", "'Smoke'"]),
    ],
)
def test_bad_blend_is_one_line_and_exit_code_2(folder, tmp_path, name, words):
    done = run(folder, "render", name, "-o", tmp_path / "a.exr")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert all(word in done.stderr for word in words), done.stderr
    assert list(tmp_path.iterdir()) == []


def test_frame_of_the_file_and_png_with_its_view_transform(folder, tmp_path):
    out, png, stats = (tmp_path / name for name in ("a.exr", "a.png", "a.json"))
    done = run(folder, "render", "plain.blend", "-o", out, "--png", png, "--stats", stats)
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    content = json.loads(stats.read_text())
    assert content["frame"] == content["settings"]["seed"] == 3
    assert content["seconds"]["blender_start"] > 0
    assert content["first_tile_seconds"] < content["process_to_first_tile_seconds"]
    pixels, picture = exr.read(out)["Combined"][1], Image.open(png)
    assert (picture.size, picture.mode) == ((32, 16), "RGB")
    linear = pixels[..., :3].clip(0, 1)
    expected = 255 * np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.abs(np.asarray(picture) - expected).max() <= 1.5  # Blender dithers by up to half a step


def test_frames_are_exported_as_for_a_final_render(folder, tmp_path):
    done = run(
        folder, "render", "layers.blend", "-o", tmp_path / "a_##.exr", "--stats", tmp_path / "s.json",
        "--frames", "2-3", "--resolution", "40x10",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "a_02.exr",
        "a_03.exr",
        "s0002.json",
        "s0003.json",
    ]
    assert exr.read(tmp_path / "a_02.exr")["Combined"][1].shape == (10, 40, 4)
    content = json.loads((tmp_path / "s0002.json").read_text())
    assert content["settings"]["seed"] == 2
    assert "frame 2, RENDER" in content["warnings"]
    assert any("'Second' is not rendered" in warning for warning in content["warnings"])


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_signal_ends_the_process_within_a_second(folder, tmp_path, number):
    command = [*COMMAND, "render", "plain.blend", "-o", tmp_path / "a.exr", "--samples", "1000000"]
    environment = ENVIRONMENT | {"SECONDS_PER_SAMPLE": "0.1"}
    with subprocess.Popen(command, cwd=folder, env=environment, stderr=subprocess.PIPE) as process:
        try:
            while b"the fake renders noise" not in process.stderr.readline():  # said when the render begins
                assert process.poll() is None
            time.sleep(0.3)
            process.send_signal(number)
            begin = time.monotonic()
            process.communicate(timeout=60)
            assert time.monotonic() - begin < 1
        finally:
            process.kill()
    assert process.returncode == 130
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr.checkpoint.npz"]


def test_description_renders_like_its_blend(folder, tmp_path):
    saved = tmp_path / "saved.nephele"
    done = run(
        folder, "render", "plain.blend", "-o", tmp_path / "a.exr", "--save-description", saved, "--samples", 2
    )
    assert done.returncode == 0, done.stderr
    assert description_file.load(saved, tmp_path).settings["samples"] == 2
    assert run(folder, "render", saved, "-o", tmp_path / "b.exr").returncode == 0
    np.testing.assert_array_equal(
        exr.read(tmp_path / "a.exr")["Combined"][1], exr.read(tmp_path / "b.exr")["Combined"][1]
    )


def test_info_prints_nothing_but_json(folder):
    done = run(folder, "info", "layers.blend", "--json")
    assert (done.returncode, done.stderr) == (0, "")
    report = json.loads(done.stdout)
    assert (report["triangles"], report["camera"]["kind"]) == (2, "perspective")
    assert (report["kernel_features"], report["kernel"]) == (["mesh"], ["surfaces"])
    assert "frame 3, RENDER" in report["warnings"]
    text = run(folder, "info", "plain.blend")
    assert text.returncode == 0
    assert "32x16" in text.stdout
    assert "left out: volume\nkernel compiled for: surfaces\n" in text.stdout


def test_info_reads_the_headers_of_vdb_files(tmp_path):
    make = """
import sys, bpy
sys.path.append(bpy.utils.resource_path("LOCAL") + "/python/lib/python3.11/site-packages")
import numpy, openvdb
grid = openvdb.FloatGrid()
grid.copyFromArray(numpy.ones((4, 5, 6)))
grid.name = "density"
openvdb.write("smoke.vdb", grids=[grid])
volume = bpy.data.volumes.new("Smoke")
volume.filepath = __import__("os").path.abspath("smoke.vdb")
bpy.context.scene.collection.objects.link(bpy.data.objects.new("Smoke", volume))
bpy.ops.wm.save_as_mainfile(filepath="smoke.blend")
"""
    subprocess.run([sys.executable, "-c", make], cwd=tmp_path, check=True, capture_output=True)
    done = run(tmp_path, "info", "smoke.blend", "--json")
    assert done.returncode == 0, done.stderr
    (volume,) = json.loads(done.stdout)["volumes"]
    assert volume["grids"] == [
        {"name": "density", "type": "float", "active_voxels": 120, "resolution": [4, 5, 6], "used": True}
    ]
