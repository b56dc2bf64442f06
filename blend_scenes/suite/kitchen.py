# SPDX-License-Identifier: GPL-3.0-or-later
"""A kitchen in the morning: steam (noise, extinction up to 9 per metre, albedo 1) over a pot, sun and sky
through a window, tiles, glass bottles, copper and steel."""

import common
import numpy as np
import shading
from nodes import ShaderNodes
from props import add_sun, box, matt, sun_from
from shapes import lathe_mesh, rod, shared

BOUNCES = 24
TURNED = {  # what is turned on a lathe: (radius, height), from the foot to the lip and down inside
    "Hob": [(0, 0), (0.2, 0), (0.2, 0.025), (0, 0.025)],
    "Pot": [
        (0, 0),
        (0.17, 0),
        (0.17, 0.2),
        (0.185, 0.21),
        (0.165, 0.21),
        (0.16, 0.2),
        (0.16, 0.02),
        (0, 0.02),
    ],
    "Soup": [(0, 0), (0.159, 0)],
    "Bottle": [(0, 0), (0.048, 0), (0.048, 0.17), (0.016, 0.23), (0.014, 0.29), (0.018, 0.3), (0, 0.3)],
    "Jar": [(0, 0), (0.06, 0), (0.065, 0.02), (0.065, 0.14), (0.05, 0.17), (0, 0.17)],
    "Kettle": [(0, 0), (0.12, 0.02), (0.10, 0.14), (0.05, 0.2), (0.02, 0.21), (0.025, 0.24), (0, 0.25)],
    "Bowl": [(0, 0.005), (0.05, 0), (0.12, 0.07), (0.115, 0.07), (0.05, 0.012), (0, 0.012)],
}


def steam():
    """Two rising wisps of noise that fade out towards the top and the sides."""
    n = ShaderNodes("Steam")
    place = n.coordinate()
    x, y, z = (n.axis(place, axis) for axis in "XYZ")
    aside = n.math("SQRT", n.math("ADD", n.math("MULTIPLY", x, x), n.math("MULTIPLY", y, y)))
    width = n.map_range(z, 0.0, 0.7, 0.10, 0.19)
    inside = n.map_range(n.math("DIVIDE", aside, width), 0.35, 1.0, 1.0, 0.0)
    fade = n.math("MULTIPLY", n.map_range(z, 0.02, 0.7, 1.0, 0.0), inside)
    drift = n.vector("MULTIPLY", place, (1.0, 1.0, 0.45))
    curl = n.node("TexNoise", Vector=drift, Scale=9.0, Detail=2.0, Distortion=0.8)
    density = n.math("MULTIPLY", n.math("MULTIPLY", n.map_range(curl, 0.45, 0.75, 0.0, 1.0), fade), 60.0)
    return n.finish(n.node("VolumeScatter", Color=(1, 1, 1), Density=density, Anisotropy=0.5))


def tile_image():
    """Green tiles, one of them cream here and there; display-referred, 8 x 4 tiles."""
    rows, columns = np.indices((32 * 4, 16 * 8))
    tone = np.random.default_rng(1).uniform(0.86, 0.93, (4, 8))[rows // 32, columns // 16]
    image = tone[..., None] * np.array((0.36, 0.50, 0.50))
    image[((rows // 32) * 3 + columns // 16) % 7 == 0] = (0.80, 0.78, 0.70)
    image[(rows % 32 < 2) | (columns % 16 < 1)] = (0.62, 0.60, 0.56)
    return image


def room(plaster, wood):
    """Walls with a window in the left one, a tiled back wall, worktop and shelf."""
    tiles, shader = shading.surface_material("Tiles", Roughness=0.15)
    # Between texels, the renderers mix light (here) and sRGB codes (Cycles).
    shading.textured(
        tiles, shader, shading.pack_image("tiles", tile_image(), "sRGB"), interpolation="Closest"
    )
    back = common.mesh_from_arrays(
        "Tiled wall", [(-1.6, 0, 0.9), (1.6, 0, 0.9), (1.6, 0, 2.5), (-1.6, 0, 2.5)], [(0, 1, 2, 3)]
    )
    back.uv_layers.new(name="UVMap").data.foreach_set("uv", np.array((0, 0, 2, 0, 2, 2, 0, 2), np.float32))
    common.link("Tiled wall", back, material=tiles)
    box("Back", (-1.75, 0.01, 0), (1.75, 0.15, 2.7), plaster)
    box("Right", (1.6, -3.0, 0), (1.75, 0.01, 2.7), plaster)
    box("Behind", (-1.75, -3.15, 0), (1.75, -3.0, 2.7), plaster)
    box("Ceiling", (-1.75, -3.15, 2.5), (1.75, 0.15, 2.7), plaster)
    box("Floor", (-1.75, -3.15, -0.1), (1.75, 0.15, 0), matt("Boards", 0.25, 0.14, 0.07))
    for name, low, high in (
        ("below", (-3.15, 0.0), (0.15, 1.05)), ("above", (-3.15, 2.35), (0.15, 2.7)),
        ("near", (-3.15, 1.05), (-1.5, 2.35)), ("far", (-0.3, 1.05), (0.15, 2.35)),
    ):  # fmt: skip
        box(f"Window wall {name}", (-1.75, low[0], low[1]), (-1.6, high[0], high[1]), plaster)
    box("Frame", (-1.72, -0.58, 1.05), (-1.66, -0.54, 2.35), wood)
    box("Cupboard", (-1.6, -0.6, 0), (1.6, 0, 0.86), matt("Cupboard", 0.16, 0.26, 0.24))
    top, _ = shading.surface_material("Worktop", Base_Color=(0.34, 0.19, 0.09), Roughness=0.3)
    box("Worktop", (-1.6, -0.65, 0.86), (1.6, 0, 0.9), top)
    box("Shelf", (-0.2, -0.25, 1.62), (1.5, 0, 1.65), wood)


def build():
    shading.set_world((0.55, 0.75, 1.0), 1.0)
    add_sun(sun_from(205.0, 22.0), 24.0, (1.0, 0.84, 0.62))
    sky = {"shape": "RECTANGLE", "size": 1.3, "size_y": 1.2}
    common.add_light("AREA", "Sky", (-1.85, -0.9, 1.7), 75.0, (0.66, 0.82, 1.0), (0.0, -0.9, 1.55), **sky)
    plaster, wood = matt("Plaster", 0.74, 0.70, 0.62), matt("Oak", 0.42, 0.26, 0.13)
    room(plaster, wood)
    steel, _ = shading.surface_material("Steel", Base_Color=(0.70, 0.70, 0.72), Metallic=1.0, Roughness=0.18)
    copper, _ = shading.surface_material(
        "Copper", Base_Color=(0.93, 0.55, 0.38), Metallic=1.0, Roughness=0.25
    )
    glass, _ = shading.surface_material("Glass", "ShaderNodeBsdfGlass", Color=(0.96, 1, 0.97), IOR=1.45)
    green, _ = shading.surface_material(
        "Green glass", "ShaderNodeBsdfGlass", Color=(0.35, 0.7, 0.3), IOR=1.45
    )
    black, white = matt("Iron", 0.03, 0.03, 0.03), matt("Porcelain", 0.8, 0.78, 0.74)

    for name, x, y, z, material in (
        ("Hob", -0.35, -0.33, 0.9, black),
        ("Pot", -0.35, -0.33, 0.925, copper),
        ("Soup", -0.35, -0.33, 1.08, matt("Soup", 0.5, 0.16, 0.04)),
        ("Bottle", 0.42, -0.18, 0.9, green),
        ("Bottle", 0.56, -0.24, 0.9, glass),
        ("Jar", 0.30, -0.30, 0.9, glass),
        ("Jar", 0.05, -0.13, 1.65, white),
        ("Jar", 0.25, -0.13, 1.65, glass),
        ("Jar", 0.45, -0.13, 1.65, copper),
        ("Kettle", 0.86, -0.3, 0.9, steel),
        ("Bowl", -0.85, -0.36, 0.9, white),
    ):
        common.link(name, lathe_mesh(name, TURNED[name], 48), (x, y, z), material)
    rod("Handle", (-0.18, -0.33, 1.1), (0.06, -0.42, 1.12), 0.012, black)
    cloud = common.box_mesh("Steam", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.7))
    common.link("Steam", cloud, (-0.35, -0.33, 1.085), steam())
    lemon, yellow = common.sphere_mesh("Lemon", 0.042, 24, 12), matt("Lemon", 0.75, 0.55, 0.06)
    for i, (x, y) in enumerate(((-0.88, -0.38), (-0.81, -0.34), (-0.86, -0.31))):
        shared(f"Lemon {i + 1}", lemon, (x, y, 0.955), yellow)
    common.add_camera((0.15, -1.95, 1.42), (-0.05, -0.2, 1.2), 28.0)
