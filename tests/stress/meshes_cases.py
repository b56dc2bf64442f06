# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes as nobody should make them: coincident, degenerate, inside out, open, non-manifold."""

import dataclasses

import numpy as np
from judge import TRACKED, Case, Twin
from nephele import description as d
from stages import WHITE, block, floor
from truth import (
    Scene,
    box,
    constant_program,
    diffuse,
    emission,
    glass,
    half_world,
    joined,
    medium,
    orthographic,
    perspective,
    placed,
    sphere,
)  # fmt: skip

PLAIN = Twin(settings={"integrator": "plain"})
BOTH = ("default", "field")
SOME = ("default", "delta", "exact", "field")
FOG = (medium(0.0, 0.5),)
CUBE = box((-1, -1, -1), (1, 1, 1), "cube")
TOP, BOTTOM = slice(10, 12), slice(8, 10)  # triangles of CUBE


def seen(mesh, volume=FOG, surface=None, world=WHITE, place=None):
    return Scene(orthographic((0, 0, 4), (0, 0, 0)), world).add(mesh, surface, volume, place)


def with_triangles(mesh, *more):
    return dataclasses.replace(mesh, triangles=np.concatenate([mesh.triangles, np.array(more, np.int32)]))


def without(mesh, part):
    return dataclasses.replace(mesh, triangles=np.delete(mesh.triangles, np.arange(12)[part], axis=0))


def turned(mesh):
    return dataclasses.replace(mesh, triangles=mesh.triangles[:, ::-1].copy())


def with_normals(mesh, normal):
    return dataclasses.replace(
        mesh, corner_normals=np.broadcast_to(np.float32(normal), (len(mesh.triangles), 3, 3)).copy()
    )


def stacked(count):
    scene = Scene(orthographic((0, 0, 4), (0, 0, 0)), WHITE)
    for _ in range(count):
        scene.add(CUBE, None, (medium(0.0, 0.5 / count),))
    return scene


def sheets(count, surface, world=WHITE):
    """Planes in one another."""
    scene = floor(0.7, (), world=world)
    for _ in range(count):
        scene.add(scene.meshes[0], surface)
    return scene


def flat(corners):
    return d.Mesh("flat", np.array(corners, np.float32), np.array([(0, 1, 2)], np.int32))


def shells(*radii):
    """Spheres of glass in one another, the radii next to each other."""
    scene = Scene(perspective((0, -4, 1.0), (0, 0, 0), 0.15), WHITE)
    for r in radii:
        scene.add(sphere(r, 3), glass(1.5))
    return scene


def thin_wall(thickness):
    """A wall of two faces next to each other under a sky, in front of black."""
    scene = Scene(orthographic((0, 0, 4), (0, 0, 0), 0.5), half_world(1.0))
    return scene.add(box((-2, -2, -thickness), (2, 2, 0), "wall"), diffuse(0.7))


def room(albedo):
    """A closed room whose walls shine with what they absorb."""
    wall = constant_program(("diffuse", albedo, 0.0, None), ("emission", 1 - albedo, 1.0))
    return Scene(perspective((0.3, 0.2, 0.1), (1, 0.4, 0.2))).add(CUBE, wall)


CASES = [
    # Media: the rule of media/segment.h, for closed meshes and for others.
    Case("2 coincident cubes", lambda: stacked(2), np.exp(-1.0), TRACKED, quick=True),
    Case("60 coincident cubes", lambda: stacked(60), np.exp(-1.0), TRACKED, rounding=2e-5),
    Case(
        "degenerate faces in a cube",
        lambda: seen(with_triangles(CUBE, (0, 0, 0), (1, 1, 2), (3, 4, 3), (7, 7, 7))),
        np.exp(-1.0),
        TRACKED,
        quick=True,
    ),
    Case("every face twice", lambda: seen(joined(CUBE, CUBE)), np.exp(-1.0), TRACKED),
    Case("every face both ways", lambda: seen(joined(CUBE, turned(CUBE))), None, TRACKED),
    Case("nothing but degenerate faces", lambda: seen(flat([(0, 0, 0), (1, 0, 0), (2, 0, 0)])), 1.0, SOME),
    Case("a face of one point", lambda: seen(flat([(0, 0, 0)] * 3)), 1.0, SOME),
    Case(
        "no faces", lambda: seen(dataclasses.replace(CUBE, triangles=np.zeros((0, 3), np.int32))), 1.0, SOME
    ),
    Case(
        "no vertices",
        lambda: seen(d.Mesh("none", np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))),
        1.0,
        SOME,
    ),
    Case("inside out", lambda: seen(turned(CUBE)), 0.0, TRACKED),
    Case("no bottom: it never ends", lambda: seen(without(CUBE, BOTTOM)), 0.0, TRACKED),
    Case("no top: it began before the camera", lambda: seen(without(CUBE, TOP)), np.exp(-2.5), TRACKED),
    Case("a wall inside", lambda: seen(with_triangles(CUBE, (0, 1, 7))), None, TRACKED),
    Case(
        "light through a wall inside",
        lambda: seen(with_triangles(CUBE, (0, 1, 7)), (medium(0.5, 0.1),), world=half_world(1.0)),
        PLAIN,
        SOME,
        samples=256,
        most=0.06,
    ),
    Case(
        "light in an inside-out cube",
        lambda: seen(turned(CUBE), (medium(0.5, 0.5),), world=half_world(1.0)),
        None,
        SOME,
    ),
    Case("a flat cube", lambda: seen(box((-1, -1, 0), (1, 1, 0), "flat cube")), 1.0, SOME),
    Case("a cube a float thick", lambda: seen(box((-1, -1, 0), (1, 1, 1e-38), "thin cube")), 1.0, SOME),
    Case(
        "two cubes that share a face",
        lambda: seen(box((-1, -1, 0), (1, 1, 1))).add(box((-1, -1, -1), (1, 1, 0)), None, FOG),
        np.exp(-1.0),
        TRACKED,
    ),
    Case(
        "cubes a millionth apart",
        lambda: seen(box((-1, -1, 1e-6), (1, 1, 1))).add(box((-1, -1, -1), (1, 1, 0)), None, FOG),
        np.exp(-1.0),
        TRACKED,
        rounding=2e-5,
    ),
    # Surfaces.
    *(
        Case(f"{n + 1} coincident floors", lambda n=n: sheets(n, diffuse(0.7)), 0.7, BOTH, quick=n == 1)
        for n in (1, 30)
    ),
    Case(
        "floor in a mirror of itself",
        lambda: sheets(1, constant_program(("glossy", 1.0, 0.0, None))),
        None,
        BOTH,
    ),
    Case(
        "30 coincident transparent floors",
        lambda: sheets(30, constant_program(("transparent", 1.0))),
        None,
        BOTH,
    ),
    *(Case(f"wall of {t:g} m", lambda t=t: thin_wall(t), 0.7, BOTH) for t in (0.0, 1e-7, 1e-3)),
    Case(
        "shells of glass next to each other",
        lambda: shells(0.8, 0.8, 0.7999999),
        1.0,
        BOTH,
        most=0.05,
        rounding=1e-3,
    ),
    Case(
        "normals of nothing",
        lambda: seen(with_normals(CUBE, (0, 0, 0)), (), diffuse(0.7)),
        0.7,
        BOTH,
        quick=True,
    ),
    Case(
        "normals that point away", lambda: seen(with_normals(CUBE, (0, 0, -1)), (), diffuse(0.7)), None, BOTH
    ),
    Case("normals along the face", lambda: seen(with_normals(CUBE, (1, 0, 0)), (), diffuse(0.7)), None, BOTH),
    Case("normals of 1e30", lambda: seen(with_normals(CUBE, (0, 0, 1e30)), (), diffuse(0.7)), 0.7, BOTH),
    Case("normals of 1e-30", lambda: seen(with_normals(CUBE, (0, 0, 1e-30)), (), diffuse(0.7)), 0.7, BOTH),
    *(
        Case(f"room in balance, albedo {a:g}", lambda a=a: room(a), 1.0, BOTH, most=0.05)
        for a in (0.0, 0.5, 0.95)
    ),
    # Glowing meshes without area, next to good ones.
    Case(
        "glowing points and lines",
        lambda: (
            floor(0.7, ())
            .add(flat([(0, 0, 1), (1, 0, 1), (2, 0, 1)]), emission(1.0))
            .add(flat([(0, 0, 1)] * 3), emission(1.0))
        ),
        0.0,
        BOTH,
    ),
    Case(
        "a glowing needle",
        lambda: floor(0.7, ()).add(flat([(-1, -1e-9, 1), (1, -1e-9, 1), (0, 1e-9, 1)]), emission(1.0)),
        None,
        BOTH,
    ),
    Case(
        "a glowing cube inside out",
        lambda: block(0.2, 0.1, world=None).add(turned(CUBE), emission(1.0), (), placed(0, 0, -4)),
        PLAIN,
        BOTH,
        samples=256,
        most=0.1,
    ),
]
