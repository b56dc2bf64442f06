# SPDX-License-Identifier: GPL-3.0-or-later
"""What cannot be rendered: one message names the object and the remedy."""

import dataclasses

import numpy as np
from judge import Case, Refusal
from nephele import description as d
from stages import WHITE, block, vdb
from truth import Scene, box, constant_program, diffuse, emission, medium, orthographic, placed

NAN, INF = float("nan"), float("inf")
CUBE = box((-1, -1, -1), (1, 1, 1), "the cube")


def ones(_):
    return np.ones((4, 4, 4))


def scene(**more):
    return Scene(orthographic((0, 0, 4), (0, 0, 0)), WHITE, **more)


def with_vertex(x):
    positions = CUBE.positions.copy()
    positions[3, 1] = x
    return scene().add(dataclasses.replace(CUBE, positions=positions), diffuse(0.7))


def with_normal(x):
    normals = np.zeros((12, 3, 3), np.float32)
    normals[..., 2] = 1
    normals[5, 1, 0] = x
    return scene().add(dataclasses.replace(CUBE, corner_normals=normals), diffuse(0.7))


def with_uv(x):
    uvs = np.zeros((12, 3, 2), np.float32)
    uvs[2] = x
    return scene().add(dataclasses.replace(CUBE, uvs=(uvs,)), diffuse(0.7))


def placed_by(matrix, volume=(), surface=None):
    return scene().add(CUBE, surface, volume, np.array(matrix, float))


def smoke_by(matrix):
    closure = medium(0.5, 0.1, density_grid="density")
    return scene().add_volume(vdb(ones), closure, world_from_object=np.array(matrix, float))


def of_smoke(**more):
    return scene().add_volume(vdb(ones), medium(0.5, 0.1, density_grid="density"), **more)


def lit_by(**more):
    values = {
        "name": "the lamp",
        "kind": "point",
        "world_from_light": placed(0, 0, 3),
        "power": (1.0,) * 3,
    } | more
    return scene(lights=(d.Light(**values),)).add(CUBE, diffuse(0.7))


def seen_by(**more):
    s = scene().add(CUBE, diffuse(0.7))
    s.camera = dataclasses.replace(s.camera, name="the eye", **more)
    return s


def film(**more):
    s = scene().add(CUBE, diffuse(0.7)).description(size=16)
    return dataclasses.replace(s, film=dataclasses.replace(s.film, **more))


FOG = (medium(0.5, 0.1),)
FLAT, NOWHERE = np.diag([1.0, 0.0, 1.0, 1.0]), placed(NAN, 0, 0)
ENORMOUS = np.diag([1e200, 1e200, 1e200, 1.0])

CASES = [
    *(
        Refusal(f"vertex {x}", lambda x=x: with_vertex(x), ("the cube", "not finite", "apply"))
        for x in (NAN, INF, -INF)
    ),
    *(
        Refusal(f"normal {x}", lambda x=x: with_normal(x), ("the cube", "normal", "not finite"))
        for x in (NAN, INF)
    ),
    *(Refusal(f"uv {x}", lambda x=x: with_uv(x), ("the cube", "not finite")) for x in (NAN, INF)),
    Refusal("vertex of 1e30 m", lambda: with_vertex(1e30), ("the cube", "further")),
    *(
        Refusal(
            f"{what} {name}",
            lambda m=m, volume=volume, surface=surface: placed_by(m, volume, surface),
            ("the cube", "transform"),
        )
        for what, volume, surface in (("medium", FOG, None), ("surface", (), diffuse(0.7)))
        for name, m in (
            ("of scale zero", FLAT),
            ("nowhere", NOWHERE),
            ("1e200 times as large", ENORMOUS),
            ("1e30 m off", placed(1e30, 0, 0)),
        )
    ),
    *(
        Refusal(f"smoke {name}", lambda m=m: smoke_by(m), ("volume", "transform"))
        for name, m in (("of scale zero", FLAT), ("nowhere", NOWHERE), ("1e200 times as large", ENORMOUS))
    ),
    *(
        Refusal(f"smoke of density {x}", lambda x=x: of_smoke(density_scale=x), ("volume",))
        for x in (NAN, INF, -1.0)
    ),
    Refusal("smoke clipped at nan", lambda: of_smoke(clipping=NAN), ("volume", "clipping")),
    *(
        Refusal(f"coefficient {x}", lambda x=x: block(0.5, x), ("cube", "coefficient"))
        for x in (NAN, INF, -1.0, 1e39)
    ),
    *(Refusal(f"anisotropy {x}", lambda x=x: block(0.5, 0.1, g=x), ("phase", "not finite")) for x in (NAN,)),
    *(
        Refusal(
            f"lamp with {name} {x}",
            lambda name=name, x=x, kind=kind: lit_by(**{name: x, "kind": kind}),
            ("the lamp",),
        )
        for name, x, kind in (
            ("power", (NAN, 1, 1), "point"),
            ("power", (1, INF, 1), "area"),
            ("power", (1, -1, 1), "sun"),
            ("radius", NAN, "point"),
            ("radius", INF, "spot"),
            ("size", (NAN, 1), "area"),
            ("size", (INF, 1), "area"),
            ("angle", NAN, "sun"),
            ("angle", INF, "sun"),
            ("spread", NAN, "area"),
            ("spot_size", INF, "spot"),
            ("spot_blend", NAN, "spot"),
        )
    ),
    Refusal("lamp nowhere", lambda: lit_by(world_from_light=NOWHERE), ("the lamp", "transform")),
    *(
        Refusal(
            f"eye with {name} {np.ravel(x)[:4]}", lambda name=name, x=x: seen_by(**{name: x}), ("the eye",)
        )
        for name, x in (
            ("viewplane", (0.0, 0.0, 0.0, 0.0)),
            ("viewplane", (NAN, 1, -1, 1)),
            ("viewplane", (-INF, INF, -1, 1)),
            ("clip_start", NAN),
            ("clip_start", 2e30),
            ("clip_end", NAN),
            ("aperture_radius", NAN),
            ("aperture_radius", INF),
            ("aperture_ratio", 0.0),
            ("aperture_ratio", NAN),
            ("blades", 2),
            ("blades_rotation", NAN),
            ("world_from_camera", np.zeros((4, 4))),
            ("world_from_camera", NOWHERE),
        )
    ),
    *(
        Refusal(f"film with {name} {x}", lambda name=name, x=x: film(**{name: x}), ("render",))
        for name, x in (
            ("width", 0),
            ("height", -4),
            ("crop", (0, 0, 0, 16)),
            ("crop", (-4, 0, 8, 8)),
            ("crop", (0, 0, 17, 16)),
        )
    ),
    Refusal("no such VDB file", lambda: scene().add_volume("/nowhere/a.vdb"), ("/nowhere/a.vdb", "volume")),
    # What a shader computes as no number is taken for 0, as programs do with every operation's result.
    *(
        Case(
            f"world of {x}",
            lambda x=x: Scene(orthographic((0, 0, 4), (0, 0, 0)), emission(x)),
            None,
            quick=True,
        )
        for x in (NAN, INF)
    ),
    *(
        Case(
            f"glow of {x}", lambda x=x: scene().add(CUBE, emission(x)), None, ("default", "field"), quick=True
        )
        for x in (NAN, INF)
    ),
    Case("albedo of nan", lambda: scene().add(CUBE, constant_program(("diffuse", NAN, 0.0, None))), None),
]
