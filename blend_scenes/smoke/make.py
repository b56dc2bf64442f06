# SPDX-License-Identifier: GPL-3.0-or-later
"""A burning plume from a real fluid simulation (see bake.sh), two frames, lit by area, spot and itself.

Extinction 14 per metre at full density, albedo 0.6, g = 0.2; flames glow as black bodies of 800 to 2000 K.
Writes smoke.blend beside this file; the VDB sequence must be there already.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402

SIGMA_T_PER_M = 14.0


def main():
    """Write the scene."""
    scene = common.new_scene((240, 320), 64, pixel_filter="BLACKMAN_HARRIS", view_transform="AgX")
    scene.frame_start, scene.frame_end = 1, 2
    shading.set_world((0.010, 0.013, 0.020))

    fire = shading.volume_material(
        "Smoke and fire",
        (
            "ShaderNodeVolumePrincipled",
            {
                "Color": (0.6, 0.6, 0.6),
                "Density": SIGMA_T_PER_M,
                "Anisotropy": 0.2,
                "Blackbody_Intensity": 6.0,
                "Temperature": 1.0,  # multiplies the grid, which is in kelvin
            },
        ),
    )
    plume = common.add_volume("Plume", "//smoke_0001.vdb", fire)
    plume.data.is_sequence = True
    plume.data.frame_start, plume.data.frame_offset, plume.data.frame_duration = 1, 0, 2

    stone, _ = shading.surface_material("Stone", Base_Color=(0.35, 0.35, 0.37), Roughness=0.6)
    common.link("Floor", common.box_mesh("Floor", (-8, -8, -0.2), (8, 8, 0.0)), material=stone)
    brick, _ = shading.surface_material("Wall", "ShaderNodeBsdfDiffuse", Color=(0.30, 0.16, 0.12))
    common.link("Wall", common.box_mesh("Wall", (-8, 3.0, 0.0), (8, 3.2, 6.0)), material=brick)
    steel, _ = shading.surface_material("Bowl", Base_Color=(0.6, 0.6, 0.65), Metallic=1.0, Roughness=0.35)
    common.link("Bowl", common.box_mesh("Bowl", (-0.3, -0.25, 0.0), (0.3, 0.25, 0.2)), material=steel)

    window = {"shape": "RECTANGLE", "size": 1.5, "size_y": 2.0}
    common.add_light("AREA", "Window", (-3.0, -1.2, 3.0), 170.0, (0.65, 0.8, 1.0), (0, 0, 1.7), **window)
    beam = {"spot_size": np.radians(38.0), "spot_blend": 0.25, "shadow_soft_size": 0.04}
    common.add_light("SPOT", "Beam", (2.6, 1.6, 4.2), 600.0, (1.0, 0.82, 0.6), (0, 0, 1.8), **beam)
    common.add_camera((0.0, -7.4, 1.5), (0.0, 0.0, 1.45), 60.0)
    print(common.save(FOLDER))


main()
