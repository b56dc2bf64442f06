# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that the tables share, and VDB files made of arrays. Lengths in metres."""

import importlib
import sys
import tempfile
from functools import cache
from pathlib import Path

import numpy as np
from nephele import description as d
from truth import (
    ROUGH_BALL,
    Scene,
    box,
    diffuse,
    emission,
    facing,
    half_world,
    medium,
    orthographic,
    perspective,
    placed,
    sphere,
)  # fmt: skip

WHITE = emission(1.0)


def block(sigma_s, sigma_a, half=1.0, world=WHITE, lights=(), g=0.0, at=(0.0, 0.0, 0.0), **more):
    """A cube of a constant medium, seen along z by parallel rays through its middle. half: of its edge."""
    x, y, z = at
    view = orthographic((x, y, z + 3 * half), (x, y, z), 1e-3 * half)
    cube = box((-half, -half, -half), (half, half, half), "cube")
    scene = Scene(view, world, lights=lights)
    place = np.eye(4)
    place[:3, 3] = at
    return scene.add(cube, None, (medium(sigma_s, sigma_a, g, **more),), place)


def balanced(sigma_s, sigma_a, **more):
    """A block that shines at its absorption, under a white world: radiance 1 everywhere."""
    return block(sigma_s, sigma_a, emission=tuple(np.broadcast_to(np.asarray(sigma_a, float), 3)), **more)


@cache
def _openvdb():
    """Returns Blender's own Python module for OpenVDB, which bpy brings but does not put on the path."""
    import bpy

    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    sys.path.append(str(Path(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages")))
    try:
        return importlib.import_module("openvdb")
    finally:
        sys.path.pop()


@cache
def _folder():
    return tempfile.TemporaryDirectory(prefix="nephele-stress-")


@cache
def vdb(key, voxel=1.0, background=0.0):
    """Returns the path of a VDB file whose grid "density" `key` fills: a function of an openvdb.FloatGrid, or
    one that returns an array whose first voxel is the index (0, 0, 0)."""
    openvdb = _openvdb()
    grid = openvdb.FloatGrid(background)
    values = key(grid)
    if values is not None:
        grid.copyFromArray(np.asarray(values, np.float32), tolerance=0)
    grid.name, grid.transform = "density", openvdb.createLinearTransform(voxel)
    path = Path(_folder().name) / f"{getattr(key, '__name__', 'grid')}-{len(list(_folder_files()))}.vdb"
    openvdb.write(str(path), [grid])
    return path


def _folder_files():
    return Path(_folder().name).iterdir()


def centred(count, voxel):
    """Returns the matrix that brings `count`^3 voxels of 1 m, from index (0, 0, 0) on, around the origin and
    to another size."""
    m = np.diag([voxel, voxel, voxel, 1.0])
    m[:3, 3] = -0.5 * voxel * (count - 1)
    return m


def smoke(
    path, count, sigma_s, sigma_a=0.0, voxel=1.0, world=WHITE, beam=(0.0, 0.0), g=0.0, lights=(), **more
):
    """A grid of count^3 voxels around the origin, seen along z by parallel rays. beam: where they pass,
    voxels from the middle."""
    extent, x, y = count * voxel, beam[0] * voxel, beam[1] * voxel
    view = orthographic((x, y, 2 * extent), (x, y, 0), 1e-3 * voxel)
    scene = Scene(view, world, lights=lights)
    return scene.add_volume(
        path,
        medium(sigma_s, sigma_a, g, density_grid="density", **more),
        world_from_object=centred(count, voxel),
    )


def floor(albedo, lights, distance=1.0, world=None, size=1e-3):
    """A plane at z = 0, seen from above through its middle by parallel rays. distance: what its extent of a
    thousand and the picture's `size` are relative to."""
    w = 10 * distance
    plane = d.Mesh(
        "plane",
        np.array([(-w, -w, 0), (w, -w, 0), (w, w, 0), (-w, w, 0)], np.float32),
        np.array([(0, 1, 2), (0, 2, 3)], np.int32),
    )
    view = orthographic((0, 0, 0.25 * distance), (0, 0, 0), size * distance)
    return Scene(view, world, lights=lights).add(plane, diffuse(albedo))


def stage(offset=(0.0, 0.0, 0.0), size=1.0, thickness=1.0, power=1.0):
    """A grid, a mesh medium, a floor, lamps of all kinds and a shining ball: a scene of some metres, moved by
    `offset` and made `size` times as large at the same optical depths, which `thickness` multiplies. power:
    of all light."""
    o, scaled = np.array(offset), np.diag([size, size, size, 1.0])

    def at(*p):
        return placed(*(o + size * np.array(p))) @ scaled

    def aimed(*p):
        return facing(o + size * np.array(p), o)

    def watts(*w):
        return tuple(power * size**2 * np.array(w))

    lights = (
        d.Light("area", "area", aimed(1, -1, 2), watts(50, 40, 30), size=(size, size)),
        d.Light(
            "point",
            "point",
            placed(*(o + size * np.array((-1.2, -0.5, 1)))),
            watts(20, 20, 30),
            radius=0.1 * size,
        ),
        d.Light("spot", "spot", aimed(0, -2, 2), watts(60, 30, 30), radius=0.05 * size, spot_size=0.6),
        d.Light(
            "sun",
            "sun",
            facing((0.3, 0.2, 1), (0, 0, 0)),
            tuple(power * np.array((0.5, 0.4, 0.3))),
            angle=0.02,
        ),
    )
    sky = half_world(power * np.array((0.3, 0.5, 1.0)), 0.1 * power)
    scene = Scene(perspective(o + size * np.array((0, -4, 0.5)), o, 0.4), sky, lights=lights)
    dense = thickness / size
    cloud = medium(
        np.array((2, 3, 4)) * dense, np.array((0.5, 0.2, 0.1)) * dense, 0.5, density_grid="density"
    )
    scene.add_volume(ROUGH_BALL, cloud, world_from_object=at(0, 0, 0))
    scene.add(box((-3, -3, -1.4), (3, 3, -1), "floor"), diffuse((0.8, 0.6, 0.4)), (), at(0, 0, 0))
    scene.add(sphere(0.3, 2), emission(power * np.array((3.0, 2.0, 1.0))), (), at(-1, -0.6, -0.3))
    fog = medium(np.array((0.3, 0.2, 0.1)) * dense, 0.0, -0.3)
    return scene.add(box((0, -1, -1), (1.2, 1, 0.4), "fog"), None, (fog,), at(0, 0, 0))
