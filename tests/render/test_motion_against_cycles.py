# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur from a .blend against Cycles: objects that move and turn, a shape key, a moving camera, and
a cloud that turns and grows.

The comparison and its false alarms are those of test_against_cycles.py. The cloud stays in its place: where
one moves, Cycles is up to 5 % brighter than the mean of its own stills (docs/decisions.md).
"""

import math
from pathlib import Path

import numpy as np
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


@pytest.fixture
def cloud(bpy, link, openvdb, tmp_path):
    """Returns a function that makes a .blend of a cloud on its way over a floor, and returns its path.
    keyed: property -> (start, end)."""
    x, y, z = np.mgrid[0:16, 0:12, 0:10].astype(np.float32)
    density = np.clip(1.2 - (x - 8) ** 2 / 50 - (y - 6) ** 2 / 30 - (z - 5) ** 2 / 20, 0, 1) * (0.3 + x / 20)
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.copyFromArray(density)
    grid.transform = openvdb.createLinearTransform(0.1)
    grid.transform.postTranslate((-0.75, -0.55, -0.45))
    openvdb.write(str(tmp_path / "cloud.vdb"), grids=[grid])

    def make(**keyed):
        material = bpy.data.materials.new("Cloud")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        shader = tree.nodes.new("ShaderNodeVolumePrincipled")
        shader.inputs["Density"].default_value = 6
        shader.inputs["Anisotropy"].default_value = 0.3
        shader.inputs["Color"].default_value = (0.9, 0.7, 0.5, 1)
        output = tree.nodes.new("ShaderNodeOutputMaterial")
        tree.links.new(shader.outputs[0], output.inputs["Volume"])
        data = bpy.data.volumes.new("Cloud")
        data.filepath = str(tmp_path / "cloud.vdb")
        data.materials.append(material)
        item = link("Cloud", data)
        item.location.z = 1.2
        for name, (start, end) in keyed.items():
            animate(item, name, around(start, end))

        mesh = bpy.data.meshes.new("Floor")
        mesh.from_pydata([(-4, -4, 0), (4, -4, 0), (4, 4, 0), (-4, 4, 0)], [], [(0, 1, 2, 3)])
        mesh.materials.append(diffuse(bpy, (0.7, 0.7, 0.6)))
        link("Floor", mesh)
        sun = bpy.data.lights.new("Sun", "SUN")
        sun.energy, sun.angle = 3, 0.2
        link("Sun", sun).rotation_euler = (0.6, 0.3, 0)
        world = bpy.data.worlds.new("World")
        world.use_nodes = True
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
        scene = bpy.context.scene
        scene.world = world
        camera = link("Camera", bpy.data.cameras.new("Camera"))
        camera.location, camera.rotation_euler = (0, -4.5, 3.2), (1.05, 0, 0)
        scene.camera = camera
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
        scene.frame_set(FRAME)
        path = tmp_path / "moving_cloud.blend"
        bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
        return Path(path)

    return make


TURN = {"rotation_euler": ((0, 0, 0), (0.5, 0.2, 1.8)), "scale": ((1, 1, 1), (1.6, 0.7, 1.2))}


def test_a_cloud_that_turns_and_grows_agrees_with_cycles(cloud, tmp_path):
    compare(cloud(**TURN), (48, 40), 32, 64, BOUNCES, tmp_path)
