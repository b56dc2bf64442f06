# SPDX-License-Identifier: GPL-3.0-or-later
"""Media that programs make of grids, noise and colours: every way of tracking against the plain integrator,
programs against what needs none, filters and worlds against closed forms, and far away against near.

False alarm of a comparison: 2e-4 (see comparison.py); of a closed form 6e-7 for each number.
"""

import itertools
from functools import cache

import numpy as np
import pytest
from assembler import Code, inside_box
from comparison import assert_same, moments
from nephele import description as d
from nephele import opcodes, parameters
from truth import (
    BOX_FILTER,
    SCENES,
    Scene,
    assert_mean,
    box,
    diffuse,
    emission,
    facing,
    half_world,
    orthographic,
    perspective,
    placed,
)  # fmt: skip

MEDIA = SCENES / "media" / "media.vdb"  # a ball of radius 0.5
SKY = half_world((0.3, 0.5, 1.0), (0.2, 0.15, 0.1))
SEEDS = 8


def choices(name):
    """Returns the values of a setting that is an enum."""
    (setting,) = (p for p in parameters.PARAMETERS if p.name == name)
    return [item[0] for item in setting.items]


def medium(code, sigma_s, sigma_a=0, emission=0, phase="henyey_greenstein", a=0, b=0):
    """Returns the Program of a medium whose inputs are registers of the code; 0: none."""
    none = code.constant(0)
    inputs = [value or none for value in (sigma_s, sigma_a, emission, a, b)]
    program = code.program(("medium", 0, *inputs))
    (row,) = program.closures
    rows = (d.Closure(row.kind, row.weight, row.inputs, list(opcodes.PHASES).index(phase)),)
    return d.Program(program.registers, program.code, program.parameters, rows)


def fire():
    """Smoke as grids colour it, which shines where it is hot, and scatters more forward there."""
    code = Code()
    density, color, heat = (code.run("grid", code.run("position"), mode=k) for k in range(3))
    thick = code.run("multiply", density, code.constant(12))
    dark = code.run("subtract", code.constant(1), color)
    kelvin = code.run("multiply_add", heat, code.constant(1500), code.constant(1500))
    power = code.run("multiply", code.run("multiply", heat, heat), code.constant(2))
    shine = code.run("multiply", code.run("blackbody", kelvin), power)
    g = code.run("multiply", heat, code.constant(0.7))
    absorbed = code.run("multiply", code.run("multiply", dark, thick), code.constant(0.3))
    program = medium(code, code.run("multiply", thick, color), absorbed, shine, a=g)
    return d.VolumeClosure(program=program, grids=("density", "color", "heat"))


def marble():
    """Coloured noise with holes."""
    code = Code()
    settings = [code.constant(v) for v in (3.0, (1, 0.5, 2), 0)]
    noise = code.run("noise", code.run("object_coordinate"), *settings, mode=2)
    thick = code.run("maximum", code.run("subtract", noise, code.constant(0.45)), code.constant(0))
    scattered = code.run("multiply", thick, code.constant((6, 12, 20)))
    program = medium(
        code, scattered, code.constant((0.4, 0.1, 0.2)), 0, "draine", code.constant(0.4), code.constant(1)
    )
    return d.VolumeClosure(program=program)


def burning(at=(0.0, 0.0, 0.0)):
    """Fire and a box of noise overlap; a grid of grey smoke with no program over the fire, a floor, a lamp.
    Everything stands about the point `at`."""
    at = np.asarray(at)
    move = placed(*at)
    lamp = d.Light("lamp", "area", facing(at + np.array((1.5, -0.5, 2)), at), (60.0,) * 3, size=(2.5, 2.5))
    scene = Scene(perspective(at + np.array((0.1, -2.5, 0.5)), at, 0.3), SKY, lights=(lamp,))
    grey = d.VolumeClosure((3, 3, 3), (1, 1, 1), phase=d.Phase(a=-0.3), density_grid="density")
    scene.add_volume(MEDIA, fire(), grey, world_from_object=move)
    scene.add(box((-0.1, -0.6, -0.6), (0.7, 0.6, 0.3)), None, (marble(),), move)
    return scene.add(box((-3, -3, -1), (3, 3, -0.7)), diffuse((0.8, 0.6, 0.4)), (), move)


@cache
def plain(interpolation, samples):
    """Returns the moments of the burning scene by the plain integrator."""
    settings = {"integrator": "plain", "interpolation": interpolation}
    return moments(burning(), SEEDS, samples, 6, 12, seed=1000, **settings)


WAYS = ("interpolation", "tracking", "transmittance", "majorant")
ALL = list(itertools.product(*map(choices, WAYS)))
# Nine of the 81 in which every two values of two settings meet (an orthogonal array).
PAIRS = {(i, j, (i + j) % 3, (i + 2 * j + 1) % 3) for i in range(3) for j in range(3)}
# Samples of the path tracer and of the plain integrator, whose noise decides what a comparison sees, and the
# largest standard error that is left, relative, of the image's mean: a bias of 6 of them is seen.
QUICK, THOROUGH = (24, 80, 0.02), (96, 256, 0.012)


def is_pair(values):
    numbers = (choices(name).index(value) for name, value in zip(WAYS, values, strict=True))
    return tuple(numbers) in PAIRS


@pytest.mark.parametrize(
    ("values", "effort"),
    [pytest.param(values, QUICK, id="-".join(values)) for values in filter(is_pair, ALL)]
    + [pytest.param(v, THOROUGH, id="-".join((*v, "thorough")), marks=pytest.mark.long) for v in ALL],
)
def test_all_ways_of_tracking_agree_with_the_plain_integrator(values, effort):
    samples, plain_samples, error = effort
    settings = dict(zip(WAYS, values, strict=True))
    path = moments(burning(), SEEDS, samples, 6, 12, **settings)
    assert_same(path, plain(settings["interpolation"], plain_samples), SEEDS, error)


@pytest.mark.parametrize("interpolation", choices("interpolation"))
def test_program_of_a_constant_times_a_grid_is_what_needs_no_program(interpolation):
    sigma_s, sigma_a, shine = (4.0, 8.0, 12.0), (1.0, 0.5, 0.2), (0.3, 0.2, 0.1)
    direct = d.VolumeClosure(sigma_s, sigma_a, phase=d.Phase(a=0.4), density_grid="density")
    glow = d.VolumeClosure(emission=shine, emission_grid="density")
    code = Code()
    grid = code.run("grid", code.run("position"), mode=0)
    products = [code.run("multiply", grid, code.constant(value)) for value in (sigma_s, sigma_a, shine)]
    program = d.VolumeClosure(program=medium(code, *products, a=code.constant(0.4)), grids=("density",))
    results = []
    for k, closures in enumerate(((direct, glow), (program,))):
        scene = Scene(perspective((0.1, -2.5, 0.5), (0, 0, 0), 0.25), SKY)
        scene.add_volume(MEDIA, *closures)
        results.append(
            moments(scene, SEEDS, 144, 6, 12, seed=100 * k, interpolation=interpolation, **BOX_FILTER)
        )
    assert_same(*results, SEEDS, error=0.008)


# --- Filters

VOXEL, CELLS = 0.25, 6


def filtered(values, points, interpolation):
    """Returns (N,): the filter's value at points (N, 3) of index space. values: (n, n, n), 0 beyond."""
    reach = {"nearest": (0, 0), "trilinear": (0, 1), "tricubic": (-1, 2)}[interpolation]
    padded = np.pad(values, 4)
    base = np.floor(points + (0.5 if interpolation == "nearest" else 0.0)).astype(int)
    total = np.zeros(len(points))
    for offset in itertools.product(range(reach[0], reach[1] + 1), repeat=3):
        away = np.abs(points - base - offset)
        weight = {
            "nearest": np.ones_like(away),
            "trilinear": 1 - away,
            "tricubic": np.where(away < 1, 2 / 3 - away**2 + away**3 / 2, np.maximum(2 - away, 0) ** 3 / 6),
        }[interpolation].prod(axis=1)
        index = np.clip(base + offset + 4, 0, len(padded) - 1)
        total += weight * padded[tuple(index.T)]
    return total


@pytest.mark.parametrize("interpolation", choices("interpolation"))
@pytest.mark.parametrize("with_program", [False, True], ids=["direct", "program"])
def test_transmittance_through_few_voxels_is_that_of_the_filter(
    interpolation, with_program, tmp_path, openvdb
):
    values = np.random.default_rng(5).uniform(0, 2, (CELLS,) * 3).astype(np.float32)
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.copyFromArray(values)
    grid.transform = openvdb.createLinearTransform(VOXEL)
    path = tmp_path / "voxels.vdb"
    openvdb.write(str(path), [grid])
    sigma_a = (0.5, 1.0, 2.0)
    closure = d.VolumeClosure(sigma_a=sigma_a, density_grid="density")
    if with_program:
        code = Code()
        density = code.run("grid", code.run("position"), mode=0)
        program = medium(code, 0, code.run("multiply", density, code.constant(sigma_a)))
        closure = d.VolumeClosure(program=program, grids=("density",))
    x = np.linspace(-3, CELLS + 2, 20001)
    step = (x[1] - x[0]) * VOXEL
    for y, z in ((2.3, 3.1), (0.4, 4.8), (-0.3, 2.7)):
        points = np.stack([(x[1:] + x[:-1]) / 2, np.full(20000, y), np.full(20000, z)], axis=1)
        depth = filtered(values.astype(float), points, interpolation).sum() * step
        view = orthographic((5, y * VOXEL, z * VOXEL), (0, y * VOXEL, z * VOXEL), 1e-4)
        scene = Scene(view, emission(1.0)).add_volume(path, closure)
        for transmittance in choices("transmittance"):
            settings = {"interpolation": interpolation, "transmittance": transmittance}
            passes = ("Combined", "Transmittance")
            for image in scene.render(passes, size=32, samples=32, **settings, **BOX_FILTER).values():
                assert_mean(image, np.exp(-depth * np.array(sigma_a)), rounding=3e-4, most=0.02)


# --- The world


def test_air_that_thins_out_with_height_dims_the_sky():
    """Absorption sigma exp(-z / h), looking up from height z0: exp(-sigma h exp(-z0 / h))."""
    sigma, h, z0 = np.array((0.1, 0.3, 1.0)), 2.0, 0.3
    code = Code()
    z = code.run("channel", code.run("position"), mode=2)
    above = code.run("maximum", z, code.constant(-5))
    thin = code.run("exponent", code.run("multiply", above, code.constant(-1 / h)))
    program = medium(code, 0, code.run("multiply", thin, code.constant(sigma)))
    scene = Scene(
        orthographic((0.2, 0.1, z0), (0.2, 0.1, 9)),
        emission(1.0),
        world_volume=(d.VolumeClosure(program=program),),
    )
    image = scene.render(size=32, samples=64, **BOX_FILTER)["Combined"]
    assert_mean(image, np.exp(-sigma * h * np.exp(-z0 / h)), rounding=1e-3, most=0.01)


def test_world_volume_that_varies_is_that_of_a_box_around():
    code = Code()
    p = code.run("position")
    inside = inside_box(code, (-1, -0.7, -0.5), (0.8, 1, 0.6))
    wave = code.run("multiply_add", code.run("sine", p), code.constant(0.4), code.constant(0.5))
    thick = code.run("multiply", inside, wave)
    scattered, absorbed = (
        code.run("multiply", thick, code.constant(v)) for v in ((1, 2, 4), (0.5, 0.2, 0.1))
    )
    closure = d.VolumeClosure(program=medium(code, scattered, absorbed, thick, a=code.constant(0.5)))
    view = perspective((0.2, -3, 0.7), (0, 0, 0), 0.4, clip_end=20.0)  # so far the world is bounded
    world = Scene(view, SKY, world_volume=(closure,))
    mesh = Scene(view, SKY).add(box((-1.1, -1.1, -1.1), (1.1, 1.1, 1.1)), None, (closure,))
    one, other = (moments(s, SEEDS, 96, 6, 12, seed=100 * k) for k, s in enumerate((world, mesh)))
    assert_same(one, other, SEEDS, error=0.006)


# --- Far away


@cache
def burning_at(at, majorant, seed):
    return moments(burning(at), SEEDS, 24, 6, 12, seed=seed, majorant=majorant, **BOX_FILTER)


@pytest.mark.parametrize("at", [(1e6, 0, 0), (-3e5, 1e6, 7e5)], ids=str)
@pytest.mark.parametrize("majorant", choices("majorant"))
def test_scene_far_from_the_origin_is_the_same(at, majorant):
    assert_same(burning_at((0, 0, 0), majorant, 0), burning_at(at, majorant, 100), SEEDS, error=0.012)
