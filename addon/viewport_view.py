# SPDX-License-Identifier: GPL-3.0-or-later
"""What a region of a 3D view looks at: a description.Camera, and which of the region's pixels are rendered.

Reads Blender's regions by attribute and knows no bpy. Pixels of regions count from the bottom left corner.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from . import description
from .export.space import matrix4, viewplane

PLANAR = {"perspective", "orthographic"}  # cameras whose picture goes on beyond their frame


@dataclass(frozen=True, eq=False)
class View:
    """camera: its viewplane belongs to a film of `size` pixels whose bottom left corner is pixel `origin` of
    the region. crop: (x0, y0, x1, y1), the pixels of that film that are rendered; None: there are none."""

    camera: description.Camera
    origin: tuple
    size: tuple
    crop: tuple | None

    def same(self, other):
        """Tells whether another View, or None, gives the same picture."""
        return other is not None and description.same(self, other)

    @property
    def pixels(self):
        """The number of pixels that are rendered."""
        if self.crop is None:
            return 0
        x0, y0, x1, y1 = self.crop
        return (x1 - x0) * (y1 - y0)


@dataclass(frozen=True)
class CoarseView:
    """A View in pixels of `divider` by `divider`. crop: of a film of width x height such pixels. place:
    (x, y, width, height) in the region's pixels of what is rendered, which covers the view's crop."""

    camera: description.Camera
    width: int
    height: int
    crop: tuple
    place: tuple


def view_of(region, region_data, space, render, camera=None, frame=None):
    """Returns the View of a region of a 3D view.

    region_data: RegionView3D; space: SpaceView3D; render: the scene's RenderSettings. camera: the
    description.Camera of a view through a camera object, None for others; frame: viewplane() of the matrix by
    which Blender draws that camera's frame.
    """
    size = (region.width, region.height)
    window = viewplane(region_data.window_matrix, region_data.is_perspective)
    if camera is None:
        return View(_free_camera(region_data, space, window), (0, 0), size, _view_crop(space, size))
    frame = frame_in(frame, window, size)
    wanted = (0, 0, *size)
    if render.use_border:
        wanted = _intersection(wanted, _part(frame, render))
    if camera.kind in PLANAR:
        return View(replace(camera, viewplane=window), (0, 0), size, wanted)
    x0, y0, x1, y1 = _rounded(frame)
    film = (max(1, x1 - x0), max(1, y1 - y0))
    wanted = None if wanted is None else _intersection(wanted, (x0, y0, x1, y1))
    crop = None if wanted is None else tuple(w - o for w, o in zip(wanted, (x0, y0, x0, y0), strict=True))
    return View(camera, (x0, y0), film, crop)


def coarse(view, divider):
    """Returns the CoarseView of a View that has pixels to render."""
    width, height = (math.ceil(side / divider) for side in view.size)
    left, right, bottom, top = view.camera.viewplane
    right = left + (right - left) * width * divider / view.size[0]
    top = bottom + (top - bottom) * height * divider / view.size[1]
    x0, y0 = (side // divider for side in view.crop[:2])
    x1, y1 = (math.ceil(side / divider) for side in view.crop[2:])
    place = (view.origin[0] + x0 * divider, view.origin[1] + y0 * divider)
    extent = ((x1 - x0) * divider, (y1 - y0) * divider)
    camera = replace(view.camera, viewplane=(left, right, bottom, top))
    return CoarseView(camera, width, height, (x0, y0, x1, y1), (*place, *extent))


def _free_camera(region_data, space, window):
    """Returns the camera of a view through no camera object."""
    world_from_view = np.linalg.inv(matrix4(region_data.view_matrix))
    if region_data.is_perspective:
        return description.Camera(
            "View", "perspective", world_from_view, window, space.clip_start, space.clip_end
        )
    # An orthographic view shows as much before its centre as behind it.
    world_from_view[:3, 3] += world_from_view[:3, 2] * (0.5 * space.clip_end)
    return description.Camera("View", "orthographic", world_from_view, window, 0.0, space.clip_end)


def _view_crop(space, size):
    """Returns the crop of a view through no camera object."""
    if not space.use_render_border:
        return (0, 0, *size)
    low = (space.render_border_min_x * size[0], space.render_border_min_y * size[1])
    high = (space.render_border_max_x * size[0], space.render_border_max_y * size[1])
    return _intersection((0, 0, *size), _rounded((*low, *high)))


def frame_in(inner, outer, size):
    """Returns (x0, y0, x1, y1) of the viewplane `inner`, in pixels of a region of viewplane `outer`."""
    per_x, per_y = size[0] / (outer[1] - outer[0]), size[1] / (outer[3] - outer[2])
    return (
        (inner[0] - outer[0]) * per_x,
        (inner[2] - outer[2]) * per_y,
        (inner[1] - outer[0]) * per_x,
        (inner[3] - outer[2]) * per_y,
    )


def _part(frame, render):
    """Returns the pixels of the scene's render region in a camera's frame."""
    x0, y0, x1, y1 = frame
    return _rounded(
        (
            x0 + (x1 - x0) * render.border_min_x,
            y0 + (y1 - y0) * render.border_min_y,
            x0 + (x1 - x0) * render.border_max_x,
            y0 + (y1 - y0) * render.border_max_y,
        )
    )


def _rounded(box):
    return tuple(round(side) for side in box)


def _intersection(a, b):
    """Returns the common part of two boxes, or None."""
    x0, y0, x1, y1 = max(a[0], b[0]), max(a[1], b[1]), min(a[2], b[2]), min(a[3], b[3])
    return (x0, y0, x1, y1) if x0 < x1 and y0 < y1 else None
