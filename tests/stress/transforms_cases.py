# SPDX-License-Identifier: GPL-3.0-or-later
"""Where things stand: sheared, mirrored, next to flat, and far from the origin. Twins stand straight, or near
the origin."""

import numpy as np
from judge import TRACKED, Case, Twin
from nephele import description as d
from stages import WHITE, centred, stage, vdb
from truth import Scene, box, half_world, medium, orthographic, placed

NEAREST = {"interpolation": "nearest"}
UP = half_world(1.0)
SOME = ("default", "delta", "exact", "field")


def ones(_):
    return np.ones((16, 16, 16))


def matrix(rows):
    m = np.eye(4)
    m[:3, :3] = rows
    return m


SHEAR = matrix([(1, 5, 0), (0, 1, 0), (0, 0, 1)])
MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])
TURN = matrix([(0.36, 0.48, -0.8), (-0.8, 0.6, 0.0), (0.48, 0.64, 0.6)])


def cube(place, sigma_s=0.0, sigma_a=0.5, world=WHITE):
    """A cube of 2 m before `place`, seen along z by a beam narrower than the most squeezed."""
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 1e-9), world)
    return scene.add(box((-1, -1, -1), (1, 1, 1), "cube"), None, (medium(sigma_s, sigma_a),), place)


def grid(place, sigma_s=0.0, sigma_a=0.05, world=WHITE):
    scene = Scene(orthographic((0.3, 0.2, 40), (0.3, 0.2, 0)), world)
    return scene.add_volume(
        vdb(ones),
        medium(sigma_s, sigma_a, density_grid="density"),
        world_from_object=place @ centred(16, 1.0),
    )


def baked(place, sigma_s, sigma_a, world):
    """cube() with its place in its vertices."""
    mesh = box((-1, -1, -1), (1, 1, 1), "cube")
    corners = mesh.positions @ place[:3, :3].T + place[:3, 3]
    triangles = mesh.triangles if np.linalg.det(place[:3, :3]) > 0 else mesh.triangles[:, ::-1].copy()
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 1e-9), world)
    return scene.add(d.Mesh("cube", corners.astype(np.float32), triangles), None, (medium(sigma_s, sigma_a),))


def far_grid(offset=(1e7, -1e7, 1e7)):
    """A grid and its camera far off."""
    x, y, z = offset
    scene = Scene(orthographic((x + 0.3, y + 0.2, z + 40), (x + 0.3, y + 0.2, z)), WHITE)
    closure = medium(0.0, 0.05, density_grid="density")
    return scene.add_volume(vdb(ones), closure, world_from_object=placed(*offset) @ centred(16, 1.0))


def far_vertices(x):
    """A cube of 2 m whose very vertices are far off, where floats are 1/16 m apart."""
    scene = Scene(orthographic((x, 0, 5), (x, 0, 0)), WHITE)
    return scene.add(box((x - 1, -1, -1), (x + 1, 1, 1), "cube"), None, (medium(0.0, 0.5),))


PLACES = {
    "sheared": SHEAR,
    "mirrored": MIRROR,
    "turned": TURN,
    "sheared and mirrored and turned": TURN @ SHEAR @ MIRROR,
    "stretched 1e4": np.diag([1e4, 1e4, 1.0, 1.0]),
    "stretched 1e-3 by 1e3": np.diag([1e3, 1e3, 1e-3, 1.0]),
    "next to flat": np.diag([1e3, 1e3, 1e-7, 1.0]),
    "next to singular": matrix([(1, 1 - 1e-6, 0), (1 - 1e-6, 1, 0), (0, 0, 1)]),
}


def depth_of(place):
    """Metres along z that the cube of 2 m covers around the origin, by its inverse."""
    along = np.abs(np.linalg.inv(place)[:3, 2])
    return float((2 / along[along > 1e-12]).min())


def depth_of_grid(place):
    """The same for grid(): between the planes of its 16 m."""
    inverse = np.linalg.inv(place)
    o, along = inverse @ (0.3, 0.2, 0, 1), inverse[:3, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (-8 - o[:3]) / along, (8 - o[:3]) / along
    moves = np.abs(along) > 1e-12
    return float(np.maximum(a, b)[moves].min() - np.minimum(a, b)[moves].max())


FAR = {
    "1e4 m off": (1e4, -2e4, 3e3),
    "1e7 m off": (1e7, -1e7, 1e7),
    "1e7 m off, odd": (1e7 + 0.37, 3.1, -1e7 - 0.83),
}

CASES = [
    *(
        Case(
            f"cube {name}",
            lambda m=m: cube(m),
            np.exp(-0.5 * depth_of(m)),
            TRACKED,
            rounding=2e-5,
            quick=name == "sheared",
        )
        for name, m in PLACES.items()
    ),
    *(
        Case(
            f"grid {name}",
            lambda m=m: grid(m),
            np.exp(-0.05 * depth_of_grid(m)),
            TRACKED,
            settings=NEAREST,
            rounding=5e-5,
            quick=name == "mirrored",
        )
        for name, m in PLACES.items()
        if name != "next to singular"
    ),
    *(
        Case(
            f"light in a cube {name}",
            lambda m=m: cube(m, 0.5, 0.1, UP),
            Twin(lambda m=m: baked(m, 0.5, 0.1, UP)),
            SOME,
            samples=256,
        )
        for name, m in PLACES.items()
        if "1e4" not in name and "1e3" not in name and "next" not in name
    ),
    *(
        Case(
            f"stage {name}",
            lambda o=o: stage(o),
            Twin(stage),
            SOME,
            samples=128,
            most=0.05,
            rounding=2e-4,
            cpu=20,
            quick=name == "1e7 m off",
        )
        for name, o in FAR.items()
    ),
    *(
        Case(
            f"thin stage {name}",
            lambda o=o: stage(o, thickness=1e-4),
            Twin(lambda: stage(thickness=1e-4)),
            SOME,
            samples=128,
            most=0.05,
            rounding=2e-4,
            cpu=20,
        )
        for name, o in FAR.items()
    ),
    Case("grid 1e7 m off", lambda: far_grid(), np.exp(-0.8), TRACKED, settings=NEAREST, rounding=2e-5),
    Case("mesh made 1e6 m off", lambda: far_vertices(1e6), np.exp(-1.0), TRACKED, rounding=0.07),
]
