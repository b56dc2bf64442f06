# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures of tiles side by side, a case each: the camera that looks down on them, and both renderers'
pictures of one sample at every pixel's middle, which have no noise."""

import math
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from bench import cycles, ours

MIDDLE = 0.01  # width of a pixel filter that leaves samples where they are


def look_down(bpy, scene, columns):
    """Gives the scene a camera that sees `columns` tiles of 2 m from side to side, and nothing else."""
    camera = bpy.data.cameras.new("Camera")
    height = 60.0
    camera.sensor_fit = "HORIZONTAL"
    camera.angle = 2 * math.atan(columns / height)
    camera.clip_end = 1000
    holder = bpy.data.objects.new("Camera", camera)
    holder.location = (0, 0, height)
    scene.collection.objects.link(holder)
    scene.camera = holder


def both(bpy, folder, build, pixels, **settings):
    """Returns (our image, Cycles' image, columns) of the tiles that build(bpy) makes in an empty file; it
    returns their (columns, rows). pixels: of a tile. settings: of ours."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    columns, rows = build(bpy)
    path, size = folder / "tiles.blend", (columns * pixels, rows * pixels)
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    job = cycles.Job(str(path), size, 1, (1,), 0, pixel_filter="GAUSSIAN", filter_width=MIDDLE)
    theirs = cycles.render(job).passes["Combined"][0]
    scene = ours.export(path, folder, size)
    assert scene.warnings == ()
    settings = {"samples": 1, "pixel_filter": "gaussian", "filter_width": MIDDLE} | settings
    images, _ = ours.render(scene, (1,), threads=2, **settings)
    return images["Combined"][0], theirs, columns
