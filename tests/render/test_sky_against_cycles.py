# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky textures beside Cycles 5.0: what the camera sees of the sky, and what the sun's disc lights."""

import math
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import cycles, ours  # noqa: E402  the project's root is on the path only now

SIZE = (48, 32)
KINDS = [
    "MULTIPLE_SCATTERING",
    *(pytest.param(k, marks=pytest.mark.long) for k in ("SINGLE_SCATTERING", "PREETHAM", "HOSEK_WILKIE")),
]


def under_a_sky(bpy, path, kind, disc, height):
    """Saves a file with a white plane, `height` above the ground, under a sky of that kind."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    tree = scene.world.node_tree
    background = tree.nodes["Background"]
    background.inputs["Strength"].default_value = 0.4
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sky_type, sky.sun_disc = kind, disc
    sky.sun_elevation, sky.sun_rotation = 0.6, 0.7
    sky.sun_direction = (0.4, 0.5, 0.7)
    tree.links.new(sky.outputs[0], background.inputs["Color"])
    bpy.ops.mesh.primitive_plane_add(size=4, location=(0, 0, height))
    material = bpy.data.materials.new("White")
    material.node_tree.nodes.clear()
    output, white = (
        material.node_tree.nodes.new(f"ShaderNode{k}") for k in ("OutputMaterial", "BsdfDiffuse")
    )
    material.node_tree.links.new(white.outputs[0], output.inputs["Surface"])
    bpy.context.object.data.materials.append(material)
    camera = bpy.data.cameras.new("Camera")
    camera.angle = 1.5
    holder = bpy.data.objects.new("Camera", camera)
    scene.collection.objects.link(holder)
    scene.camera = holder
    holder.rotation_euler = (math.pi / 2 + 0.3, 0, -0.9) if height < 0 else (0, 0, 0)
    holder.location = (0, 0, height + 1)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.mark.parametrize("kind", KINDS)
def test_sky_agrees_with_cycles(bpy, tmp_path, kind):
    """To 2 % in every pixel, but for the row that holds the horizon, where the sky jumps."""
    path = tmp_path / "sky.blend"
    under_a_sky(bpy, path, kind, disc=False, height=-1000)
    job = cycles.Job(str(path), SIZE, 1, (1,), 0, pixel_filter="GAUSSIAN", filter_width=0.01)
    theirs = cycles.render(job).passes["Combined"][0]
    scene = ours.export(path, tmp_path, SIZE)
    assert scene.warnings == ()
    images, _ = ours.render(scene, (1,), samples=1, pixel_filter="gaussian", filter_width=0.01, threads=2)
    off = (np.abs(images["Combined"][0] - theirs) > 0.02 * theirs + 1e-3).any(-1)
    assert off.sum() <= SIZE[0], f"{off.mean():.0%} of the pixels differ"


def test_sun_lights_as_in_cycles(bpy, tmp_path):
    """The middle of a plane under sky and sun, to 2 %; 64 samples leave 0.3 % of noise in its mean."""
    path = tmp_path / "sun.blend"
    under_a_sky(bpy, path, "MULTIPLE_SCATTERING", disc=True, height=0)
    middle = (slice(12, 20), slice(20, 28))
    job = cycles.Job(str(path), SIZE, 64, (1,), 0)
    theirs = cycles.render(job).passes["Combined"][0][middle].mean((0, 1))
    scene = ours.export(path, tmp_path, SIZE)
    assert [light.kind for light in scene.lights] == ["sun"]
    images, _ = ours.render(scene, (1,), samples=64, threads=2)
    mine = images["Combined"][0][middle].mean((0, 1))
    assert mine == pytest.approx(theirs, rel=0.02)
