# SPDX-License-Identifier: GPL-3.0-or-later
"""A fluid domain as users have it: a mesh with a FLUID modifier and a cache on disk, moved and turned.

The cache (20 x 20 x 32 cells of 10 cm, frames 23 and 24) is what smoke/bake.sh baked, untouched. Its files
stand in the domain's own space: cell (i, j, k) is centred at domain minimum + (i, j, k) + 1/2 cells.

The modifier is off in the viewport and on for rendering: the solver of the bpy modules is broken, and a file
whose domain is on prints tracebacks when such a module opens it and aborts the process at its exit. The cache
type is "ALL" because Blender deletes the files of a "REPLAY" cache when a setting changes.
Writes fluid.blend beside this file; never touches cache/.
"""

import json
import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402

FRAMES = (23, 24)
CELLS = 32  # along the longest side


def add_domain(material):
    """The mesh with its modifier, over the box of the bake, then moved and turned about the vertical."""
    box = json.loads((FOLDER / "cache" / "domain.json").read_text(encoding="utf-8"))
    mesh = common.box_mesh("Domain", box["min"], box["max"])
    domain = common.link("Domain", mesh, (0.3, 0.2, 0.05), material)
    domain.rotation_euler = (0, 0, np.radians(25.0))

    modifier = domain.modifiers.new("Fluid", "FLUID")
    modifier.show_viewport = False  # before anything else can start the solver
    modifier.fluid_type = "DOMAIN"
    settings = modifier.domain_settings
    settings.domain_type = "GAS"
    settings.cache_type = "ALL"
    settings.cache_directory = "//cache"
    settings.cache_frame_start, settings.cache_frame_end = 1, FRAMES[-1]
    settings.cache_data_format = "OPENVDB"
    settings.resolution_max = CELLS
    settings.use_noise = False
    return domain


def main():
    """Write the scene."""
    scene = common.new_scene((128, 160), 64)
    scene.frame_start, scene.frame_end = FRAMES
    scene.frame_current = FRAMES[-1]
    shading.set_world((0.03, 0.04, 0.06))
    smoke = shading.volume_material(
        "Smoke",
        ("ShaderNodeVolumePrincipled", {"Color": (0.7, 0.7, 0.7), "Density": 8.0, "Anisotropy": 0.0}),
    )
    add_domain(smoke)
    stone, _ = shading.surface_material("Stone", "ShaderNodeBsdfDiffuse", Color=(0.4, 0.4, 0.4))
    common.link("Floor", common.box_mesh("Floor", (-6, -6, -0.2), (6, 6, 0.0)), material=stone)
    common.add_light("AREA", "Window", (-3.0, -2.0, 3.0), 300.0, (1, 0.95, 0.9), (0, 0, 1.2), size=1.5)
    common.add_camera((0.0, -7.5, 1.6), (0.2, 0.0, 1.4), 55.0)
    print(common.save(FOLDER))


main()
