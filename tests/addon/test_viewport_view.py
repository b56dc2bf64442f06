# SPDX-License-Identifier: GPL-3.0-or-later
"""What a 3D view looks at: every pixel of the description's camera is where Blender's own matrices put it."""

import types

import numpy as np
import pytest
from nephele import description
from nephele.export.context import Context
from nephele.export.space import matrix4, viewplane
from nephele.viewport import camera_and_frame
from nephele.viewport_view import View, coarse, view_of

SIZE = (600, 400)
POINTS = np.array([(0.3, 0.2, -4.0, 1), (-1.1, 0.7, -9.0, 1), (0.9, -0.4, -3.0, 1)])  # of the view's space


def frustum(left, right, bottom, top, near=0.1, far=100.0):
    """Returns OpenGL's perspective matrix; sides at distance 1."""
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[0, 2] = 2 / (right - left), (right + left) / (right - left)
    matrix[1, 1], matrix[1, 2] = 2 / (top - bottom), (top + bottom) / (top - bottom)
    matrix[2, 2:] = -(far + near) / (far - near), -2 * far * near / (far - near)
    matrix[3, 2] = -1
    return matrix


def box(left, right, bottom, top, near=-100.0, far=100.0):
    """Returns OpenGL's orthographic matrix."""
    matrix = np.diag((2 / (right - left), 2 / (top - bottom), -2 / (far - near), 1.0))
    matrix[:3, 3] = (
        -(right + left) / (right - left),
        -(top + bottom) / (top - bottom),
        -(far + near) / (far - near),
    )
    return matrix


def turned():
    """Returns a view matrix: a turn and a shift."""
    c, s = np.cos(0.7), np.sin(0.7)
    matrix = np.array([[c, -s, 0, 0.5], [s, c, 0, -2.0], [0, 0, 1, -3.0], [0, 0, 0, 1]])
    tilt = np.array([[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]])
    return tilt @ matrix


def region_data(window, perspective=True):
    return types.SimpleNamespace(window_matrix=window, view_matrix=turned(), is_perspective=perspective)


def space(**members):
    defaults = {
        "clip_start": 0.2, "clip_end": 500.0, "use_render_border": False, "render_border_min_x": 0.0,
        "render_border_max_x": 1.0, "render_border_min_y": 0.0, "render_border_max_y": 1.0,
    }  # fmt: skip
    return types.SimpleNamespace(**defaults | members)


def render(**members):
    defaults = {"use_border": False, "border_min_x": 0.0, "border_max_x": 1.0, "border_min_y": 0.0,
                "border_max_y": 1.0}  # fmt: skip
    return types.SimpleNamespace(**defaults | members)


REGION = types.SimpleNamespace(width=SIZE[0], height=SIZE[1])


def pixels_by_matrix(window, view_points):
    """Returns the region's pixels (n, 2) of points by Blender's matrix."""
    clip = view_points @ window.T
    return (clip[:, :2] / clip[:, 3:] + 1) / 2 * SIZE


def pixels_by_camera(camera, size, world_points):
    """Returns the film's pixels (n, 2) of points by a description.Camera."""
    local = world_points @ np.linalg.inv(camera.world_from_camera).T
    xy = local[:, :2] / -local[:, 2:3] if camera.kind == "perspective" else local[:, :2]
    left, right, bottom, top = camera.viewplane
    return (xy - (left, bottom)) / (right - left, top - bottom) * size


@pytest.mark.parametrize("perspective", [True, False])
@pytest.mark.parametrize("divider", [1, 4, 7, 16])
def test_free_views_show_what_blender_shows(perspective, divider):
    window = frustum(-0.4, 0.5, -0.3, 0.3) if perspective else box(-3.0, 3.5, -2.0, 2.0)
    view = view_of(REGION, region_data(window, perspective), space(), render())
    world = POINTS @ np.linalg.inv(turned()).T
    expected = pixels_by_matrix(window, POINTS)
    found = pixels_by_camera(view.camera, view.size, world)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    part = coarse(view, divider)
    found = divider * pixels_by_camera(part.camera, (part.width, part.height), world)
    np.testing.assert_allclose(found, expected, atol=1e-6)
    assert view.crop == (0, 0, *SIZE)


def test_clipping_of_free_views():
    view = view_of(REGION, region_data(frustum(-1, 1, -1, 1)), space(), render())
    assert (view.camera.clip_start, view.camera.clip_end) == (0.2, 500.0)
    view = view_of(REGION, region_data(box(-1, 1, -1, 1), False), space(), render())
    depth = -(np.linalg.inv(view.camera.world_from_camera) @ np.linalg.inv(turned()))[2, 3]
    # Blender's orthographic views reach half of their clip end to either side.
    assert (view.camera.clip_start - depth, view.camera.clip_end - depth) == pytest.approx((-250, 250))


def test_border_of_a_free_view():
    members = {"render_border_min_x": 0.25, "render_border_max_x": 0.5, "render_border_min_y": 0.5}
    view = view_of(
        REGION, region_data(frustum(-1, 1, -1, 1)), space(use_render_border=True, **members), render()
    )
    assert view.crop == (150, 200, 300, 400)
    part = coarse(view, 8)
    assert part.crop == (18, 25, 38, 50)
    assert part.place == (144, 200, 160, 200)


def test_border_without_a_pixel_renders_nothing():
    members = {"render_border_min_x": 0.5, "render_border_max_x": 0.5}
    view = view_of(
        REGION, region_data(frustum(-1, 1, -1, 1)), space(use_render_border=True, **members), render()
    )
    assert (view.crop, view.pixels) == (None, 0)


@pytest.fixture
def through_camera(bpy, camera):
    """Returns a function (zoom, offset, **render) -> (View, window matrix): as Blender shows the camera's
    frame, zoomed and pushed about in the region."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 300, 200
    camera.data.shift_x, camera.data.clip_end = 0.1, 77.0

    def look(zoom, offset, kind="PERSP", **members):
        camera.data.type = kind
        depsgraph = bpy.context.evaluated_depsgraph_get()
        inner = Context(depsgraph)
        described, frame = camera_and_frame(inner, camera, scene.render)
        assert frame == described.viewplane
        left, right, bottom, top = frame
        middle = np.array(((left + right) / 2, (bottom + top) / 2)) + offset
        half = np.array((right - left, top - bottom)) / 2 / zoom
        sides = (middle[0] - half[0], middle[0] + half[0], middle[1] - half[1], middle[1] + half[1])
        window = frustum(*sides) if kind == "PERSP" else box(*sides)
        data = types.SimpleNamespace(
            window_matrix=window,
            view_matrix=np.linalg.inv(matrix4(camera.matrix_world)),
            is_perspective=kind == "PERSP",
        )
        return view_of(REGION, data, space(), render(**members), described, frame), window, described

    return look


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
def test_camera_views_show_what_blender_shows(through_camera, kind):
    view, window, described = through_camera(0.5, (0.03, -0.05), kind)
    found = pixels_by_camera(view.camera, view.size, POINTS @ matrix4(described.world_from_camera).T)
    np.testing.assert_allclose(found, pixels_by_matrix(window, POINTS), atol=1e-4)
    assert view.camera.clip_end == 77.0
    assert view.crop == (0, 0, *SIZE)


def test_border_of_a_camera_view(through_camera):
    """The frame is 300 x 200 pixels from (150, 100) on."""
    border = {"use_border": True, "border_min_x": 0.1, "border_max_x": 0.5, "border_min_y": 0.25}
    view, _, _ = through_camera(0.5, (0, 0), **border)
    assert view.crop == (180, 150, 300, 300)


def test_other_cameras_are_rendered_in_their_frame(through_camera):
    """A panorama does not go on beyond its frame; what of the frame is outside of the region is left out."""
    planar, window, described = through_camera(2.0, (0, 0))
    panorama = description.Camera("Around", "panorama", np.eye(4), (0.0, 1.0, 0.0, 1.0))
    data = types.SimpleNamespace(window_matrix=window, is_perspective=True)
    view = view_of(REGION, data, space(), render(), panorama, described.viewplane)
    assert (view.origin, view.size, view.crop) == ((-300, -200), (1200, 800), (300, 200, 900, 600))
    part = coarse(view, 4)
    assert (part.place, part.camera.viewplane) == ((0, 0, 600, 400), (0, 1, 0, 1))
    assert planar.crop == (0, 0, *SIZE)


def test_same_views():
    make = lambda **members: view_of(REGION, region_data(frustum(-1, 1, -1, 1)), space(**members), render())  # noqa: E731
    assert make().same(make())
    assert not make().same(make(clip_end=7.0))
    assert not make().same(None)


def test_viewplane_of_a_view(bpy, camera):
    """As Blender's own matrices have it."""
    matrix = camera.calc_matrix_camera(bpy.context.evaluated_depsgraph_get(), x=300, y=200)
    left, right, bottom, top = viewplane(matrix, True)
    assert (right - left, top - bottom) == pytest.approx((36 / 50, 24 / 50), rel=1e-5)
    assert isinstance(View(None, (0, 0), (1, 1), None).pixels, int)
