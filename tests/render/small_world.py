# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene in which every feature of the kernel takes part."""

from nephele import description as d
from truth import ROUGH_BALL, Scene, box, diffuse, emission, facing, half_world, perspective, placed, sphere


def small_world():
    """Grid, mesh medium, surfaces, lamps and sky: every kernel feature takes part."""
    sky = half_world((0.3, 0.5, 1.0), 0.1)
    lamp = d.Light("lamp", "area", facing((1, -1, 2), (0, 0, 0)), (50.0, 40.0, 30.0))
    scene = Scene(perspective((0, -4, 0.5), (0, 0, 0), 0.4), sky, lights=(lamp,))
    scene.add_volume(
        ROUGH_BALL,
        d.VolumeClosure((2, 3, 4), (0.5, 0.2, 0.1), (0.1, 0, 0.2), d.Phase(a=0.5), density_grid="density"),
    )
    scene.add(box((-3, -3, -1.4), (3, 3, -1)), diffuse((0.8, 0.6, 0.4)))
    scene.add(sphere(0.3, 2), emission((3.0, 2.0, 1.0)), (), placed(-1, -0.6, -0.3))
    return scene.add(
        box((0, -1, -1), (1.2, 1, 0.4)), None, (d.VolumeClosure((0.3, 0.2, 0.1), phase=d.Phase(a=-0.3)),)
    )
