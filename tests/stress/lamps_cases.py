# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: from 1e-20 to 1e20 W, from 1e-6 to 1e6 m wide, none and ten thousand, and wherever they should not
be."""

import numpy as np
from judge import ANALOG, TRACKED, Case, Twin
from nephele import description as d
from stages import block, floor, smoke, stage, vdb
from truth import Scene, box, diffuse, emission, facing, perspective, placed, sphere

PLAIN = Twin(settings={"integrator": "plain"})
ALBEDO = 0.7


def ball(power, radius, height):
    return d.Light("ball", "point", placed(0, 0, height), (power,) * 3, radius=radius)


def disc(radius, height, radiance=1.0):
    """A disc that faces the floor. Its power is what gives it this radiance."""
    watts = radiance * np.pi * np.pi * radius**2
    place = facing((0, 0, height), (0, 0, 0))
    return d.Light("disc", "area", place, (watts,) * 3, shape="ellipse", size=(2 * radius, 2 * radius))


def dome(radius, height, radiance=1.0):
    """A glowing ball, as a mesh; radiance as it is."""
    return sphere(radius, 4, "glowing"), emission(radiance), placed(0, 0, height)


def many(count):
    """Bare points over the floor, at 1 m, on a grid of 2 m; each of as many W as there are metres to it."""
    side = round(count**0.5)
    x = np.linspace(-1, 1, side)
    spots = [(a, b) for a in x for b in x]
    lights = tuple(
        d.Light(f"point {i}", "point", placed(a, b, 1), (4 * np.pi,) * 3) for i, (a, b) in enumerate(spots)
    )
    squares = np.array([1 + a * a + b * b for a, b in spots])
    return lights, float((squares**-1.5).sum())  # irradiance below the middle, I = 1 W/sr


MANY, MANY_IRRADIANCE = many(10_000)


def lamp_in_smoke(sigma_t, radius):
    """A ball lamp in the densest voxel of a grid, seen through some depths of it."""

    def spike(_):
        values = np.ones((9, 9, 9))
        values[4, 4, 4] = 1e4
        return values

    lamp = d.Light("in the voxel", "point", placed(0, 0, 0), (100.0,) * 3, radius=radius)
    return smoke(vdb(spike), 9, 0.9 * sigma_t, 0.1 * sigma_t, world=None, beam=(0.4, 0.3), lights=(lamp,))


def wall_lit_from(place, radius=0.0, kind="point"):
    """A wall at y = 1 before a camera at the origin."""
    lamp = d.Light("lamp", kind, place, (4 * np.pi,) * 3, radius=radius)
    scene = Scene(perspective((0, 0, 0), (0, 1, 0), 5e-4), lights=(lamp,))
    return scene.add(box((-9, 1, -9), (9, 2, 9), "wall"), diffuse(ALBEDO))


def glowing_floor(radius, height):
    mesh, surface, place = dome(radius, height)
    return floor(ALBEDO, (), height).add(mesh, surface, (), place)


def lamp_on_floor(kind, z=0.0, **more):
    """A lamp that lies in the floor, or next to it, and shines upwards."""
    up = facing((0.3, 0.2, z), (0.3, 0.2, z + 1))
    return floor(ALBEDO, (d.Light("lamp", kind, up, (10.0,) * 3, **more),), size=1.0)


CASES = [
    # Watts: the picture is in proportion.
    *(
        Case(
            f"stage of {power:g} W",
            lambda power=power: stage(power=power),
            Twin(stage, scale=power),
            TRACKED if power in (1e-20, 1e20) else ("default", "field"),
            samples=128,
            most=0.05,
            rounding=1e-5,
            cpu=20,
            quick=power == 1e20,
        )
        for power in (1e-20, 1e-10, 1e10, 1e15, 1e20)
    ),
    # A ball of radius r at distance h: E = I / h^2, whatever r is.
    *(
        Case(
            f"ball of {2 * r:g} m",
            lambda r=r, h=h: floor(ALBEDO, (ball(4 * np.pi**2 * h * h, r, h),), h),
            ALBEDO,
            ("default", "field"),
            rounding=1e-4,
            quick=r == 5e-7,
        )
        for r, h in ((5e-7, 1.0), (5e-7, 1e3), (5e-4, 1.0), (0.5, 1.0), (0.99, 1.0), (5e2, 1e3), (5e5, 1e6))
    ),
    # A disc of radiance 1: E = pi r^2 / (r^2 + h^2).
    *(
        Case(
            f"disc of {2 * r:g} m at {h:g} m",
            lambda r=r, h=h: floor(ALBEDO, (disc(r, h),), h),
            ALBEDO * r * r / (r * r + h * h),
            ("default", "field"),
            rounding=2e-4,
            most=0.05,
        )
        for r, h in ((5e-7, 1.0), (0.5, 1.0), (5e5, 1.0), (5e5, 1e-3), (5e5, 1e6), (5e-7, 1e-6))
    ),
    # The same as meshes: a ball of radiance 1 gives E = pi (r / h)^2. Its facets lie inside of it.
    *(
        Case(
            f"glowing mesh of {2 * r:g} m",
            lambda r=r, h=h: glowing_floor(r, h),
            ALBEDO * (r / h) ** 2,
            ("default", "field"),
            rounding=6e-3,
            samples=128,
            most=0.05,
        )
        for r, h in ((5e-5, 1e-4), (0.5, 1.0), (5e5, 1e6))
    ),
    # None, and ten thousand.
    Case("no light", lambda: block(1.0, 0.1, world=None), 0.0, TRACKED, quick=True),
    Case("no light on a floor", lambda: floor(ALBEDO, ()), 0.0, ("default", "field")),
    Case(
        "lights of no power",
        lambda: floor(ALBEDO, (ball(0, 0.1, 1), disc(1, 1, 0.0))),
        0.0,
        ("default", "field"),
    ),
    Case(
        "10,000 lights",
        lambda: floor(ALBEDO, MANY),
        ALBEDO / np.pi * MANY_IRRADIANCE,
        ("default", "field"),
        samples=256,
        quick=True,
    ),
    Case(
        "10,000 lights in fog",
        lambda: block(0.3, 0.05, 1.0, None, MANY),
        Twin(settings=ANALOG),
        ("default", "exact", "field"),
        samples=256,
        most=0.15,
        cpu=40,
    ),
    # Where no light should stand.
    *(
        Case(
            f"lamp of {r:g} m in the densest voxel, {s:g}/m",
            lambda s=s, r=r: lamp_in_smoke(s, r),
            PLAIN,
            TRACKED,
            size=8,
            samples=128,
            most=0.2,
            cpu=60,
        )
        for s, r in ((1e-4, 0.8), (1e-3, 2.0))
    ),
    Case("bare lamp in the densest voxel", lambda: lamp_in_smoke(1e-3, 0.0), None, TRACKED),
    Case(
        "point at the camera",
        lambda: wall_lit_from(placed(0, 0, 0)),
        ALBEDO / np.pi,
        ("default", "field"),
        quick=True,
    ),
    Case(
        "ball around the camera",
        lambda: wall_lit_from(placed(0, 0, 0), 0.5),
        ALBEDO / np.pi,
        ("default", "field"),
        rounding=1e-4,
    ),
    Case("point on the wall", lambda: wall_lit_from(placed(0, 1, 0)), None, ("default", "field")),
    Case(
        "point a float before the wall",
        lambda: wall_lit_from(placed(0, 1 - 6e-8, 0)),
        None,
        ("default", "field"),
    ),
    Case(
        "ball half in the wall",
        lambda: wall_lit_from(placed(0.3, 1, 0), 0.1),
        PLAIN,
        ("default", "field"),
        samples=512,
        most=0.2,
    ),
    Case(
        "ball around the wall",
        lambda: wall_lit_from(placed(0, 1, 0), 20.0),
        ALBEDO / np.pi / 400,
        ("default", "field"),
        rounding=1e-4,
    ),
    Case("area lamp in the floor", lambda: lamp_on_floor("area"), 0.0, ("default", "field")),
    Case("area lamp just under the floor", lambda: lamp_on_floor("area", -1e-6), 0.0, ("default", "field")),
    Case("spot in the floor", lambda: lamp_on_floor("spot", radius=0.0), 0.0, ("default", "field")),
    Case("lamp of no size", lambda: lamp_on_floor("area", 0.5, size=(0.0, 1.0)), 0.0, ("default",)),
    Case(
        "spread of nothing",
        lambda: floor(
            ALBEDO,
            (d.Light("beam", "area", facing((0, 0, 1), (0, 0, 0)), (np.pi,) * 3, size=(1, 1), spread=0.0),),
        ),
        ALBEDO,
        ("default",),
    ),
]
