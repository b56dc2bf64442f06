# SPDX-License-Identifier: GPL-3.0-or-later
"""F12 through the add-on and the real native module: pictures, passes, borders, errors, files."""

import hashlib
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from nephele import engine

SCENES = Path(__file__).resolve().parents[2] / "blend_scenes"


@pytest.fixture
def scene(bpy):
    """Returns a function that opens a bundled scene, small, for Nephele."""

    def open_scene(name, width=48, height=32, samples=4):
        bpy.ops.wm.open_mainfile(filepath=str(SCENES / name / f"{name}.blend"))
        scene = bpy.context.scene
        scene.render.engine = "NEPHELE"
        scene.render.resolution_x, scene.render.resolution_y = width, height
        scene.render.resolution_percentage = 100
        scene.nephele.samples = samples
        return scene

    yield open_scene
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def render(bpy, path):
    """Renders the current scene to a multilayer EXR. Returns channel name -> (height, width), top row
    first."""
    settings = bpy.context.scene.render
    settings.image_settings.media_type = "MULTI_LAYER_IMAGE"
    settings.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.image_settings.color_depth = "32"
    settings.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    with OpenEXR.File(str(path), separate_channels=True) as file:
        return {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}


def test_f12_renders_the_bundled_cloud(bpy, scene, tmp_path):
    scene("cloud")
    channels = render(bpy, tmp_path / "cloud.exr")
    record = engine.last_render
    assert (record.state, record.message, record.warnings) == ("done", "", [])
    assert record.statistics["nonfinite_samples"] == 0 and record.statistics["samples_done"] == 4
    combined = np.stack([channels[f"ViewLayer.Combined.{c}"] for c in "RGBA"], axis=-1)
    assert combined.shape == (32, 48, 4) and np.isfinite(combined).all()
    sky, ground = combined[:4, :8, :3].mean(axis=(0, 1)), combined[-4:, :8, :3].mean(axis=(0, 1))
    assert (
        sky[2] > sky[0] and ground[0] > ground[2]
    )  # blue above, sand below: the picture is the right way up


def test_every_pass_of_the_add_on_arrives(bpy, scene, tmp_path):
    scene("cloud")
    layer = bpy.context.view_layer
    names = [row.name for row in engine.enabled_passes(layer, bpy.context.scene)]
    toggles = [p for p in layer.nephele.bl_rna.properties.keys() if p.startswith("use_pass_")]  # noqa: SIM118
    for toggle in toggles:
        setattr(layer.nephele, toggle, True)
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_mist = True
    names = [row.name for row in engine.enabled_passes(layer, bpy.context.scene)]
    assert {"Volume", "Surface", "Transmittance", "Variance", "Sample Count", "Cost", "Depth", "Mist"} < set(
        names
    )
    channels = render(bpy, tmp_path / "passes.exr")
    for row in engine.enabled_passes(layer, bpy.context.scene):
        for channel in row.channels:
            assert f"ViewLayer.{row.name}.{channel}" in channels
    for c in "RGB":
        total = channels[f"ViewLayer.Volume.{c}"] + channels[f"ViewLayer.Surface.{c}"]
        np.testing.assert_allclose(total, channels[f"ViewLayer.Combined.{c}"], rtol=1e-5, atol=1e-6)
    assert (channels["ViewLayer.Sample Count.X"] == 4).all()
    assert (channels["ViewLayer.Cost.X"] > 0).any()
    depth = channels["ViewLayer.Majorant Optical Depth.X"]
    assert 10 < depth.max() <= 1e6
    assert bpy.ops.nephele.vsp_view(map="Majorant Optical Depth") == {"FINISHED"}
    view = bpy.data.images["VSP View"]
    assert view.size[0] == 48 and view.size[1] > 32
    # As bright as the map, row by row: the cloud is in the upper half of both.
    lightness = np.array(view.pixels[:]).reshape(view.size[1], 48, 4)[-32:, :, :3].sum(-1)
    assert np.corrcoef(lightness.ravel(), np.log(np.maximum(depth[::-1], 1e-3)).ravel())[0, 1] > 0.9


def test_a_border_is_the_same_part_of_the_full_picture(bpy, scene, tmp_path):
    opened = scene("cloud")
    opened.nephele.train_field = "never"
    opened.nephele.distance_sampling = "delta"  # guiding learns from the pixels that are rendered
    full = render(bpy, tmp_path / "full.exr")["ViewLayer.Combined.R"]
    opened.render.use_border = opened.render.use_crop_to_border = True
    border = opened.render
    border.border_min_x, border.border_max_x, border.border_min_y, border.border_max_y = 0.25, 0.75, 0.5, 1.0
    part = render(bpy, tmp_path / "part.exr")["ViewLayer.Combined.R"]
    np.testing.assert_array_equal(part, full[:16, 12:36])


def test_a_missing_vdb_stops_the_render_and_names_it(bpy, scene, tmp_path):
    scene("furnace")
    volume = next(o for o in bpy.data.objects if o.type == "VOLUME")
    volume.data.filepath = str(tmp_path / "gone.vdb")
    with pytest.raises(RuntimeError, match=r"gone\.vdb"):
        render(bpy, tmp_path / "none.exr")
    assert engine.last_render.state == "failed"


def test_a_corrupt_vdb_stops_the_render_and_names_it(bpy, scene, tmp_path):
    scene("furnace")
    volume = next(o for o in bpy.data.objects if o.type == "VOLUME")
    whole = (SCENES / "furnace" / "furnace.vdb").read_bytes()
    broken = tmp_path / "cut.vdb"
    broken.write_bytes(whole[: len(whole) // 2])
    volume.data.filepath = str(broken)
    with pytest.raises(RuntimeError, match=r"cut\.vdb"):
        render(bpy, tmp_path / "none.exr")


def test_no_camera_is_an_error(bpy, scene, tmp_path):
    opened = scene("furnace")
    opened.camera = None
    with pytest.raises(RuntimeError, match="camera"):
        render(bpy, tmp_path / "none.exr")


def test_an_animation_reads_each_frame_of_a_sequence(bpy, scene, tmp_path):
    opened = scene("smoke", samples=1)
    seen = []
    for frame in (1, 2):
        opened.frame_set(frame)
        picture = render(bpy, tmp_path / f"{frame}.exr")["ViewLayer.Combined.R"]
        seen.append(hashlib.sha256(picture.tobytes()).hexdigest())
        assert Path(engine.last_render.statistics["grids"][0]["path"]).name == f"smoke_000{frame}.vdb"
    assert seen[0] != seen[1]


def test_a_fluid_domain_renders_from_its_cache(bpy, scene, tmp_path):
    opened = scene("fluid")
    for item in bpy.data.objects:
        for modifier in item.modifiers:
            if modifier.type == "FLUID":
                modifier.show_render = modifier.show_viewport = False
    opened.frame_set(opened.frame_start)
    render(bpy, tmp_path / "fluid.exr")
    record = engine.last_render
    assert record.state == "done"
    assert [grid["grid"] for grid in record.statistics["grids"]] == ["density"]
