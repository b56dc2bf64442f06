# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays along faces of voxels, of cells and of meshes, grazing and parallel to axes, of no length, and from
points on boundaries. A beam as narrow as 1e-30 m keeps every ray of the picture on its line."""

import numpy as np
from judge import GRIDS, TRACKED, Case, Twin
from nephele import description as d
from stages import WHITE, vdb
from truth import Scene, box, diffuse, half_world, medium, orthographic, perspective, sphere

NEAREST = {"interpolation": "nearest"}
PLAIN = Twin(settings={"integrator": "plain"})
KDTREE = ("default", "delta", "exact", "kdtree", "nds")
LINE = 1e-30
UP = half_world(1.0)


def ones(_):
    return np.ones((16, 16, 16))


def blocks(_):
    """Cells of 8^3 voxels of unlike density: an accelerator of either kind has a plane between them."""
    values = np.ones((32, 32, 32))
    values[8:16] = 3
    values[16:, 8:24] = 9
    values[:, :, 24:] = 0
    return values


def along(values, count, position, direction, sigma_s=0.0, sigma_a=0.05, world=WHITE, size=LINE, zeros=False):
    """A grid whose index (0, 0, 0) is the origin, and a ray through `position` in index space."""
    p, v = np.array(position, float), np.array(direction, float)
    v /= np.linalg.norm(v)
    view = orthographic(p - 3 * count * v, p, size)
    if zeros:  # exactly on the line, whatever the camera's axes are rounded to
        view = d.Camera(
            "camera", "orthographic", view.world_from_camera.round(12), (-size, size, -size, size)
        )
    closure = medium(sigma_s, sigma_a, density_grid="density")
    return Scene(view, world).add_volume(vdb(values), closure)


def beside(x, size=LINE, volume=None, surface=None):
    """A ray down along a side of a cube."""
    scene = Scene(orthographic((x, 0, 5), (x, 0, 0), size), WHITE)
    return scene.add(
        box((-1, -1, -1), (1, 1, 1), "cube"), surface, (medium(0.0, 0.5),) if volume is None else volume
    )


def inside(position, sigma_a=0.5, **view):
    """A camera at `position` of a cube of fog, looking along x."""
    p = np.array(position, float)
    scene = Scene(perspective(p, p + np.array((1, 0, 0)), 1e-6, **view), WHITE)
    return scene.add(box((-1, -1, -1), (1, 1, 1), "cube"), None, (medium(0.0, sigma_a),))


def grazing(height):
    """A white floor seen next to along it."""
    floor = box((-1e3, -1e3, -1), (1e3, 1e3, 0), "floor")
    return Scene(orthographic((0, 0, height), (900, 0, 0), 1e-9), WHITE).add(floor, diffuse(0.7))


CASES = [
    *(
        Case(
            f"along z at x = {x:g}, y = {y:g}",
            lambda x=x, y=y: along(ones, 16, (x, y, 7), (0, 0, -1)),
            np.exp(-0.8),
            GRIDS,
            settings=NEAREST,
            rounding=2e-5,
            quick=(x, y) == (7.5, 7.5),
        )
        for x, y in ((7.5, 7.5), (8, 8), (7.5, 8), (0, 0), (3.5, 14.5))
    ),
    *(
        Case(
            f"along the {name} at x = {x:g}, trilinear",
            lambda x=x, v=v: along(ones, 16, (x, 7.5, 7.5), v),
            PLAIN,
            GRIDS,
            rounding=2e-5,
            most=0.03,
            samples=128,
        )
        for name, v in (
            ("axis", (0, 1, 0)),
            ("diagonal", (1, 1, 0)),
            ("long diagonal", (1, 1, 1)),
            ("axis back", (-1, 0, 0)),
        )
        for x in (7.5, 8.0)
    ),
    *(
        Case(
            f"between cells at x = {x:g} along {name}",
            lambda x=x, v=v: along(blocks, 32, (x, 16, 16), v, 0.02, 0.02, UP, zeros=True),
            PLAIN,
            KDTREE,
            samples=256,
            most=0.06,
            cpu=20,
        )
        for x in (7.5, 8.0, 15.5, 16.0)
        for name, v in (("y", (0, 1, 0)), ("z", (0, 0, -1)), ("a diagonal", (1, 1, 0)))
    ),
    # On the side of a cube a ray is in or out; next to it, it has to be right.
    Case("on a side", lambda: beside(1.0), None, TRACKED),
    Case("on an edge of faces", lambda: beside(0.0), np.exp(-1.0), TRACKED, quick=True),
    Case("a float inside", lambda: beside(np.nextafter(np.float32(1), np.float32(0))), np.exp(-1.0), TRACKED),
    Case("a float outside", lambda: beside(np.nextafter(np.float32(1), np.float32(2))), 1.0, TRACKED),
    Case("along a wall", lambda: beside(1.0, surface=diffuse(0.7), volume=()), None, ("default", "field")),
    # Cameras on boundaries and corners.
    Case("from a face inwards", lambda: inside((-1, 0.1, 0.2)), np.exp(-1.0), TRACKED, quick=True),
    Case("from a face outwards", lambda: inside((1, 0.1, 0.2)), 1.0, TRACKED),
    Case("from the middle", lambda: inside((0, 0, 0)), np.exp(-0.5), TRACKED),
    Case("from a corner", lambda: inside((-1, -1, -1)), None, TRACKED),
    Case(
        "within the clipping range alone",
        lambda: inside((-3, 0, 0), clip_start=3.0, clip_end=3.5),
        np.exp(-0.25),
        TRACKED,
    ),
    Case(
        "a clipping range of a float",
        lambda: inside((-3, 0, 0), 1e6, clip_start=3.0, clip_end=3.0000002),
        None,
        TRACKED,
    ),
    *(
        Case(
            f"grazing from {h:g} m",
            lambda h=h: grazing(h),
            0.7,
            ("default", "field"),
            rounding=1e-4,
            quick=h == 1e-2,
        )
        for h in (10.0, 1e-2, 1e-4)
    ),
    Case(
        "grazing glass",
        lambda: Scene(orthographic((0, 0, 5), (0, 0, 0), 1e-6), WHITE).add(
            sphere(1.0, 3), None, (medium(0.2, 0.0),)
        ),
        1.0,
        TRACKED,
    ),
    Case(
        "past the horizon of a sphere",
        lambda: Scene(orthographic((0.99999, 0, 5), (0.99999, 0, 0), 1e-4), WHITE).add(
            sphere(1.0, 5), diffuse(1.0)
        ),
        1.0,
        ("default", "field"),
        rounding=1e-4,
    ),
]
