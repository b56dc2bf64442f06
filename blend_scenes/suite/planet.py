# SPDX-License-Identifier: GPL-3.0-or-later
"""A planet with an atmosphere, from space, at its terminator; a moon. Radius 10; the air is six times as deep
as Earth's for its size: gas that scatters blue most (Rayleigh, scale height 0.08, vertical optical depth
0.05, 0.11, 0.26), absorbing ozone, and dust below (g = 0.76, scale height 0.03, vertical optical depth
0.06)."""

import common
import numpy as np
import shading
from nodes import ShaderNodes
from props import matt, sun_from
from shapes import sphere

BOUNCES = 16
RADIUS, TOP = 10.0, 0.6
GAS, DUST = 0.08, 0.03  # scale heights


def air():
    """Densities that fall off exponentially with height above the ground."""
    n = ShaderNodes("Air")
    radius = n.vector("LENGTH", n.coordinate(), output="Value")
    height = n.math("MAXIMUM", n.math("SUBTRACT", radius, RADIUS), 0.0)

    def fall(scale, depth):
        return n.math("MULTIPLY", n.math("EXPONENT", n.math("DIVIDE", height, -scale)), depth / scale)

    gas = n.node("VolumeScatter", {"phase": "RAYLEIGH"}, Color=(0.177, 0.415, 1.0), Density=fall(GAS, 0.26))
    ozone = n.node("VolumeAbsorption", Color=(0.65, 0.0, 0.955), Density=fall(GAS, 0.035))
    dust = n.node("VolumeScatter", Color=(0.95, 0.93, 0.90), Density=fall(DUST, 0.06), Anisotropy=0.76)
    return n.finish(n.add(n.add(gas, ozone), dust))


def ground():
    """Land, seas that shine, ice towards the poles, and clouds, all by noise."""
    n = ShaderNodes("Ground")
    place = n.vector("SCALE", n.coordinate())
    place.node.inputs["Scale"].default_value = 1 / RADIUS
    land = n.node("TexNoise", Vector=place, Scale=1.9, Detail=9.0, Roughness=0.58)
    soil = n.ramp(land, (0.50, (0.06, 0.10, 0.03)), (0.60, (0.26, 0.19, 0.10)), (0.72, (0.36, 0.32, 0.27)))
    shore = n.map_range(land, 0.495, 0.505, 0.0, 1.0)
    north = n.math("ABSOLUTE", n.axis(place, "Z"))
    ice = n.map_range(n.math("ADD", north, n.math("MULTIPLY", land, 0.35)), 1.02, 1.06, 0.0, 1.0)
    sea = n.node("BsdfPrincipled", Base_Color=(0.008, 0.025, 0.07), Roughness=0.28)
    bare = n.mix(shore, sea, n.node("BsdfDiffuse", Color=soil))
    stretched = n.vector("MULTIPLY", place, (1.0, 1.0, 2.2))
    swirl = n.node("TexNoise", Vector=stretched, Scale=2.6, Detail=10.0, Roughness=0.62, Distortion=0.7)
    white = n.node("BsdfDiffuse", Color=(0.80, 0.80, 0.80))
    cover = n.math("MAXIMUM", n.map_range(swirl, 0.50, 0.66, 0.0, 0.95), ice)
    return n.finish(surface=n.mix(cover, bare, white))


def build():
    shading.set_world((0, 0, 0))
    sphere("Planet", RADIUS, (0, 0, 0), ground(), 6)
    sphere("Air", RADIUS + TOP, (0, 0, 0), air(), 6)
    for body in ("Planet", "Air"):
        common.bpy.data.objects[body].rotation_euler = (0.4, 0.3, 1.9)
    sphere("Moon", 0.8, (9.6, 9.0, 8.6), matt("Regolith", 0.22, 0.21, 0.20), 4)
    sun = {"angle": np.radians(0.5)}
    common.add_light(
        "SUN", "Sun", tuple(40 * sun_from(168.0, 14.0)), 9.0, (1.0, 0.97, 0.92), (0, 0, 0), **sun
    )
    common.add_camera((0.0, -22.0, 8.0), (-1.0, 0.0, 3.6), 34.0)
