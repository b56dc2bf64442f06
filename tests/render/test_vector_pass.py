# SPDX-License-Identifier: GPL-3.0-or-later
"""The pass Vector against Cycles' own: a moving camera, a moving, a turning and a deforming object."""

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from test_passes_f12 import SIZE, render, scene

__all__ = ["scene"]  # a fixture


def animate(item, path, values):
    """Keys a property at frames 1 and 3, linear in between."""
    for frame, value in zip((1, 3), values, strict=True):
        setattr(item, path, value)
        item.keyframe_insert(path, frame=frame)
    action = item.id_data.animation_data.action
    for curve in action.layers[0].strips[0].channelbags[0].fcurves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def test_vectors_are_those_of_cycles(bpy, camera, scene, tmp_path):
    left, right = bpy.data.objects["Left"], bpy.data.objects["Right"]
    animate(right, "location", ((2, 0, 1), (2.4, 0.6, 1)))
    animate(camera, "rotation_euler", ((0, 0, 0), (0.05, 0, 0.1)))
    left.shape_key_add(name="Basis")
    key = left.shape_key_add(name="Bent")
    for point in key.data:
        point.co.z += 0.4 * point.co.y
        point.co.x *= 1.2
    animate(key, "value", (0.0, 1.0))
    bpy.context.scene.frame_set(2)
    layer = bpy.context.view_layer
    layer.use_pass_vector = layer.use_pass_object_index = True
    scene.cycles.samples, scene.cycles.device, scene.cycles.use_denoising = 8, "CPU", False
    scene.cycles.pixel_filter_type = "BOX"
    images = {}
    for engine in ("NEPHELE", "CYCLES"):
        scene.render.engine = engine
        channels, _ = render(bpy, tmp_path / f"{engine}.exr")
        images[engine] = np.stack([channels[f"ViewLayer.Vector.{c}"] for c in "XYZW"], -1)
        index = channels["ViewLayer.Object Index.X"]
    ours, theirs = images["NEPHELE"], images["CYCLES"]
    # Not at silhouettes; elsewhere a pixel's samples see no more than what its neighbours show.
    inner = minimum_filter(index, 3) == maximum_filter(index, 3)
    inner[[0, -1]] = inner[:, [0, -1]] = False
    inner &= index > 0
    assert inner.mean() > 0.5
    assert np.abs(theirs[inner]).mean() > 0.3
    low, high = (
        f(theirs, (3, 3, 1)) - 1e-3 * sign for f, sign in ((minimum_filter, 1), (maximum_filter, -1))
    )
    assert np.all((ours >= low)[inner]) and np.all((ours <= high)[inner])


def test_with_motion_blur_there_is_none(bpy, scene, tmp_path):
    bpy.context.view_layer.use_pass_vector = scene.render.use_motion_blur = True
    channels, _ = render(bpy, tmp_path / "blurred.exr")
    assert not channels["ViewLayer.Vector.X"].any()


def test_vectors_are_pixels_of_the_whole_frame(bpy, scene, tmp_path):
    """Whatever part of the frame is rendered."""
    right = bpy.data.objects["Right"]
    animate(right, "location", ((1.8, 0, 1), (2.2, 0, 1)))
    bpy.context.scene.frame_set(2)
    bpy.context.view_layer.use_pass_vector = True
    render_settings = scene.render
    render_settings.use_border = render_settings.use_crop_to_border = True
    render_settings.border_min_x, render_settings.border_max_x = 0.75, 1.0
    channels, _ = render(bpy, tmp_path / "part.exr")
    width = 2 * 4 * np.tan(bpy.data.cameras[0].angle / 2)  # m of the picture at the plane's distance
    assert np.allclose(channels["ViewLayer.Vector.X"], -0.2 / width * SIZE, rtol=1e-3)
    assert np.allclose(channels["ViewLayer.Vector.Z"], -0.2 / width * SIZE, rtol=1e-3)
