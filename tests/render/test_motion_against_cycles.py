# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur from a .blend against Cycles: objects that move and turn, a shape key and a moving camera.

The comparison and its false alarms are those of test_against_cycles.py.
"""

import math
from pathlib import Path

import pytest
from keyframes import animate
from test_against_cycles import BOUNCES, compare

FRAME = 5


def around(start, end):
    """Returns what to key: start in the frame before FRAME, end in the one after."""
    return {FRAME - 1: start, FRAME + 1: end}


def diffuse(bpy, color):
    material = bpy.data.materials.new("Diffuse")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeOutputMaterial")
    shader.inputs["Color"].default_value = (*color, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


@pytest.fixture
def moving_scene(bpy, link, tmp_path):
    """Returns the path of a .blend in which everything moves."""

    def box(name, size, color):
        mesh = bpy.data.meshes.new(name)
        corners = [[s * e / 2 for s, e in zip(signs, size, strict=True)] for signs in SIGNS]
        mesh.from_pydata(corners, [], FACES)
        mesh.materials.append(diffuse(bpy, color))
        return link(name, mesh)

    floor = box("Floor", (12, 12, 0.2), (0.7, 0.7, 0.6))
    floor.location.z = -0.1
    cube = box("Cube", (1, 1, 1), (0.8, 0.2, 0.1))
    animate(cube, "location", around((-2.5, 0.5, 0.6), (-0.5, 0, 1.2)))
    bar = box("Bar", (2.4, 0.3, 0.3), (0.1, 0.3, 0.8))
    bar.location = (1.2, -0.4, 0.8)
    animate(bar, "rotation_euler", around((0, 0, 0), (0, 0.4, math.pi * 0.9)))
    slab = box("Slab", (1, 1, 1), (0.2, 0.7, 0.2))
    slab.location = (0.3, 1.8, 0.5)
    slab.shape_key_add(name="Basis")
    key = slab.shape_key_add(name="Stretched")
    for number, point in enumerate(key.data):
        if SIGNS[number][2] > 0:
            point.co.z += 1.5
            point.co.x += 0.8
    animate(key, "value", around(0.0, 1.0))

    sun = bpy.data.lights.new("Sun", "SUN")
    sun.energy, sun.angle = 3, 0.2
    link("Sun", sun).rotation_euler = (0.6, 0.3, 0)
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
    scene = bpy.context.scene
    scene.world = world
    camera = link("Camera", bpy.data.cameras.new("Camera"))
    camera.rotation_euler = (1.0, 0, 0)
    animate(camera, "location", around((-0.3, -5.5, 4), (0.3, -5.3, 4)))
    scene.camera = camera
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    scene.frame_set(FRAME)
    path = tmp_path / "moving.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    return Path(path)


SIGNS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def test_everything_in_motion_agrees_with_cycles(moving_scene, tmp_path):
    compare(moving_scene, (64, 48), 64, 128, BOUNCES, tmp_path)
