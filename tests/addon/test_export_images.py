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
OPAQUE = np.where(np.arange(4) == 3, 1.0, PIXELS)


@pytest.mark.parametrize(("space", "srgb"), [("sRGB", True), ("Non-Color", False)])
def test_byte_image(bpy, tree, space, srgb):
    material, _ = compile_with(tree, make_image(bpy, OPAQUE, space=space))
    (image,) = images_of(tree, material)
    assert (image.pixels.dtype, image.srgb) == (np.uint8, srgb)
    assert np.array_equal(image.pixels, np.rint(OPAQUE * 255))  # bottom row first, as in Blender
    assert tree.warnings == []


PREMULTIPLIED = np.array([[[0.5, 0.25, 0.0, 0.5], [4.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 0.0]]])
STRAIGHT = [[1.0, 0.5, 0.0, 0.5], [4, 0, 0, 1], [0, 0, 0, 0]]


@pytest.mark.parametrize("reads_alpha", [False, True])
def test_float_image_is_linear_and_straight_where_alpha_is_read(bpy, tree, reads_alpha):
    image = make_image(bpy, PREMULTIPLIED, is_float=True, space="Linear Rec.709")
    node = tree.node("ShaderNodeTexImage", image=image)
    if reads_alpha:
        tree.node("ShaderNodeMath", {0: node.outputs["Alpha"]})
    tree.link(node.outputs["Color"], tree.emission.inputs["Color"])
    (image,) = images_of(tree, tree.compile())
    assert (image.pixels.dtype, image.srgb) == (np.float32, False)
    assert np.allclose(image.pixels[0], STRAIGHT if reads_alpha else PREMULTIPLIED[0])


def test_bytes_are_multiplied_by_alpha_where_no_node_reads_it(bpy, tree):
    pixels = np.array([[[1.0, 0.5, 0.0, 0.5]]])
    material, _ = compile_with(tree, make_image(bpy, pixels))
    assert images_of(tree, material)[0].pixels[0, 0].tolist() == [128, 64, 0, 128]
    bpy.data.images["Picture"].alpha_mode = "CHANNEL_PACKED"
    assert images_of(tree, tree.compile())[0].pixels[0, 0].tolist() == [255, 128, 0, 128]


def test_colour_spaces_are_converted_by_blender(bpy, tree):
    material, _ = compile_with(tree, make_image(bpy, OPAQUE, space="Linear Rec.2020"))
    (image,) = images_of(tree, material)
    rec709_from_rec2020 = np.array(
        ((1.6605, -0.5876, -0.0728), (-0.1246, 1.1329, -0.0083), (-0.0182, -0.1006, 1.1187))
    )
    expected = np.rint(OPAQUE[..., :3] * 255) / 255 @ rec709_from_rec2020.T
    assert np.allclose(image.pixels[..., :3], expected, atol=1e-4)
    assert tree.warnings == []


def test_sequence_reads_the_file_of_the_frame(bpy, tree, tmp_path):
    for number in (3, 4, 5):
        image = make_image(bpy, np.full((1, 1, 4), number / 5), space="Non-Color")
        image.filepath_raw, image.file_format = str(tmp_path / f"shot_{number:04d}.png"), "PNG"
        image.save()
    image = bpy.data.images.load(str(tmp_path / "shot_0003.png"))
    image.source, image.colorspace_settings.name, image.alpha_mode = "SEQUENCE", "Non-Color", "NONE"
    node = tree.node("ShaderNodeTexImage", image=image)
    user = node.image_user
    user.frame_duration, user.frame_start, user.frame_offset = 3, 10, 2
    tree.link(node.outputs["Color"], tree.emission.inputs["Color"])
    for frame, shown in ((1, 3), (10, 3), (11, 4), (30, 5)):
        bpy.context.scene.frame_set(frame)
        assert images_of(tree, tree.compile())[0].pixels[0, 0, 0] == 51 * shown, frame
        assert tree.warnings == []
    user.use_cyclic = True
    bpy.context.scene.frame_set(14)
    assert images_of(tree, tree.compile())[0].pixels[0, 0, 0] == 51 * 4


@pytest.mark.parametrize("packed", [False, True])
def test_udim_tiles(bpy, tree, tmp_path, packed):
    for number in (1001, 1012):
        tile = make_image(bpy, np.full((1, 1, 4), number / 2000), space="Non-Color")
        tile.filepath_raw, tile.file_format = str(tmp_path / f"skin.{number}.png"), "PNG"
        tile.save()
    image = bpy.data.images.load(str(tmp_path / "skin.1001.png"))
    image.source, image.filepath, image.colorspace_settings.name = (
        "TILED",
        str(tmp_path / "skin.<UDIM>.png"),
        "Non-Color",
    )
    if [tile.number for tile in image.tiles] == [1001]:
        image.tiles.new(1012)
    image.alpha_mode = "NONE"
    if packed:
        image.pack()
        for path in tmp_path.iterdir():
            path.unlink()
    material, _ = compile_with(tree, image)
    assert [i.pixels[0, 0, 0] for i in images_of(tree, material)] == [
        round(255 * n / 2000) for n in (1001, 1012)
    ]
    assert tree.warnings == []


def test_image_is_shared(bpy, tree):
    image = make_image(bpy, PIXELS)
    nodes = [tree.node("ShaderNodeTexImage", image=image) for _ in range(2)]
    mix = tree.node("ShaderNodeMix", data_type="RGBA")
    tree.link(nodes[0].outputs["Color"], mix.inputs[6])
    tree.link(nodes[1].outputs["Alpha"], mix.inputs[7])
    tree.link(mix.outputs[2], tree.emission.inputs["Color"])
    material = tree.compile()
    assert len(images_of(tree, material)) == 2  # as it is for alpha, multiplied by it for colour
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
    assert row[7] == (interpolation == "Closest") + 4 * number
    assert material.surface.parameters[row[6]] == 0
    assert tree.warnings == []


def test_packed_image(bpy, tree):
    image = make_image(bpy, OPAQUE)
    image.pack()
    material, _ = compile_with(tree, image)
    assert np.array_equal(images_of(tree, material)[0].pixels, np.rint(OPAQUE * 255))


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
    row = tree.compile().surface.code[-1]
    assert (NAMES[row[0]], row[7]) == ("noise", 1 | 0 << 1 | 1 << 2 | 3 << 4)
    assert tree.warnings == []
