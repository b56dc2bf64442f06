# SPDX-License-Identifier: GPL-3.0-or-later
"""A camp fire at night: flames are black bodies of 800 to 2000 K (../smoke/smoke_0001.vdb, extinction 5 per
metre at full density, albedo 0.5), and light stones, logs, trees and a tent.

The light is made by nodes of the interpolated temperature; of a Principled Volume's, Cycles reads one voxel
at a time, which makes the fire brighter (docs/decisions.md)."""

import common
import numpy as np
import shading
from nodes import ShaderNodes
from noise import fractal, gradient_noise
from props import matt
from shapes import polygon_mesh, rod, shared

BOUNCES = 16


def flames():
    """Intensity sigma T^4 / pi (in MW, as Blender counts) times the black body's colour."""
    n = ShaderNodes("Smoke and fire")
    smoke = n.node("VolumePrincipled", Color=(0.5, 0.5, 0.5), Density=5.0, Anisotropy=0.3)
    kelvin = n.grid("temperature")
    power = n.math("POWER", n.math("MULTIPLY", kelvin, 1e-3), 4.0)
    strength = n.math("MULTIPLY", power, 110.0 * 5.670373e-2 / np.pi)
    return n.finish(
        n.add(smoke, n.node("Emission", Color=n.node("Blackbody", Temperature=kelvin), Strength=strength))
    )


def pebble(rng):
    """A ball that noise has pushed about."""
    ball = common.sphere_mesh("Stone", 1.0, 16, 8)
    points = np.empty(3 * len(ball.vertices), np.float32)
    ball.vertices.foreach_get("co", points)
    points = points.reshape(-1, 3)
    points = (
        points * (1 + 0.35 * fractal(gradient_noise, points * 1.4 + rng.uniform(0, 50, 3), 3, 2))[:, None]
    )
    ball.vertices.foreach_set("co", (points * (1.0, 0.85, 0.7)).astype(np.float32).ravel())
    return ball


def ground_height(x, y):
    p = np.stack([x, y, 0 * x], axis=1)
    far = np.clip(np.hypot(x, y) - 1.2, 0, 4)
    return (
        0.05 * fractal(gradient_noise, p * 1.6, 5, 3)
        + 0.12 * far * fractal(gradient_noise, p * 0.3, 6, 2)
        - 0.02
    )


def tent(cloth):
    """A ridge tent, open towards the fire."""
    p = [
        (-0.9, 0, 0),
        (0.9, 0, 0),
        (0, 0, 1.35),
        (-0.9, 2.0, 0),
        (0.9, 2.0, 0),
        (0, 2.0, 1.35),
        (-0.3, -0.1, 0),
        (-0.02, 0, 1.33),
    ]
    faces = [(0, 2, 5, 3), (1, 4, 5, 2), (3, 5, 4), (0, 6, 7)]
    common.link(
        "Tent", polygon_mesh("Tent", p, faces, smooth=False), (-2.1, 1.7, 0), cloth
    ).rotation_euler = (0, 0, 0.6)


def build():
    rng = np.random.default_rng(8)
    shading.set_sky("night", (0.003, 0.006, 0.016), (0.010, 0.016, 0.030), (0.001, 0.001, 0.001))
    n = ShaderNodes("Earth")
    tint = n.ramp(n.noise(3.0, 4.0), (0.4, (0.09, 0.06, 0.035)), (0.62, (0.16, 0.13, 0.06)))
    earth = n.finish(surface=n.node("BsdfDiffuse", Color=tint))
    half = np.sign(np.linspace(-1, 1, 41)) * np.abs(np.linspace(-1, 1, 41)) ** 1.7
    common.link(
        "Ground", common.heightfield_mesh("Ground", 14 * half, 4 + 14 * half, ground_height), material=earth
    )
    stone, bark, cloth = (
        matt("Stone", 0.30, 0.28, 0.26),
        matt("Bark", 0.20, 0.12, 0.07),
        matt("Canvas", 0.50, 0.34, 0.16),
    )
    pebbles = [pebble(rng) for _ in range(3)]
    for i in range(13):
        angle = 2 * np.pi * i / 13
        place = (0.66 * np.cos(angle), 0.66 * np.sin(angle), 0.05)
        ob = shared(f"Stone {i + 1}", pebbles[i % 3], place, stone)
        ob.rotation_euler, ob.scale = (0, 0, rng.uniform(0, 6)), (rng.uniform(0.13, 0.19),) * 3
    for i in range(6):
        angle = 1.05 * i + 0.3
        out = np.array((np.cos(angle), np.sin(angle), 0))
        rod(f"Log {i + 1}", tuple(0.5 * out + (0, 0, 0.06)), tuple(-0.08 * out + (0, 0, 0.34)), 0.055, bark)
    rod("Seat 1", (1.0, -1.05, 0.16), (1.95, 0.25, 0.17), 0.17, bark)
    rod("Seat 2", (-1.9, -0.35, 0.15), (-1.1, -1.3, 0.16), 0.16, bark)
    for i in range(16):
        x, y = rng.uniform(-6.5, 6.5), rng.uniform(3.2, 9.0)
        rod(
            f"Trunk {i + 1}",
            (x, y, -0.2),
            (x + rng.normal(0, 0.2), y, 7.5),
            rng.uniform(0.12, 0.26),
            bark,
            0.5,
        )
    tent(cloth)
    common.add_volume("Fire", "//../smoke/smoke_0001.vdb", flames(), (0, 0, 0.1)).scale = (0.6, 0.6, 0.85)
    common.add_light("SUN", "Moon", (0, 0, 9), 0.12, (0.55, 0.7, 1.0), angle=0.02).rotation_euler = (
        0.6,
        -0.7,
        0,
    )
    common.add_camera((0.5, -4.9, 1.15), (0.0, 0.6, 0.95), 32.0)
