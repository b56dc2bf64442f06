# SPDX-License-Identifier: GPL-3.0-or-later
"""Extreme scenes of Blender through the command line, as processes: what is broken in a .blend is named in
one line, and a picture of 16,384 x 4 pixels is written."""

import json
import subprocess
import sys

import numpy as np
import pytest
from nephele import exr

MAKE = """
import bpy, math
bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
scene = bpy.context.scene
scene.render.engine = "CYCLES"

def link(name, data):
    item = bpy.data.objects.new(name, data)
    scene.collection.objects.link(item)
    return item

def cube(name):
    mesh = bpy.data.meshes.new(name)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh.from_pydata(corners, [], faces)
    return mesh

camera = link("Eye", bpy.data.cameras.new("Eye"))
camera.location = (0, 0, 6)
scene.camera = camera
world = bpy.data.worlds.new("Sky")
world.use_nodes = True
scene.world = world
good = link("Good", cube("Good"))
lamp = link("Lamp", bpy.data.lights.new("Lamp", "POINT"))
lamp.location = (3, 0, 4)
lamp.data.energy = 500
bpy.ops.wm.save_as_mainfile(filepath="good.blend")
lamp.data.energy = 1e20
lamp.scale = (0, 0, 0)
bpy.ops.wm.save_as_mainfile(filepath="bright.blend")
lamp.data.energy, lamp.scale = 500, (1, 1, 1)
bad = link("Bad", cube("Bad mesh"))
bad.scale = (1, 0, 1)
bpy.ops.wm.save_as_mainfile(filepath="flat.blend")
bad.scale = (1, 1, 1)
bad.data.vertices[3].co = (0, math.nan, 0)
bpy.ops.wm.save_as_mainfile(filepath="nan.blend")
bad.data.vertices[3].co = (0, 1e30, 0)
bpy.ops.wm.save_as_mainfile(filepath="far.blend")
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Returns a folder with .blend files."""
    path = tmp_path_factory.mktemp("extreme")
    subprocess.run([sys.executable, "-c", MAKE], cwd=path, check=True, capture_output=True)
    return path


def render(folder, name, out, *arguments):
    command = [sys.executable, "-m", "nephele", "render", name, "-o", str(out), *arguments]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=300)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("nan.blend", ("Bad mesh", "not finite", "modifiers")),
        ("flat.blend", ("Bad", "scale")),
        ("far.blend", ("Bad", "further")),
    ],
)
def test_what_is_broken_is_named(folder, tmp_path, name, words):
    done = render(folder, name, tmp_path / "a.exr", "--resolution", "16x16", "--samples", "1")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert all(word in done.stderr for word in words), done.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.stress
@pytest.mark.parametrize(
    ("name", "resolution", "samples"),
    [("good.blend", "16384x4", "4"), ("good.blend", "4x4", "64"), ("bright.blend", "16x16", "64")],
)
def test_what_is_extreme_is_rendered(folder, tmp_path, name, resolution, samples):
    out, stats = tmp_path / "a.exr", tmp_path / "a.json"
    done = render(
        folder, name, out, "--resolution", resolution, "--samples", samples, "--stats", str(stats),
        "--set", "train_field=always",
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    width, height = map(int, resolution.split("x"))
    image = exr.read(out)["Combined"][1]
    assert image.shape[:2] == (height, width)
    assert np.isfinite(image).all()
    assert image[..., :3].max() > 0
    content = json.loads(stats.read_text())
    assert content["nonfinite_samples"] == 0
    assert content["seconds"]["render_cpu"] < 60
