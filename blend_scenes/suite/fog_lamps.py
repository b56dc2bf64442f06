# SPDX-License-Identifier: GPL-3.0-or-later
"""A funfair at night in thin fog (extinction 0.02 per metre, albedo 0.95, g = 0.6): 58 coloured lamps, 25 of
them mere points, on a big wheel, over booths and along a path."""

import common
import numpy as np
import shading
from props import box, matt
from shapes import lathe_mesh, rod

BOUNCES = 16
COLOURS = ((1.0, 0.16, 0.08), (1.0, 0.66, 0.18), (0.18, 0.9, 0.35), (0.15, 0.45, 1.0), (0.9, 0.2, 0.85))
HUB, RADIUS = np.array((1.6, 17.0, 6.4)), 5.4


def lamp(name, place, watts, colour, radius):
    common.add_light("POINT", name, tuple(place), watts, colour, shadow_soft_size=radius)


def wheel(iron):
    """Two rims, sixteen spokes, cabins, 32 lamps."""
    for i, away in enumerate((-0.35, 0.35)):
        rim = lathe_mesh("Rim", [(RADIUS, -0.06), (RADIUS + 0.12, 0), (RADIUS, 0.06), (RADIUS, -0.06)], 64)
        common.link(f"Rim {i + 1}", rim, tuple(HUB + np.array((0, away, 0))), iron).rotation_euler = (
            np.pi / 2,
            0,
            0,
        )
    cabin = matt("Cabin", 0.5, 0.42, 0.36)
    for i in range(16):
        angle = 2 * np.pi * (i + 0.3) / 16
        out = np.array((np.cos(angle), 0, np.sin(angle)))
        rod(f"Spoke {i + 1}", tuple(HUB), tuple(HUB + RADIUS * out), 0.035, iron)
        x, y, z = HUB + (RADIUS + 0.1) * out
        box(f"Cabin {i + 1}", (x - 0.4, y - 0.3, z - 0.85), (x + 0.4, y + 0.3, z - 0.25), cabin)
        for k, share in enumerate((0.55, 1.04)):
            colour = COLOURS[(i + 2 * k) % len(COLOURS)]
            place = HUB + share * RADIUS * out + (0, -0.55, 0)
            lamp(f"Wheel lamp {i + 1}.{k + 1}", place, 90.0 + 60.0 * k, colour, 0.07 * k)
    for side in (-1, 1):
        foot = HUB * (1, 1, 0) + (2.6 * side, 0, 0)
        rod(f"Leg {side}", tuple(foot), tuple(HUB), 0.14, iron)


def booth(number, x, y, turn, stripe, lit):
    """A counter under a roof with five bulbs along its eave."""
    box(f"Counter {number}", (x - 1.3, y - 0.7, 0), (x + 1.3, y + 0.7, 1.0), stripe, turn)
    box(
        f"Back {number}",
        (x - 1.3, y - 0.8, 1.0),
        (x + 1.3, y + 0.8, 2.2),
        matt("Boards", 0.3, 0.2, 0.13),
        turn,
    )
    roof = [(2.1, 0), (1.7, 0.35), (0, 1.1)]
    common.link(f"Roof {number}", lathe_mesh("Roof", roof, 8), (x, y, 2.2), stripe)
    for i in range(5):
        along, out = -1.2 + 0.6 * i, -1.35
        place = (
            x + along * np.cos(turn) - out * np.sin(turn),
            y + along * np.sin(turn) + out * np.cos(turn),
            2.12,
        )
        lamp(f"Bulb {number}.{i + 1}", place, 22.0, lit, 0.03 * (i % 2))


def build():
    shading.set_world((0.004, 0.006, 0.014))
    iron, _ = shading.surface_material("Iron", Base_Color=(0.3, 0.3, 0.32), Metallic=0.0, Roughness=0.4)
    wet, _ = shading.surface_material("Wet ground", Base_Color=(0.06, 0.055, 0.05), Roughness=0.16)
    box("Ground", (-22, -8, -0.2), (22, 34, 0), wet)
    wheel(iron)
    red, blue, gold = matt("Red", 0.6, 0.08, 0.06), matt("Blue", 0.1, 0.2, 0.5), matt("Gold", 0.6, 0.42, 0.1)
    booth(1, -4.6, 7.0, 0.5, red, (1.0, 0.75, 0.4))
    booth(2, 4.9, 9.0, -0.6, blue, (0.75, 0.9, 1.0))
    booth(3, -5.8, 13.5, 0.3, gold, (1.0, 0.55, 0.75))
    for i in range(8):
        x, y = (-2.4, 2.6)[i % 2], 6.0 + 2.8 * (i // 2)
        rod(f"Post {i + 1}", (x, y, 0), (x, y, 2.5), 0.04, iron)
        lamp(f"Post lamp {i + 1}", (x, y, 2.62), 26.0, (1.0, 0.72, 0.42), 0.05)
    for i, (x, y) in enumerate(((-1.0, 15.0), (4.2, 15.5), (0.2, 12.5))):
        beam = {"spot_size": np.radians(24.0), "spot_blend": 0.4, "shadow_soft_size": 0.05}
        colour, target = COLOURS[(3, 4, 1)[i]], (x + (-3.0, 3.2, 0.5)[i], y + 6.0, 14.0)
        common.add_light("SPOT", f"Beam {i + 1}", (x, y, 0.3), 2500.0, colour, target, **beam)
    inputs = {"Color": (0.95, 0.95, 0.95), "Density": 0.02, "Anisotropy": 0.6}
    box(
        "Fog",
        (-21, -7, -0.1),
        (21, 33, 16),
        shading.volume_material("Fog", ("ShaderNodeVolumeScatter", inputs)),
    )
    common.add_camera((-0.6, -3.2, 1.5), (0.5, 10.0, 4.0), 24.0)
