# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders that take over parts of those before them, by the ways that users have: F12 with Persistent Data,
and frame ranges of the command line. Their pictures are those of renders that build all anew."""

import subprocess
import sys

import numpy as np
import OpenEXR
import pytest
from keyframes import animate
from nephele import engine, exr
from nephele.session import Session


@pytest.fixture
def scene(bpy, camera, link):
    """Returns a small scene in which an object, a shape, the camera and a lamp change from frame to frame."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.nephele.samples = 24, 16, 2
    scene.world = bpy.data.worlds.new("World")
    for name in ("Still", "Moving", "Bent"):
        bpy.ops.mesh.primitive_uv_sphere_add(segments=12, ring_count=6, location=(len(name) - 5, 0, 0))
        bpy.context.object.name = name
    animate(bpy.data.objects["Moving"], "location", {1: (0, 0, 0), 4: (0, 1, 0)})
    bent = bpy.data.objects["Bent"].modifiers.new("Bend", "SIMPLE_DEFORM")
    bent.driver_add("angle").driver.expression = "frame / 3"
    animate(camera, "location", {1: (0, 0, 8), 4: (0.5, 0, 8)})
    lamp = bpy.data.lights.new("Lamp", "POINT")
    link("Lamp", lamp).location = (2, 2, 3)
    animate(lamp, "energy", {1: 100.0, 4: 500.0})
    return scene


def frames_by_f12(bpy, scene, folder, persistent):
    """Returns the pictures of frames 1 to 3, and of 3 once more with a lamp changed, of each view layer."""
    scene.render.use_persistent_data = persistent
    settings = scene.render.image_settings
    settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    pictures = []
    for number, frame in enumerate((1, 2, 3, 3)):
        scene.frame_set(frame)
        bpy.data.lights["Lamp"].shadow_soft_size = 0.1 if number < 3 else 0.5
        scene.render.filepath = str(folder / f"{persistent}{number}.exr")
        bpy.ops.render.render(write_still=True)
        assert engine.last_render.state == "done", engine.last_render.message
        pictures.append(channels(scene.render.filepath))
    return pictures


def channels(path):
    """Returns channel name -> pixels of a multilayer EXR."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: c.pixels for part in file.parts for name, c in part.channels.items()}


@pytest.mark.parametrize("blur", [False, True])
def test_f12_with_persistent_data(bpy, scene, tmp_path, monkeypatch, blur):
    made = []
    monkeypatch.setattr(engine, "Session", lambda: made.append(Session()) or made[-1])
    scene.render.use_motion_blur = blur
    scene.view_layers.new("Second")
    fresh = frames_by_f12(bpy, scene, tmp_path, False)
    assert len(made) == 2 * len(fresh)
    made.clear()
    kept = frames_by_f12(bpy, scene, tmp_path, True)
    assert len(made) == 1
    scene.render.use_persistent_data = False
    for number, (expected, found) in enumerate(zip(fresh, kept, strict=True)):
        assert expected.keys() == found.keys() and any("Second" in name for name in found)
        for name in expected:
            np.testing.assert_array_equal(found[name], expected[name], f"{name} of render {number}")
    assert not np.array_equal(kept[0]["ViewLayer.Combined.R"], kept[1]["ViewLayer.Combined.R"])


def test_a_range_of_frames_is_its_frames(bpy, scene, tmp_path):
    blend = tmp_path / "scene.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(blend))

    def render(*arguments):
        command = [sys.executable, "-m", "nephele", "render", str(blend), "--quiet", *map(str, arguments)]
        done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=300)
        assert done.returncode == 0, done.stderr

    render("-o", tmp_path / "all_#.exr", "--frames", "1-3")
    render("-o", tmp_path / "third.exr", "--frame", "3")
    first, third = (exr.read(tmp_path / name)["Combined"][1] for name in ("all_1.exr", "third.exr"))
    np.testing.assert_array_equal(exr.read(tmp_path / "all_3.exr")["Combined"][1], third)
    assert not np.array_equal(first, third)
