# SPDX-License-Identifier: GPL-3.0-or-later
"""Under a wavy, slightly rough water surface (IOR 1.33, roughness 0.35): ruins on the sand, the sun from
above. The water absorbs red most (sigma_a 0.14, 0.028, 0.014 per metre) and scatters forward (sigma_s 0.03, g
= 0.8)."""

import bpy
import common
import numpy as np
import shading
from nodes import ShaderNodes
from noise import fractal, gradient_noise
from props import add_sun, box, matt, sun_from
from shapes import lathe_mesh, polygon_mesh, subdivide

BOUNCES = 32
DEPTH, REACH = 5.0, 16.0


def waves(x, y):
    """Height of the surface, calm at the rim, where it meets the walls."""
    p = np.stack([x * 0.55, y * 0.8, 0 * x], axis=1)
    return DEPTH + 0.30 * fractal(gradient_noise, p, 4, 3, gain=0.45)


def water_mesh():
    """A closed block of water: waves above, a flat bottom below the sand."""
    n = 36
    axis = np.linspace(-REACH, REACH, n)
    x, y = (a.ravel() for a in np.meshgrid(axis, axis))
    top = np.stack([x, y, waves(x, y)], axis=1)
    index = np.arange(n * n).reshape(n, n)
    faces = (
        np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1)
        .reshape(-1, 4)
        .tolist()
    )
    rim = [*index[0, :-1], *index[:-1, -1], *index[-1, :0:-1], *index[:0:-1, 0]]
    bottom = top[rim] * (1, 1, 0) - (0, 0, 1.0)
    low = n * n + np.arange(len(rim))
    faces += [(low[i - 1], low[i], rim[i], rim[i - 1]) for i in range(len(rim))]
    faces.append(tuple(low[::-1]))
    return polygon_mesh("Water", np.concatenate([top, bottom]), faces)


def water():
    n = ShaderNodes("Water")
    surface = n.node("BsdfGlass", Color=(1, 1, 1), Roughness=0.35, IOR=1.33)
    absorbs = n.node("VolumeAbsorption", Color=(0.0, 0.80, 0.90), Density=0.14)
    scatters = n.node("VolumeScatter", Color=(1, 1, 1), Density=0.03, Anisotropy=0.8)
    return n.finish(n.add(absorbs, scatters), surface)


def sand_height(x, y):
    return 0.35 * fractal(gradient_noise, np.stack([x, y, 0 * x], axis=1) * 0.22, 9, 2)


def sand():
    n = ShaderNodes("Sand")
    tint = n.ramp(n.noise(1.2), (0.35, (0.42, 0.36, 0.26)), (0.65, (0.62, 0.56, 0.42)))
    return n.finish(surface=n.node("BsdfDiffuse", Color=tint))


def ripples(ob):
    """Bands that wander, by a Displace modifier."""
    texture = bpy.data.textures.new("Ripples", "WOOD")
    texture.wood_type, texture.noise_scale, texture.turbulence = "BANDNOISE", 0.9, 3.0
    bands = ob.modifiers.new("Ripples", "DISPLACE")
    bands.texture, bands.strength, bands.direction, bands.texture_coords = texture, 0.05, "Z", "LOCAL"


def column(name, height, location, tilt, stone):
    """A fluted drum on a square foot."""
    fluted = lathe_mesh(
        name,
        [
            (0, 0),
            (0.42, 0),
            (0.44, 0.12),
            (0.36, 0.2),
            (0.31, height),
            (0.42, height + 0.12),
            (0.42, height + 0.3),
            (0, height + 0.3),
        ],
        48,
    )
    points = np.array([v.co for v in fluted.vertices])
    around = np.arctan2(points[:, 1], points[:, 0])
    shaft = (points[:, 2] > 0.15) & (points[:, 2] < height + 0.05)
    points[:, :2] *= np.where(shaft, 1 + 0.05 * np.cos(12 * around), 1)[:, None]
    fluted.vertices.foreach_set("co", points.astype(np.float32).ravel())
    common.link(name, fluted, location, stone).rotation_euler = tilt


def build():
    shading.set_world((0.45, 0.65, 0.95), 1.5)
    add_sun(sun_from(70.0, 58.0), 38.0, (1.0, 0.94, 0.84))
    axis = np.linspace(-REACH - 1, REACH + 1, 28)
    ground = common.link("Sand", common.heightfield_mesh("Sand", axis, axis, sand_height), material=sand())
    subdivide(ground, 3, smooth=True)
    ripples(ground)
    rock, stone = matt("Rock", 0.10, 0.10, 0.09), matt("Marble", 0.70, 0.66, 0.58)
    for i, (x, y) in enumerate(((-1, 0), (1, 0), (0, -1), (0, 1))):
        centre, half = REACH * np.array((x, y)), np.where(np.array((x, y)) == 0, REACH + 1, 0.8)
        box(f"Wall {i + 1}", (*(centre - half), -1.5), (*(centre + half), DEPTH + 0.6), rock)
    subdivide(common.link("Water", water_mesh(), material=water()), 2, smooth=True)
    for i, (x, y, height) in enumerate(
        (
            (-2.5, 1.2, 2.6),
            (-2.3, 4.2, 2.9),
            (-2.1, 7.2, 1.3),
            (2.4, 2.2, 1.7),
            (2.5, 5.2, 2.8),
            (2.6, 8.2, 2.5),
        )
    ):
        column(f"Column {i + 1}", height, (x, y, -0.05), (0.03 * i, -0.02 * i, i), stone)
    column("Fallen column", 2.2, (-0.6, 2.6, 0.3), (1.5, 0.0, 1.1), stone)
    box("Lintel", (-2.9, 0.7, 2.95), (-1.6, 4.7, 3.3), stone)
    gold, _ = shading.surface_material("Bronze", Base_Color=(0.8, 0.5, 0.22), Metallic=1.0, Roughness=0.3)
    urn = [
        (0, 0),
        (0.14, 0),
        (0.16, 0.05),
        (0.34, 0.45),
        (0.32, 0.62),
        (0.13, 0.82),
        (0.2, 0.95),
        (0.16, 0.95),
        (0, 0.7),
    ]
    common.link("Urn", lathe_mesh("Urn", urn), (0.95, 0.6, 0.05), gold).rotation_euler = (0.35, 0.25, 0)
    common.add_camera((0.1, -4.4, 1.3), (0.1, 4.0, 2.3), 22.0)
