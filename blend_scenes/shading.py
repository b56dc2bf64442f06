# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials, images and worlds of the bundled scenes, as Blender shader nodes."""

import bpy
import numpy as np


def pack_image(name, pixels, colour_space, file_format="PNG"):
    """Store (H, W, 3) float pixels, bottom row first, inside the .blend as an image datablock."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new(name, width, height, alpha=False, float_buffer=file_format == "OPEN_EXR")
    image.colorspace_settings.name = colour_space
    image.file_format = file_format
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    image.pack()
    return image


def _shader_tree(owner, output_type):
    """Node tree of a material or world with nothing but its output node."""
    owner.node_tree.nodes.clear()
    return owner.node_tree, owner.node_tree.nodes.new(output_type)


def set_inputs(node, **values):
    """Set sockets by name, written with _ for spaces; colours may have three components."""
    for key, value in values.items():
        socket = node.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1.0) if socket.type == "RGBA" else value
    return node


def surface_material(name, node_type="ShaderNodeBsdfPrincipled", **inputs):
    """One shader node on the surface socket; returns (material, shader node)."""
    material = bpy.data.materials.new(name)
    tree, output = _shader_tree(material, "ShaderNodeOutputMaterial")
    shader = set_inputs(tree.nodes.new(node_type), **inputs)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material, shader


def volume_material(name, *shaders):
    """Volume socket fed by one shader (node type, {input: value}) or by the sum of two."""
    material = bpy.data.materials.new(name)
    tree, output = _shader_tree(material, "ShaderNodeOutputMaterial")
    _link_volume(tree, output, shaders)
    return material


def _link_volume(tree, output, shaders):
    nodes = [set_inputs(tree.nodes.new(kind), **inputs) for kind, inputs in shaders]
    last = nodes[0]
    for node in nodes[1:]:
        both = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(last.outputs[0], both.inputs[0])
        tree.links.new(node.outputs[0], both.inputs[1])
        last = both
    tree.links.new(last.outputs[0], output.inputs["Volume"])


def textured(material, shader, image, socket="Base Color", interpolation="Linear"):
    """Feed a shader's colour socket from an image through the active UV map."""
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image, node.interpolation = image, interpolation
    material.node_tree.links.new(node.outputs["Color"], shader.inputs[socket])
    return material


def set_world(colour=(0, 0, 0), strength=1.0, image=None, volume=()):
    """Constant or image-lit background (latitude-longitude), plus optional volume shaders."""
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = world
    tree, output = _shader_tree(world, "ShaderNodeOutputWorld")
    background = set_inputs(tree.nodes.new("ShaderNodeBackground"), Color=colour, Strength=strength)
    tree.links.new(background.outputs[0], output.inputs["Surface"])
    if image is not None:
        node = tree.nodes.new("ShaderNodeTexEnvironment")
        node.image = image
        tree.links.new(node.outputs["Color"], background.inputs["Color"])
    if volume:
        _link_volume(tree, output, volume)
    return world


def lat_long_directions(height):
    """World directions (height, 2 * height, 3) of an environment image's pixel centres, bottom row first.

    Blender's convention: u = 1/2 - azimuth / 2 pi, v = 1/2 + elevation / pi, the azimuth counted from +x
    towards +y; the image's centre looks along +x.
    """
    u = (np.arange(2 * height) + 0.5) / (2 * height)
    v = (np.arange(height) + 0.5) / height
    elevation, azimuth = np.meshgrid(np.pi * (v - 0.5), 2 * np.pi * (0.5 - u), indexing="ij")
    flat = np.cos(elevation)
    return np.stack([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)], axis=-1)


def set_sky(name, zenith, horizon, ground, glow=(0, 0, 0), towards=(1, 0, 0), sharpness=6.0, haze=6.0):
    """World of radiances that go from `horizon` to `zenith` with height, `haze` times an e-fold, with a glow
    towards a direction; `ground` below. Packed as a small image."""
    directions = lat_long_directions(32)
    up = directions[..., 2:3]
    sky = np.array(zenith) + (np.array(horizon) - np.array(zenith)) * np.exp(-haze * np.maximum(up, 0))
    away = 1 - directions @ np.asarray(towards)
    sky = sky + np.array(glow) * np.exp(-sharpness * away)[..., None]
    sky = np.where(up < -0.02, np.array(ground), sky)
    return set_world(image=pack_image(name, sky, "Linear Rec.709", "OPEN_EXR"))
