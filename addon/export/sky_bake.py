# SPDX-License-Identifier: GPL-3.0-or-later
"""Script of a process of its own: Cycles renders what a Sky Texture gives in every direction.

    blender --background --factory-startup --python sky_bake.py -- SETTINGS.json OUT.npz

The texture shines from a plane under an orthographic camera, one direction a pixel. sky: (h, w, 3),
equirectangular, bottom row first, without the sun's disc. sun: (3,), the irradiance of the disc."""

import json
import math
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

WIDTH, DISC_PIXELS = 1024, 32


def new_scene():
    """Empties the file; returns the material's node tree of a plane that fills an orthographic image 2
    wide."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    mesh = bpy.data.meshes.new("Plane")
    mesh.from_pydata([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], [], [(0, 1, 2, 3)])
    material = with_nodes(bpy.data.materials.new("Sky"))
    mesh.materials.append(material)
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 2
    for name, data, height in (("Plane", mesh, 0), ("Camera", camera, 2)):
        item = bpy.data.objects.new(name, data)
        item.location.z = height
        scene.collection.objects.link(item)
    scene.camera = bpy.data.objects["Camera"]
    render, cycles = scene.render, scene.cycles
    render.engine, render.image_settings.file_format = "CYCLES", "OPEN_EXR"
    render.image_settings.color_depth = "32"
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", 1, False, False
    cycles.pixel_filter_type, cycles.filter_width = "GAUSSIAN", 0.01
    material.node_tree.nodes.clear()
    return material.node_tree


def with_nodes(block):
    """Returns a material or world with its node tree, which only Blender 5 makes at once."""
    if block.node_tree is None:
        block.use_nodes = True
    return block


def add(tree, kind, *inputs, **properties):
    """Adds ShaderNode`kind`; returns its first output."""
    node = tree.nodes.new(f"ShaderNode{kind}")
    for name, value in properties.items():
        setattr(node, name, value)
    for socket, value in zip(node.inputs, inputs, strict=False):
        if isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        elif value is not None:
            socket.default_value = value
    return node.outputs[0]


def picture(settings, width, height, direction_of):
    """Returns (height, width, 3), bottom row first: the texture in the directions that direction_of (tree,
    x, y) makes of the plane's coordinates, x in [-1, 1]."""
    tree = new_scene()
    place = add(tree, "NewGeometry")
    x, y = (add(tree, "Math", place_of, 0.0) for place_of in _coordinates(tree, place))
    sky = add(tree, "TexSky", direction_of(tree, x, y), **settings)
    emission = add(tree, "Emission", sky)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission, output.inputs["Surface"])
    return rendered(width, height)


def rendered(width, height):
    """Returns (height, width, 3), bottom row first, of the scene."""
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = width, height
    with tempfile.TemporaryDirectory() as folder:
        render.filepath = str(Path(folder, "sky.exr"))
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(render.filepath)
        pixels = np.empty(width * height * image.channels, np.float32)
        image.pixels.foreach_get(pixels)
    return pixels.reshape(height, width, -1)[..., :3]


def _coordinates(tree, place):
    separate = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(place, separate.inputs[0])
    return separate.outputs[0], separate.outputs[1]


def around(tree, x, y):
    """Direction of the equirectangular map's place: x turns about z, y in [-0.5, 0.5] is the elevation over
    pi."""
    azimuth, elevation = (
        add(tree, "Math", v, f, operation="MULTIPLY") for v, f in ((x, -math.pi), (y, math.pi))
    )
    flat = add(tree, "Math", elevation, operation="COSINE")
    parts = [add(tree, "Math", azimuth, operation=o) for o in ("COSINE", "SINE")]
    sideways = [add(tree, "Math", part, flat, operation="MULTIPLY") for part in parts]
    return add(tree, "CombineXYZ", *sideways, add(tree, "Math", elevation, operation="SINE"))


def sun_direction(settings):
    """Returns the unit vector towards the sun."""
    elevation, turn = settings["sun_elevation"], settings["sun_rotation"]
    flat = math.cos(elevation)
    return flat * math.sin(turn), flat * math.cos(turn), math.sin(elevation)


def disc_irradiance(settings):
    """Returns (3,): the light of the sun's disc on a surface that faces it, W/m^2: of a picture of the disc
    in the world, less the same without it. (A Sky Texture on a surface has no disc.)"""
    reach = math.tan(1.1 * settings["sun_size"] / 2)
    with_disc, without = (world_picture(settings | {"sun_disc": disc}, reach) for disc in (True, False))
    side = (np.arange(DISC_PIXELS) + 0.5) * 2 / DISC_PIXELS - 1
    slope = 1 + reach**2 * (side**2 + side[:, None] ** 2)
    weight = (2 * reach / DISC_PIXELS) ** 2 / slope**2  # solid angle of each pixel times its cosine
    return ((with_disc - without) * weight[..., None]).sum((0, 1))


def world_picture(settings, reach):
    """Returns (DISC_PIXELS, DISC_PIXELS, 3): the world around the sun. reach: tangent of half the field of
    view."""
    new_scene()
    scene = bpy.context.scene
    bpy.data.objects.remove(bpy.data.objects["Plane"])
    scene.world = with_nodes(bpy.data.worlds.new("World"))
    tree = scene.world.node_tree
    tree.nodes.clear()
    background = add(tree, "Background", add(tree, "TexSky", **settings))
    output = tree.nodes.new("ShaderNodeOutputWorld")
    tree.links.new(background, output.inputs["Surface"])
    camera = scene.camera
    camera.data.type, camera.data.angle = "PERSP", 2 * math.atan(reach)
    camera.rotation_euler = Vector(sun_direction(settings)).to_track_quat("-Z", "Y").to_euler()
    return rendered(DISC_PIXELS, DISC_PIXELS)


def main(request, result):
    settings = json.loads(Path(request).read_text())
    sky = picture(settings | {"sun_disc": False}, WIDTH, WIDTH // 2, around)
    sun = disc_irradiance(settings) if settings["sun_disc"] else np.zeros(3, np.float32)
    np.savez(result, sky=sky, sun=sun)


if __name__ == "__main__":
    main(*sys.argv[-2:])
