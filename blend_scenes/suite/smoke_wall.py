# SPDX-License-Identifier: GPL-3.0-or-later
"""White smoke from three bowls before a wall of painted tiles (a packed image), in a low sun (the plumes of
../smoke, extinction 13 per metre at full density, albedo 0.82, g = 0.35)."""

import common
import numpy as np
import shading
from props import add_sun, box, cloud, matt, sun_from
from shapes import lathe_mesh, shared

BOUNCES = 32


def tile_image():
    """One tile, 128 x 128, display-referred: petals in a ring, corners that meet to a star, joints."""
    y, x = (np.indices((128, 128)) + 0.5) / 128 * 2 - 1
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    image = np.full((128, 128, 3), (0.90, 0.88, 0.82))
    blue, sky, gold = (0.10, 0.20, 0.50), (0.42, 0.60, 0.80), (0.86, 0.62, 0.18)
    corner = np.hypot(np.abs(x) - 1, np.abs(y) - 1)
    for colour, where in (
        (sky, np.abs(radius - 0.78) < 0.05),
        (blue, radius < 0.62 * np.abs(np.cos(2 * angle)) ** 0.6),
        (gold, radius < 0.34 * np.abs(np.sin(2 * angle)) ** 0.6),
        (blue, corner < 0.45 + 0.1 * np.cos(8 * np.arctan2(np.abs(y) - 1, np.abs(x) - 1))),
        (gold, corner < 0.2),
        ((0.55, 0.52, 0.48), np.maximum(np.abs(x), np.abs(y)) > 0.97),
    ):
        image[where] = colour
    return image


def build():
    shading.set_world((0.30, 0.42, 0.62), 0.3)
    tiles, shader = shading.surface_material("Tiles", Roughness=0.25)
    # Between texels, the renderers mix light (here) and sRGB codes (Cycles).
    shading.textured(tiles, shader, shading.pack_image("tile", tile_image(), "sRGB"), interpolation="Closest")
    wall = common.mesh_from_arrays(
        "Wall", [(-4, 0, 0.5), (4, 0, 0.5), (4, 0, 4.5), (-4, 0, 4.5)], [(0, 1, 2, 3)]
    )
    uvs = np.array((0, 0, 10, 0, 10, 5, 0, 5), np.float32)
    wall.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs)
    common.link("Wall", wall, (0, 1.2, 0), tiles)
    stone, plaster = matt("Stone", 0.38, 0.34, 0.29), matt("Plaster", 0.62, 0.50, 0.36)
    box("Plinth", (-4, 1.12, 0), (4, 1.5, 0.5), stone)
    box("Coping", (-4, 1.1, 4.5), (4, 1.5, 4.8), plaster)
    box("Pavement", (-8, -9, -0.2), (8, 1.5, 0), stone)

    clay, _ = shading.surface_material("Clay", Base_Color=(0.42, 0.15, 0.07), Roughness=0.55)
    bowl = lathe_mesh(
        "Bowl", [(0, 0), (0.16, 0), (0.36, 0.3), (0.38, 0.42), (0.33, 0.42), (0.3, 0.3), (0, 0.1)]
    )
    smoke = cloud("Smoke", (0.82, 0.82, 0.82), 13.0, 0.35)
    for i, (x, y, frame, turn, scale) in enumerate(
        ((-1.75, 0.2, 2, 0.4, 1.05), (0.15, -0.3, 1, 2.2, 1.0), (1.9, 0.3, 2, 4.0, 0.9))
    ):
        shared(f"Bowl {i + 1}", bowl, (x, y, 0), clay)
        plume = common.add_volume(f"Plume {i + 1}", f"//../smoke/smoke_000{frame}.vdb", smoke, (x, y, 0.12))
        plume.rotation_euler, plume.scale = (0, 0, turn), (scale,) * 3
    add_sun(sun_from(215.0, 34.0), 6.5, (1.0, 0.80, 0.56))
    common.add_camera((0.7, -6.6, 1.6), (0.05, 0.8, 1.75), 38.0)
