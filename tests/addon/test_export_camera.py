# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera and film: Blender's lens, sensor and frame rules in closed form."""

import numpy as np
import pytest
from nephele.export import ExportError
from programs import with_nodes


def expected_viewplane(data, width, height, aspect):
    """The viewplane by Blender's rules, written out: sensor fit, shift in units of the fitted side, pixel
    aspect."""
    wide, high = width * aspect[0], height * aspect[1]
    horizontal = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and wide >= high)
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    side = data.ortho_scale if data.type == "ORTHO" else sensor / data.lens
    per_unit = side / (wide if horizontal else high)
    x, y = data.shift_x * side, data.shift_y * side
    return (
        x - wide * per_unit / 2,
        x + wide * per_unit / 2,
        y - high * per_unit / 2,
        y + high * per_unit / 2,
    )


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("size", [(192, 108), (90, 160)])
@pytest.mark.parametrize("aspect", [(1.0, 1.0), (2.0, 1.0), (1.0, 1.5)])
def test_viewplane(bpy, camera, export, kind, fit, size, aspect):
    data, render = camera.data, bpy.context.scene.render
    data.type, data.sensor_fit, data.ortho_scale, data.lens = kind, fit, 7.0, 35.0
    data.sensor_width, data.sensor_height, data.shift_x, data.shift_y = 36.0, 20.0, 0.2, -0.1
    render.resolution_x, render.resolution_y = size
    render.pixel_aspect_x, render.pixel_aspect_y = aspect
    result = export().camera
    assert result.kind == {"PERSP": "perspective", "ORTHO": "orthographic"}[kind]
    assert result.viewplane == pytest.approx(expected_viewplane(data, *size, aspect), rel=1e-5, abs=1e-5)


def test_pose_and_clipping(camera, export):
    camera.scale = (2.0, 3.0, 4.0)
    camera.data.clip_start, camera.data.clip_end = 0.25, 75.0
    result = export().camera
    assert np.allclose(result.world_from_camera[:3, :3], np.eye(3), atol=1e-6)  # scale is taken out
    assert np.allclose(result.world_from_camera[:3, 3], (0, 0, 5))
    assert (result.clip_start, result.clip_end) == (0.25, 75.0)
    assert result.aperture_radius == 0.0


def test_depth_of_field(bpy, camera, export, link):
    target = link("Target", None)
    target.location = (3.0, 1.0, 1.5)
    dof = camera.data.dof
    dof.use_dof, dof.aperture_fstop, dof.aperture_blades = True, 2.0, 6
    dof.aperture_rotation, dof.aperture_ratio, dof.focus_distance = 0.3, 1.5, 12.0
    camera.data.lens = 50.0
    result = export().camera
    assert result.aperture_radius == pytest.approx(0.05 / 4)
    assert (result.blades, result.focus_distance) == (6, 12.0)
    assert (result.blades_rotation, result.aperture_ratio) == pytest.approx((0.3, 1.5))
    dof.focus_object = target
    assert export().camera.focus_distance == pytest.approx(3.5)  # along the axis, not the distance
    camera.data.type = "PANO"
    assert export().camera.focus_distance == pytest.approx(np.linalg.norm((3.0, 1.0, 3.5)))


def test_no_blades_are_a_circle(camera, export):
    camera.data.dof.use_dof = True
    assert export().camera.blades == 0


@pytest.mark.parametrize(
    ("kind", "lens", "values"),
    [
        ("EQUIRECTANGULAR", "equirectangular", (-3.0, 2.0, -1.0, 0.5)),
        ("FISHEYE_EQUIDISTANT", "fisheye_equidistant", (2.5,)),
        ("FISHEYE_EQUISOLID", "fisheye_equisolid", (2.5, 9.0, 36.0, 18.0)),
        ("MIRRORBALL", "mirror_ball", ()),
    ],
)
def test_panorama(bpy, camera, export, kind, lens, values):
    data, render = camera.data, bpy.context.scene.render
    render.resolution_x, render.resolution_y = 200, 100
    data.type = "PANO"
    data.panorama_type, data.fisheye_fov, data.fisheye_lens, data.sensor_width = kind, 2.5, 9.0, 36.0
    data.longitude_min, data.longitude_max, data.latitude_min, data.latitude_max = -3.0, 2.0, -1.0, 0.5
    data.shift_x = 0.25
    result = export().camera
    assert (result.kind, result.lens) == ("panoramic", lens)
    assert result.lens_values == pytest.approx(values)
    assert result.viewplane == (0.25, 1.25, 0.0, 1.0)


def test_an_own_lens_is_an_error(camera, export):
    camera.data.type = "CUSTOM"
    with pytest.raises(ExportError, match=r"unsupported camera: 'Camera'.*Perspective"):
        export()


def test_no_camera_is_an_error(bpy, export):
    bpy.context.scene.camera = None
    with pytest.raises(ExportError, match="has no camera"):
        export()


@pytest.mark.parametrize(("size", "percent", "expected"), [((1921, 7), 50, (960, 3)), ((10, 10), 1, (1, 1))])
def test_resolution_rounds_down(bpy, export, size, percent, expected):
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = size
    render.resolution_percentage = percent
    film = export().film
    assert (film.width, film.height, film.crop) == (*expected, None)


def test_border_is_rounded_in_single_precision(bpy, export):
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = 10, 10
    render.use_border = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.1, 0.7, 0.25, 0.99
    assert export().film.crop == (1, 2, 7, 9)


def test_empty_border_is_an_error(bpy, export):
    render = bpy.context.scene.render
    render.resolution_x = render.resolution_y = 10
    render.use_border, render.border_min_x, render.border_max_x = True, 0.41, 0.44
    with pytest.raises(ExportError, match="smaller than a pixel"):
        export()


def test_film_properties(bpy, export):
    scene, layer = bpy.context.scene, bpy.context.view_layer
    scene.world = with_nodes(bpy.data.worlds.new("World"))
    mist = scene.world.mist_settings
    mist.start, mist.depth, mist.falloff = 1.5, 40.0, "INVERSE_QUADRATIC"
    scene.render.film_transparent = True
    layer.use_pass_z, layer.nephele.use_pass_volume_albedo, layer.use_pass_combined = True, True, False
    film = export().film
    assert film.transparent
    assert film.mist == (1.5, 40.0, "inverse_quadratic")
    assert film.passes == ("Combined", "Depth", "Volume Albedo")


def test_passes_that_we_lack_are_named(bpy, export):
    bpy.context.view_layer.use_pass_ambient_occlusion = True
    assert any("pass Ambient Occlusion is not supported" in text for text in export().warnings)


@pytest.mark.parametrize(("ours", "mode", "expected"), [(0, "AUTO", 0), (0, "FIXED", 5), (3, "FIXED", 3)])
def test_thread_count(bpy, export, ours, mode, expected):
    scene = bpy.context.scene
    scene.nephele.threads, scene.render.threads_mode, scene.render.threads = ours, mode, 5
    if mode == "AUTO":
        scene.render.threads_mode = "AUTO"
    assert export().settings["threads"] == expected


def test_stereoscopy_is_an_error(bpy, export):
    bpy.context.scene.render.use_multiview = True
    with pytest.raises(ExportError, match="stereoscopy"):
        export()
