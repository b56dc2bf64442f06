# SPDX-License-Identifier: GPL-3.0-or-later
"""Five lamps in and about a patchy cloud, nothing else: light sampling and its weights in a thick medium.

Black world. Two point lamps glow inside the cloud and one outside it, two spots look in. A renderer that
weighs light sampling against phase sampling wrongly is off by per cents here. The lamps without size stand
outside the cloud: inside, 1/r^2 has infinite variance, and no statistical test could judge the picture.
Cloud: 64^3 voxels of 3.125 cm, extinction up to 12 per metre, chromatic albedo (0.95, 0.9, 0.8), g = 0.4.
Writes lamps.vdb and lamps.blend beside this file.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from noise import fractal, gradient_noise, smoothstep  # noqa: E402

CELLS = 64
VOXEL_M = 2.0 / CELLS
SEED = 23


def patchy_density():
    """Density in [0, 1], float32 (64, 64, 64): clots and voids within a ball of radius 0.95 m."""
    origin = np.full(3, -(CELLS - 1) / 2 * VOXEL_M)
    grid = np.stack(np.meshgrid(*(np.arange(CELLS),) * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    p = (origin + grid * VOXEL_M).astype(np.float32)
    clots = smoothstep(-0.10, 0.35, fractal(gradient_noise, p * 2.6, SEED, 3))
    ball = smoothstep(0.95, 0.65, np.linalg.norm(p, axis=1))
    density = ((0.08 + 0.92 * clots) * ball).reshape((CELLS,) * 3)
    density[density < 1 / 128] = 0
    return common.quantise(density, 128), origin


def main():
    """Write both files."""
    density, origin = patchy_density()
    common.write_vdb(FOLDER / "lamps.vdb", {"density": density}, VOXEL_M, origin)

    common.new_scene((128, 128), 64)
    shading.set_world((0, 0, 0))
    cloud = shading.volume_material(
        "Patchy cloud",
        ("ShaderNodeVolumePrincipled", {"Color": (0.95, 0.9, 0.8), "Density": 12.0, "Anisotropy": 0.4}),
    )
    common.add_volume("Cloud", "//lamps.vdb", cloud)
    white, _ = shading.surface_material("White", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.7, 0.7))
    common.link("Floor", common.box_mesh("Floor", (-4, -4, -1.2), (4, 4, -1.1)), material=white)

    common.add_light("POINT", "Ember", (-0.35, 0.10, -0.15), 30.0, (1.0, 0.45, 0.15), shadow_soft_size=0.08)
    common.add_light("POINT", "Core", (0.30, -0.25, 0.35), 14.0, (0.4, 0.7, 1.0), shadow_soft_size=0.06)
    common.add_light("POINT", "True point", (0.80, -0.90, -0.45), 16.0, (0.7, 1.0, 0.5), shadow_soft_size=0.0)
    hard = {"spot_size": np.radians(30.0), "spot_blend": 0.0, "shadow_soft_size": 0.0}
    common.add_light("SPOT", "Hard spot", (-2.2, -0.6, 1.8), 260.0, (1.0, 0.9, 0.8), (-0.2, 0.0, 0.1), **hard)
    soft = {"spot_size": np.radians(55.0), "spot_blend": 0.6, "shadow_soft_size": 0.15}
    common.add_light("SPOT", "Soft spot", (1.8, 2.2, 1.2), 200.0, (0.9, 0.5, 1.0), (0.0, 0.0, 0.0), **soft)
    common.add_camera((0.0, -4.6, 0.7), (0.0, 0.0, -0.10), 58.0)
    print(common.save(FOLDER))


main()
