# SPDX-License-Identifier: GPL-3.0-or-later
"""Ten clouds over mountains of 5.5 million triangles, none of them instanced. Modifiers make the triangles
when the scene is exported, so that the file stays small; the clouds are two files, each placed and lit
differently."""

import bpy
import common
import numpy as np
import shading
from nodes import ShaderNodes
from props import add_sun, cloud, sun_from
from shapes import subdivide

BOUNCES = 32
CELLS, LEVELS = (6, 7), 8  # 6 * 7 * 4^8 quads
CLOUDS = (  # file, x, y, z, turn, scale, extinction per unit
    ("cloud", -6.0, 11.0, 1.6, 0.4, 1.1, 4.0),
    ("cloud", 5.6, 14.0, 1.7, 2.6, 1.3, 3.5),
    ("cloud", 0.4, 20.0, 2.3, 1.3, 1.6, 3.0),
    ("cloud", -12.5, 20.0, 2.0, 5.0, 1.6, 3.0),
    ("cloud", 12.5, 22.0, 2.2, 3.6, 1.6, 3.0),
    ("cloud", 4.4, 6.0, 1.3, 0.9, 0.45, 7.0),
    ("sea", -2.6, 7.5, 0.0, 0.2, 0.50, 1.2),
    ("sea", 3.2, 12.5, 0.1, 1.5, 0.60, 1.0),
    ("sea", -7.0, 15.5, 0.2, 1.1, 0.60, 1.0),
    ("sea", 7.5, 6.5, 0.0, 0.7, 0.40, 1.4),
)
FILES = {"cloud": "//../cloud/cloud.vdb", "sea": "//sunset.vdb"}


def rock():
    """Snow where it is high and flat, grass where it is low, rock between."""
    n = ShaderNodes("Rock")
    height = n.axis(n.node("NewGeometry", output="Position"), "Z")
    flat = n.axis(n.node("NewGeometry", output="Normal"), "Z")
    rough = n.noise(1.5, 6.0)
    stone = n.ramp(rough, (0.35, (0.10, 0.085, 0.075)), (0.65, (0.22, 0.19, 0.17)))
    grass = n.map_range(n.math("ADD", height, rough), 0.9, 1.2, 1.0, 0.0)
    low = n.mix(grass, n.node("BsdfDiffuse", Color=stone), n.node("BsdfDiffuse", Color=(0.055, 0.09, 0.03)))
    high = n.map_range(n.math("ADD", height, n.math("MULTIPLY", flat, 1.1)), 2.1, 2.4, 0.0, 1.0)
    return n.finish(surface=n.mix(high, low, n.node("BsdfDiffuse", Color=(0.80, 0.82, 0.86))))


def ridges(name, size, strength, ob):
    """A Displace modifier of Blender's own fractal ridges."""
    texture = bpy.data.textures.new(name, "MUSGRAVE")
    texture.musgrave_type, texture.noise_scale, texture.octaves = "RIDGED_MULTIFRACTAL", size, 8.0
    texture.dimension_max, texture.noise_intensity, texture.gain = 0.9, 0.5, 2.0
    modifier = ob.modifiers.new(name, "DISPLACE")
    modifier.texture, modifier.strength, modifier.mid_level, modifier.direction = texture, strength, 0.55, "Z"
    modifier.texture_coords = "LOCAL"


def build():
    low = sun_from(160.0, 24.0)
    shading.set_sky(
        "morning", (0.10, 0.22, 0.55), (0.75, 0.72, 0.70), (0.6, 0.58, 0.56), (1.0, 0.6, 0.3), low
    )
    xs, ys = np.linspace(-15, 15, CELLS[0] + 1), np.linspace(-5, 30, CELLS[1] + 1)
    flat = common.heightfield_mesh("Mountains", xs, ys, lambda x, y: 0 * x)
    ground = subdivide(common.link("Mountains", flat, material=rock()), LEVELS)
    ridges("Ridges", 9.0, 5.5, ground)
    add_sun(low, 9.0, (1.0, 0.84, 0.64))
    for i, (file, x, y, z, turn, scale, density) in enumerate(CLOUDS):
        vapour = cloud(f"Vapour {i + 1}", (0.995, 0.995, 0.995), density, 0.7)
        volume = common.add_volume(f"Cloud {i + 1}", FILES[file], vapour, (x, y, z))
        volume.rotation_euler = (0, 0, turn)
        wide, tall = (1.0, 0.5) if file == "sea" else (1.5, 0.6)
        volume.scale = (wide * scale, scale, tall * scale)
    common.add_camera((-1.5, -4.8, 3.9), (0.5, 9.0, 1.7), 27.0)
