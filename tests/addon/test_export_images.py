# SPDX-License-Identifier: GPL-3.0-or-later
"""Image textures: pixels, colour spaces, what cannot be read, and the modes of the lookup."""

import numpy as np
import pytest
from nephele import description
from nephele.export import needs
from programs import NAMES, Tree, with_nodes


@pytest.fixture
def tree(bpy):
    return Tree(bpy)


def make_image(bpy, pixels, is_float=False, space="sRGB"):
    """Returns a generated image of (h, w, 4) pixels."""
    height, width, _ = pixels.shape
    image = bpy.data.images.new("Picture", width, height, alpha=True, float_buffer=is_float)
    image.colorspace_settings.name = space
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    return image


def compile_with(tree, image, **properties):
    """Returns (material, the image texture's instruction) of a material coloured by `image`."""
    node = tree.node("ShaderNodeTexImage", image=image, **properties)
    tree.link(node.outputs["Color"], tree.emission.inputs["Color"])
    material = tree.compile()
    row = next(
        row for row in material.surface.code.tolist() if NAMES[row[0]].startswith(("image", "environment"))
    )
    return material, row


def images_of(tree, material):
    """Returns the images that a material reads."""
    return tree.context.read_images(needs.images_read((material,), description.World()))


PIXELS = np.arange(24).reshape(2, 3, 4) / 255.0


@pytest.mark.parametrize(("space", "srgb"), [("sRGB", True), ("Non-Color", False)])
def test_byte_image(bpy, tree, space, srgb):
    material, _ = compile_with(tree, make_image(bpy, PIXELS, space=space))
    (image,) = images_of(tree, material)
    assert (image.pixels.dtype, image.srgb) == (np.uint8, srgb)
    assert np.array_equal(image.pixels, np.arange(24).reshape(2, 3, 4))  # bottom row first, as in Blender
    assert tree.warnings == []


def test_float_image_is_linear_with_straight_alpha(bpy, tree):
    premultiplied = np.array([[[0.5, 0.25, 0.0, 0.5], [4.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0]]])
    material, _ = compile_with(tree, make_image(bpy, premultiplied, is_float=True, space="Non-Color"))
    (image,) = images_of(tree, material)
    assert (image.pixels.dtype, image.srgb) == (np.float32, False)
    assert np.allclose(image.pixels[0], [[1.0, 0.5, 0.0, 0.5], [4, 0, 0, 1], [0, 0, 0, 0]])


def test_image_is_shared(bpy, tree):
    image = make_image(bpy, PIXELS)
    nodes = [tree.node("ShaderNodeTexImage", image=image) for _ in range(2)]
    mix = tree.node("ShaderNodeMix", data_type="RGBA")
    tree.link(nodes[0].outputs["Color"], mix.inputs[6])
    tree.link(nodes[1].outputs["Alpha"], mix.inputs[7])
    tree.link(mix.outputs[2], tree.emission.inputs["Color"])
    material = tree.compile()
    assert len(images_of(tree, material)) == 1
    assert [NAMES[row[0]] for row in material.surface.code.tolist()].count("uv") == 1


def test_missing_file_is_magenta_and_warns(bpy, tree):
    image = bpy.data.images.new("Lost", 4, 4)
    image.source, image.filepath = "FILE", "/nowhere/lost.png"
    material, _ = compile_with(tree, image)
    assert np.allclose(images_of(tree, material)[0].pixels, (1, 0, 1, 1))
    (warning,) = tree.warnings
    assert "node 'Image Texture': image 'Lost' (/nowhere/lost.png) cannot be read" in warning


def test_no_image_is_magenta_and_warns(tree):
    assert tuple(tree.color(tree.node("ShaderNodeTexImage").outputs["Color"])) == (1.0, 0.0, 1.0)
    assert any("has no image" in text for text in tree.warnings)


@pytest.mark.parametrize("interpolation", ["Linear", "Closest"])
@pytest.mark.parametrize(("extension", "number"), [("REPEAT", 0), ("EXTEND", 1), ("CLIP", 2), ("MIRROR", 3)])
def test_lookup_modes(bpy, tree, interpolation, extension, number):
    image = make_image(bpy, PIXELS)
    material, row = compile_with(tree, image, interpolation=interpolation, extension=extension)
    assert row[7] == (interpolation == "Closest") + 2 * number
    assert material.surface.parameters[row[6]] == 0
    assert tree.warnings == []


@pytest.mark.parametrize("properties", [{"projection": "BOX"}, {"interpolation": "Cubic"}])
def test_lookups_that_we_lack_warn(bpy, tree, properties):
    compile_with(tree, make_image(bpy, PIXELS), **properties)
    assert len(tree.warnings) == 1


def test_packed_image(bpy, tree):
    image = make_image(bpy, PIXELS)
    image.pack()
    material, _ = compile_with(tree, image)
    assert np.array_equal(images_of(tree, material)[0].pixels, np.arange(24).reshape(2, 3, 4))


def test_environment_in_the_world(bpy, export):
    world = bpy.context.scene.world = with_nodes(bpy.data.worlds.new("World"))
    nodes = world.node_tree
    node = nodes.nodes.new("ShaderNodeTexEnvironment")
    node.image, node.projection = make_image(bpy, PIXELS), "MIRROR_BALL"
    nodes.links.new(node.outputs[0], nodes.nodes["Background"].inputs["Color"])
    scene = export()
    assert [NAMES[row[0]] for row in scene.world.background.code.tolist()] == [
        "generated",
        "environment_mirror_ball",
    ]
    assert len(scene.images) == 1


def test_noise_modes(tree):
    node = tree.node("ShaderNodeTexNoise", noise_dimensions="2D", normalize=False)
    tree.link(node.outputs["Color"], tree.emission.inputs["Color"])
    row = tree.compile().surface.code[-1]
    assert (NAMES[row[0]], row[7]) == ("noise", 1 | 0 << 1 | 1 << 2)
    node.noise_type = "RIDGED_MULTIFRACTAL"
    tree.compile()
    assert any("fBM is used" in text for text in tree.warnings)
