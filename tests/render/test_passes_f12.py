# SPDX-License-Identifier: GPL-3.0-or-later
"""Passes in Blender: those that Blender's and Cycles' own toggles ask for, cryptomattes with their manifests,
and a compositor made for Cycles that runs on ours."""

import json

import numpy as np
import OpenEXR
import pytest
from nephele import denoising

SIZE = 32


@pytest.fixture
def scene(bpy, camera, link):
    """Returns the scene: a red glowing plane in the left half of the picture, 5 m below the camera, whose
    parent is Root, and a green one in the right half, 1 m nearer."""
    scene = bpy.context.scene
    for name, x, z, color in (("Left", -2, 0.0, (1, 0, 0, 1)), ("Right", 2, 1.0, (0, 1, 0, 1))):
        mesh = bpy.data.meshes.new(name)
        corners = [(-2, -9, 0), (2, -9, 0), (2, 9, 0), (-2, 9, 0)]
        mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
        item = link(name, mesh)
        item.location = (x, 0, z)
        item.pass_index = 3 if name == "Left" else 4
        material = bpy.data.materials.new(f"{name} light")
        material.use_nodes = True
        material.pass_index = 7
        tree = material.node_tree
        tree.nodes.clear()
        light, end = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
        light.inputs["Color"].default_value = color
        tree.links.new(light.outputs[0], end.inputs["Surface"])
        mesh.materials.append(material)
    root = link("Root", None)
    bpy.data.objects["Left"].parent = root
    render = scene.render
    render.engine = "NEPHELE"
    render.resolution_x = render.resolution_y = SIZE
    render.resolution_percentage = 100
    render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    scene.nephele.samples = 8
    scene.nephele.pixel_filter = "box"
    scene.world = bpy.data.worlds.new("World")
    scene.world.mist_settings.start, scene.world.mist_settings.depth = 2.0, 6.0
    scene.world.mist_settings.falloff = "LINEAR"
    return scene


def render(bpy, path):
    """Renders to a file. Returns (channel name -> (height, width), header)."""
    bpy.context.scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: c.pixels for part in file.parts for name, c in part.channels.items()}
        return channels, {key: value for part in file.parts for key, value in part.header.items()}


def test_toggles_of_blender_and_cycles_ask_for_passes(bpy, scene, tmp_path):
    layer = bpy.context.view_layer
    data = ("z", "mist", "position", "normal", "uv", "object_index", "material_index")
    for name in (*data, "emit", "environment"):
        setattr(layer, f"use_pass_{name}", True)
    for kind in ("diffuse", "glossy", "transmission"):
        for part in ("direct", "indirect", "color"):
            setattr(layer, f"use_pass_{kind}_{part}", True)
    layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True
    layer.cycles.denoising_store_passes = True
    channels, _ = render(bpy, tmp_path / "passes.exr")
    ours = {name.removeprefix("ViewLayer.").rpartition(".")[0] for name in channels}

    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = 1, "CPU", False
    theirs, _ = render(bpy, tmp_path / "cycles.exr")
    assert ours == {name.removeprefix("ViewLayer.").rpartition(".")[0] for name in theirs}
    assert set(channels) == set(theirs)  # the letters of the channels, too

    left = {name: image[:, 4] for name, image in channels.items()}
    assert np.allclose(left["ViewLayer.Depth.Z"], 5)
    assert np.allclose(left["ViewLayer.Position.Z"], 0, atol=1e-5)
    assert np.all(left["ViewLayer.Object Index.X"] == 3) and np.all(left["ViewLayer.Material Index.X"] == 7)
    assert np.all(channels["ViewLayer.Object Index.X"][:, -4] == 4)
    assert np.allclose(left["ViewLayer.Emission.R"], 1)
    middle = channels["ViewLayer.Mist.Z"][SIZE // 2, SIZE // 2 - 1]
    assert middle == pytest.approx((5 - 2) / 6, abs=2e-3)


def test_cryptomattes_are_named_and_cover(bpy, scene, tmp_path):
    layer = bpy.context.view_layer
    layer.use_pass_cryptomatte_object = layer.use_pass_cryptomatte_material = True
    layer.use_pass_cryptomatte_asset = True
    layer.pass_cryptomatte_depth = 2
    channels, header = render(bpy, tmp_path / "mattes.exr")
    assert not any("CryptoObject01" in name for name in channels)
    entries = {header[key]: key.removesuffix("/name") for key in header if key.endswith("/name")}
    expected = {
        "CryptoObject": {"Left", "Right"},
        "CryptoMaterial": {"Left light", "Right light"},
        "CryptoAsset": {"Root", "Right"},
    }
    for kind, names in expected.items():
        prefix = entries[f"ViewLayer.{kind}"]
        assert header[f"{prefix}/hash"] == "MurmurHash3_32"
        assert header[f"{prefix}/conversion"] == "uint32_to_float32"
        manifest = json.loads(header[f"{prefix}/manifest"])
        assert set(manifest) == names
        first = next(iter(names - {"Right", "Right light"}))
        ids = channels[f"ViewLayer.{kind}00.r"].view(np.uint32)[:, :8]
        assert np.all(ids == int(manifest[first], 16)) and np.all(
            channels[f"ViewLayer.{kind}00.g"][:, :8] == 1
        )


def compositor(bpy, layer):
    """Makes a graph as people make it for Cycles: matte of Left over depth, mist and the denoised picture.
    Returns its tree."""
    scene = bpy.context.scene
    tree = bpy.data.node_groups.new("Compositor", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    scene.compositing_node_group = tree
    nodes, connect = tree.nodes, tree.links.new
    layers, out = nodes.new("CompositorNodeRLayers"), nodes.new("NodeGroupOutput")
    matte = nodes.new("CompositorNodeCryptomatteV2")
    matte.layer_name = f"{layer.name}.CryptoObject"
    matte.matte_id = "Left"
    denoise = nodes.new("CompositorNodeDenoise")
    connect(layers.outputs["Noisy Image"], denoise.inputs["Image"])
    connect(layers.outputs["Denoising Albedo"], denoise.inputs["Albedo"])
    connect(layers.outputs["Denoising Normal"], denoise.inputs["Normal"])
    join = nodes.new("CompositorNodeCombineColor")
    connect(matte.outputs["Matte"], join.inputs[0])
    connect(layers.outputs["Mist"], join.inputs[1])
    split = nodes.new("CompositorNodeSeparateColor")
    connect(denoise.outputs["Image"], split.inputs[0])
    connect(split.outputs[0], join.inputs[2])
    connect(layers.outputs["Depth"], join.inputs[3])
    connect(join.outputs[0], out.inputs[0])
    return tree


def test_a_compositor_made_for_cycles_runs_on_ours(bpy, scene, tmp_path):
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_mist = layer.use_pass_cryptomatte_object = True
    layer.cycles.denoising_store_passes = True
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = 8, "CPU", True
    scene.cycles.pixel_filter_type = "BOX"
    layer.update_render_passes()
    compositor(bpy, layer)
    scene.render.use_compositing = True
    made = tmp_path / "made_for_cycles.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(made))
    results = {}
    for engine in ("CYCLES", "NEPHELE"):
        bpy.ops.wm.open_mainfile(filepath=str(made))
        opened = bpy.context.scene
        opened.render.engine = engine
        opened.nephele.denoise = True
        bpy.context.view_layer.update_render_passes()
        channels, _ = render(bpy, tmp_path / f"{engine}.exr")
        assert {"ViewLayer.Noisy Image.R", "ViewLayer.Denoising Albedo.R"} <= set(channels)
        results[engine] = np.stack([channels[f"Composite.Combined.{c}"] for c in "RGBA"], -1)
    ours, theirs = results["NEPHELE"], results["CYCLES"]
    inner = np.r_[0 : SIZE // 2 - 2, SIZE // 2 + 4 : SIZE]  # beside the seam, where samples see both planes
    data = (0, 1, 3)  # matte, mist, depth
    assert np.all(ours[:, 0, 0] == 1) and np.all(ours[:, -1, 0] == 0)
    assert np.allclose(ours[:, inner][..., data], theirs[:, inner][..., data], atol=5e-3)
    # What the node makes of our passes is what we make of them.
    features = (("Noisy Image", "RGB"), ("Denoising Albedo", "RGB"), ("Denoising Normal", "XYZ"))
    images = [
        np.stack([channels[f"ViewLayer.{n}.{c}"][::-1] for c in letters], -1) for n, letters in features
    ]
    assert np.allclose(ours[..., 2], denoising.denoise(*images)[::-1, :, 0], atol=1e-3)


def test_denoising_keeps_the_noisy_image(bpy, scene, tmp_path):
    scene.nephele.denoise = True
    scene.nephele.pixel_filter = "blackman_harris"  # the seam between the planes is noisy
    channels, _ = render(bpy, tmp_path / "clean.exr")
    scene.nephele.denoise = False
    plain, _ = render(bpy, tmp_path / "noisy.exr")
    noisy = plain["ViewLayer.Combined.R"]
    assert np.array_equal(channels["ViewLayer.Noisy Image.R"], noisy)
    assert not np.array_equal(channels["ViewLayer.Combined.R"], noisy)
    assert "ViewLayer.Noisy Image.R" not in plain and "ViewLayer.Denoising Albedo.R" not in channels
