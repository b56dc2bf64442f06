# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes to start from: between them, every class and field of the description and every operation."""

import dataclasses

import numpy as np
from nephele import description as d
from nephele import opcodes
from small_world import small_world
from truth import Scene, box, constant_program, emission, facing, medium, perspective, placed, sphere

SIZE = (6, 4)
SETTINGS = {"samples": 2, "threads": 1, "max_bounces": 3}


def every_operation():
    """Returns a program that runs each operation once, and again beside the point where it can, and sums the
    results up in a register."""
    code, names = [], list(opcodes.OPCODES)
    modes = [(name, {"ramp": 1, "ramp_alpha": 1}.get(name, 0)) for name in names]
    modes += [(name, opcodes.SHIFT) for name in names if name in opcodes.SHIFTABLE]
    for name, mode in modes:
        number = names.index(name)
        code.append((number, 5, 1, 2, 3, 4, 0, mode))
        code.append((names.index("multiply_add"), 6, 5, 3, 6, 0, 0, 0))
    registers = [
        (1, 1, 1),
        (0.3, 0.6, 0.2),
        (0.5, 0.4, 0.7),
        (0.01, 0.01, 0.01),
        (0.2, 0.2, 0.2),
        *[(0, 0, 0)] * 2,
    ]
    return d.Program(
        np.array(registers, np.float32), np.array(code, np.int32), np.linspace(0, 1, 16, dtype=np.float32)
    )


def ripples():
    """Returns a program for media: noise at a place. Its bounds are asked for in many cells."""
    op = {name: number for number, name in enumerate(opcodes.OPCODES)}
    code = [(op["position"], 5, 0, 0, 0, 0, 0, 0), (op["noise"], 6, 5, 2, 1, 3, 0, 2)]
    return dataclasses.replace(every_operation(), code=np.array(code, np.int32))


def closure_of(program, kind):
    """Returns the program with a closure of this kind that reads its last register."""
    inputs = tuple(
        -1 if name.endswith("normal") else 6 if number == 0 else 1
        for number, name in enumerate(opcodes.CLOSURES[kind])
    )
    return dataclasses.replace(program, closures=(d.Closure(kind, 0, inputs),))


def moving(*places):
    return np.array([placed(*place) for place in places])


def gallery():
    """Returns a description of a scene that small_world() leaves room for: programs, images, motion, kinds of
    lights, nested dielectrics, a lens."""
    camera = perspective((0, -5, 1), (0, 0, 0), 0.5, aperture_radius=0.1, blades=5, focus_distance=5.0)
    lights = (
        d.Light("sun", "sun", facing((1, -1, 3), (0, 0, 0)), (3.0, 3.0, 2.0), angle=0.1),
        d.Light("spot", "spot", facing((-2, -1, 2), (0, 0, 0)), (90.0, 80.0, 70.0), radius=0.05),
        d.Light("point", "point", placed(1, 1, 1), (20.0, 10.0, 10.0), radius=0.1, soft_falloff=True),
        d.Light("disc", "area", facing((0, 2, 2), (0, 0, 0)), (9.0, 9.0, 9.0), shape="ellipse", spread=1.0),
    )
    everything = every_operation()
    scene = Scene(camera, emission((0.1, 0.2, 0.4)), (medium(0.01),), lights)
    kinds = [kind for kind in opcodes.CLOSURES if kind != "medium"]
    for number, kind in enumerate(kinds):
        scene.add(
            box((-2, -0.2, -0.5), (-1.6, 0.2, 0.2), kind),
            closure_of(everything, kind),
            (),
            placed(0.45 * number),
        )
    ball = sphere(0.4, 1)
    normals = ball.positions[ball.triangles]
    count = len(ball.triangles)
    ball = dataclasses.replace(
        ball,
        corner_normals=normals,
        uvs=(np.ascontiguousarray(normals[..., :2]),),
        attributes=(np.ones((count, 3, 4), np.float32),),
        material_index=np.zeros(count, np.int32),
        motion=np.stack([ball.positions, 1.1 * ball.positions]),
        motion_normals=np.stack([normals, normals]),
    )
    scene.add(
        ball, constant_program(("glass", 1.0, 0.0, 1.5, None)), (), placed(0, -1), dielectric_priority=1
    )
    scene.add(sphere(0.2, 1), None, (medium(2.0),), placed(1, -1), motion=moving((1, -1), (1.1, -1)))
    program = closure_of(ripples(), "medium")
    scene.add(box((-1, -1, 0.5), (0, 0, 1)), None, (d.VolumeClosure(program=program),))
    whole = scene.description(SIZE, **SETTINGS)
    pixels = np.arange(2 * 3 * 4).reshape(2, 3, 4)
    images = (
        d.Image("floats", (pixels / 24).astype(np.float32)),
        d.Image("bytes", pixels.astype(np.uint8), srgb=True),
    )
    camera = dataclasses.replace(whole.camera, motion=np.stack([camera.world_from_camera] * 2))
    instances = tuple(
        dataclasses.replace(instance, properties=((0.5, 1.0, 2.0, 1.0),)) for instance in whole.instances
    )
    return dataclasses.replace(
        whole, images=images, instances=instances, camera=camera, shutter=(-0.25, 0.25)
    )


def smoke():
    """Returns the description of small_world() with a moving volume whose coefficients a program computes."""
    whole = small_world().description(SIZE, **SETTINGS)
    program = closure_of(ripples(), "medium")
    closure = d.VolumeClosure(program=program, grids=("density", "nothing"))
    materials = list(whole.materials)
    number = whole.volumes[0].material
    materials[number] = dataclasses.replace(materials[number], volume=(*materials[number].volume, closure))
    volume = dataclasses.replace(
        whole.volumes[0],
        velocity_grids=("density", "density", "density"),
        velocity_scale=0.1,
        motion=moving((0, 0), (0.1, 0)),
    )
    return dataclasses.replace(whole, materials=tuple(materials), volumes=(volume,), shutter=(0.0, 0.5))


def all_scenes():
    return (small_world().description(SIZE, **SETTINGS), gallery(), smoke())
