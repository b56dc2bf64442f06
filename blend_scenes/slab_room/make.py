# SPDX-License-Identifier: GPL-3.0-or-later
"""A foggy Cornell-like room seen from inside its fog: every kind of surface, one emissive ceiling panel.

Room 2 m wide, 2 m high, 3 m deep, filled with homogeneous fog (extinction 0.25 per metre, albedo 0.9,
g = 0.3) bounded by a mesh box a little inside the walls; the camera stands in the fog.
Writes slab_room.blend beside this file.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402


def woven_image():
    """Diagonal bands of three colours with a fine weave, 64 x 64, display-referred."""
    rows, columns = np.indices((64, 64))
    palette = np.array([(0.85, 0.75, 0.25), (0.15, 0.45, 0.60), (0.85, 0.35, 0.25)])
    bands = palette[((rows + columns) // 11) % 3]
    weave = 0.85 + 0.15 * np.sin(rows * np.pi / 2) * np.sin(columns * np.pi / 2)
    return bands * weave[..., None]


def add_room():
    """Floor, ceiling, back and front walls white; left red, right green; panels 5 cm thick."""
    white, _ = shading.surface_material("White", "ShaderNodeBsdfDiffuse", Color=(0.73, 0.73, 0.73))
    red, _ = shading.surface_material("Red", "ShaderNodeBsdfDiffuse", Color=(0.63, 0.06, 0.05))
    green, _ = shading.surface_material("Green", "ShaderNodeBsdfDiffuse", Color=(0.12, 0.45, 0.09))
    thick = 0.05
    for name, low, high, material in (
        ("Floor", (-1, -1.5, -thick), (1, 1.5, 0), white),
        ("Ceiling", (-1, -1.5, 2), (1, 1.5, 2 + thick), white),
        ("Back", (-1, 1.5, 0), (1, 1.5 + thick, 2), white),
        ("Front", (-1, -1.5 - thick, 0), (1, -1.5, 2), white),
        ("Left", (-1 - thick, -1.5, 0), (-1, 1.5, 2), red),
        ("Right", (1, -1.5, 0), (1 + thick, 1.5, 2), green),
    ):
        common.link(name, common.box_mesh(name, low, high), material=material)

    glow, _ = shading.surface_material("Glow", "ShaderNodeEmission", Color=(1.0, 0.88, 0.7), Strength=9.0)
    common.link(
        "Ceiling light", common.box_mesh("Ceiling light", (-0.4, 0.0, 1.96), (0.4, 0.7, 1.98)), material=glow
    )


def add_objects():
    """Rough metal block, glass ball, and a ball of Principled plastic under an image texture."""
    metal, _ = shading.surface_material(
        "Brushed metal", "ShaderNodeBsdfAnisotropic", Color=(0.9, 0.85, 0.75), Roughness=0.3
    )
    block = common.link(
        "Block", common.box_mesh("Block", (-0.28, -0.28, 0), (0.28, 0.28, 1.1)), material=metal
    )
    block.location, block.rotation_euler = (-0.45, 0.75, 0.0), (0, 0, 0.32)

    glass, _ = shading.surface_material(
        "Glass", "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.5
    )
    common.link("Glass ball", common.sphere_mesh("Glass ball", 0.32), (0.42, 0.15, 0.321), glass)

    plastic, shader = shading.surface_material(
        "Plastic", Roughness=0.25, Coat_Weight=0.5, Coat_Roughness=0.05
    )
    shading.textured(plastic, shader, shading.pack_image("woven", woven_image(), "sRGB"))
    common.link("Woven ball", common.sphere_mesh("Woven ball", 0.24), (-0.30, -0.10, 0.241), plastic)
    stand = common.link("Stand", common.box_mesh("Stand", (-0.2, -0.2, 0), (0.2, 0.2, 0.7)), material=plastic)
    stand.location, stand.rotation_euler = (0.55, 1.0, 0.0), (0, 0, -0.4)


def main():
    """Write the scene."""
    common.new_scene((128, 128), 64)
    shading.set_world((0, 0, 0))
    add_room()
    add_objects()
    fog = shading.volume_material(
        "Fog",
        ("ShaderNodeVolumeScatter", {"Color": (0.9, 0.9, 0.9), "Density": 0.25, "Anisotropy": 0.3}),
    )
    common.link("Fog", common.box_mesh("Fog", (-0.995, -1.495, 0.002), (0.995, 1.495, 1.995)), material=fog)
    common.add_camera((0.0, -1.42, 0.95), (0.0, 1.0, 0.72), 25.0)
    print(common.save(FOLDER))


main()
