# SPDX-License-Identifier: GPL-3.0-or-later
"""Paper lanterns that rise into a cloud at dusk, above a lake (../cloud/cloud.vdb, extinction up to 5 per
metre, albedo 0.98, g = 0.6): fourteen glowing meshes, most of them inside, and eight sparks that are point
lamps."""

import common
import numpy as np
import shading
from nodes import ShaderNodes
from noise import fractal, gradient_noise
from props import box, cloud, matt, sun_from
from shapes import lathe_mesh, shared

BOUNCES = 64
PAPER = [(0.105, 0.0), (0.15, 0.12), (0.165, 0.24), (0.14, 0.36), (0.08, 0.42), (0.0, 0.44)]
PLACES = (
    (-1.9, -0.6, 0.5), (-1.1, 0.1, 0.9), (-0.5, -0.5, 0.55), (0.0, 0.3, 1.5), (0.6, -0.2, 0.6),
    (1.0, 0.3, 1.1), (1.7, -0.4, 0.45), (-0.6, 0.2, 1.9), (0.3, -0.3, 2.3), (1.5, 0.9, 0.8),
    (-2.3, -2.0, -0.5), (0.4, -2.2, -0.75), (2.1, -1.6, -0.2), (-1.0, -1.2, -1.0),
)  # fmt: skip


def paper():
    """Glows most at its foot, where the flame is, and lets light through."""
    n = ShaderNodes("Paper")
    up = n.axis(n.coordinate(), "Z")
    glow = n.node("Emission", Color=(1.0, 0.42, 0.10), Strength=n.map_range(up, 0.0, 0.44, 9.0, 2.2))
    return n.finish(surface=n.add(glow, n.node("BsdfDiffuse", Color=(0.5, 0.3, 0.15))))


def shore(x, y):
    """Hills behind the lake."""
    hills = fractal(gradient_noise, np.stack([x * 0.25, y * 0.25, 0 * x], axis=1), 11, 3)
    return -2.2 + (1.5 + 2.2 * hills) * np.clip((y - 17) / 6, 0, 1)


def build():
    rng = np.random.default_rng(3)
    west = sun_from(75.0, -2.0)
    shading.set_sky(
        "dusk", (0.012, 0.03, 0.09), (0.07, 0.07, 0.12), (0.01, 0.01, 0.015), (0.30, 0.11, 0.05), west
    )
    water, _ = shading.surface_material("Lake", Base_Color=(0.01, 0.015, 0.02), Roughness=0.12)
    box("Lake", (-40, -12, -2.3), (40, 30, -2.0), water)
    hills = common.heightfield_mesh("Hills", np.linspace(-30, 30, 60), np.linspace(17, 26, 16), shore)
    common.link("Hills", hills, material=matt("Hills", 0.03, 0.035, 0.03))

    shell = lathe_mesh("Lantern", PAPER, 16)
    material = paper()
    for i, place in enumerate(PLACES):
        lantern = shared(f"Lantern {i + 1}", shell, place, material)
        lantern.rotation_euler = (*rng.uniform(-0.15, 0.15, 2), 0)
        lantern.scale = (rng.uniform(0.6, 0.9),) * 3
    for i in range(8):
        place = rng.uniform((-1.6, -0.8, 0.3), (1.7, 0.5, 2.0))
        common.add_light("POINT", f"Spark {i + 1}", tuple(place), 3.0, (1.0, 0.6, 0.25), shadow_soft_size=0.0)
    vapour = cloud("Vapour", (0.98, 0.98, 0.98), 5.0, 0.6)
    common.add_volume("Cloud", "//../cloud/cloud.vdb", vapour, (0, 0, 0)).rotation_euler = (0, 0, 0.3)
    common.add_camera((0.0, -6.4, -0.7), (0.0, 0.0, 0.45), 33.0)
