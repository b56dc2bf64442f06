# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: the shutter, and which grids of a volume hold its velocity."""

import numpy as np
import pytest


@pytest.fixture
def cloud(bpy, link, openvdb, tmp_path):
    """Returns a Volume object that shows a file with velocities as one grid ("velocity") and as three
    ("wind.x" and so on), in a scene with motion blur at 25 frames a second."""

    def grid(name, kind, shape):
        result = kind()
        result.name = name
        result.copyFromArray(np.ones(shape, np.float32))
        return result

    grids = [grid("density", openvdb.FloatGrid, (4, 4, 4)), grid("velocity", openvdb.Vec3SGrid, (4, 4, 4, 3))]
    grids += [grid(f"wind.{axis}", openvdb.FloatGrid, (4, 4, 4)) for axis in "xyz"]
    grids += [grid(f"gust{axis}", openvdb.FloatGrid, (4, 4, 4)) for axis in "xy"]
    openvdb.write(str(tmp_path / "cloud.vdb"), grids=grids)
    data = bpy.data.volumes.new("Cloud")
    data.filepath = str(tmp_path / "cloud.vdb")
    render = bpy.context.scene.render
    render.use_motion_blur, render.fps, render.fps_base = True, 50, 2
    return link("Cloud", data)


def velocity_of(export):
    (result,) = export().volumes
    return result.velocity_grids, result.velocity_scale


def test_one_grid_of_vectors(cloud, export):
    cloud.data.velocity_scale = 3
    assert velocity_of(export) == (("velocity",), 3)
    cloud.data.velocity_unit = "SECOND"
    cloud.data.update_tag()
    assert velocity_of(export) == (("velocity",), pytest.approx(3 / 25))


def test_three_grids_of_numbers(cloud, export):
    cloud.data.grids.load()
    cloud.data.velocity_grid = "wind"
    assert velocity_of(export) == (("wind.x", "wind.y", "wind.z"), 1)


def test_no_blur_no_velocity(bpy, cloud, export):
    bpy.context.scene.render.use_motion_blur = False
    assert velocity_of(export) == ((), 0)
    assert export().shutter == (0, 0)


def test_objects_can_be_left_out(cloud, export):
    if not hasattr(cloud, "cycles"):
        pytest.skip("Cycles, which owns the setting, is absent")
    cloud.cycles.use_motion_blur = False
    assert velocity_of(export) == ((), 0)


@pytest.mark.parametrize(
    ("position", "expected"), [("START", (0, 0.5)), ("CENTER", (-0.25, 0.25)), ("END", (-0.5, 0))]
)
def test_shutter(bpy, cloud, export, position, expected):
    render = bpy.context.scene.render
    render.motion_blur_shutter, render.motion_blur_position = 0.5, position
    scene = export()
    assert scene.shutter == pytest.approx(expected)


def test_names_of_grids_that_are_not_there(cloud, export):
    from nephele.export.motion import velocity_grids

    class Grid:
        def __init__(self, name):
            self.name = name

    class Data:
        velocity_grid = velocity_x_grid = velocity_y_grid = velocity_z_grid = ""
        grids = (Grid("density"), Grid("gustx"), Grid("gusty"))

    assert velocity_grids(Data) == ()
    Data.velocity_grid = "gust"
    assert velocity_grids(Data) == ()
    for separator in ("", ".", "_"):
        Data.grids = tuple(Grid(f"gust{separator}{axis}") for axis in "xyz")
        assert velocity_grids(Data) == tuple(grid.name for grid in Data.grids)
