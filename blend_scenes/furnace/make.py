# SPDX-License-Identifier: GPL-3.0-or-later
"""White furnace: a ball that only scatters, under a uniform white sky of radiance 1. Every pixel must be 1.

The ball has a rough edge and varying density (extinction up to 6 per metre, optical depth about 6 through
the middle), albedo exactly 1, g = 0.5. Energy is conserved only if paths may go on, so the bounce limit is
Blender's highest, 1024: what it still cuts off is far below any noise.
Writes furnace.vdb and furnace.blend beside this file.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from noise import fractal, gradient_noise, smoothstep  # noqa: E402

CELLS = 48
VOXEL_M = 2.0 / CELLS
SEED = 11


def ball_density():
    """Density in [0, 1], float32 (48, 48, 48)."""
    origin = np.full(3, -(CELLS - 1) / 2 * VOXEL_M)
    grid = np.stack(np.meshgrid(*(np.arange(CELLS),) * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    p = (origin + grid * VOXEL_M).astype(np.float32)
    ball = smoothstep(0.9, 0.75, np.linalg.norm(p, axis=1))
    lumps = np.clip(0.6 + 0.6 * fractal(gradient_noise, p * 3.0, SEED, 2), 0, 1)
    return common.quantise((ball * lumps).reshape((CELLS,) * 3), 128), origin


def main():
    """Write both files."""
    density, origin = ball_density()
    common.write_vdb(FOLDER / "furnace.vdb", {"density": density}, VOXEL_M, origin)

    common.new_scene((64, 64), 64, bounces=1024)
    shading.set_world((1, 1, 1), 1.0)
    white = shading.volume_material(
        "White",
        ("ShaderNodeVolumePrincipled", {"Color": (1, 1, 1), "Density": 6.0, "Anisotropy": 0.5}),
    )
    common.add_volume("Ball", "//furnace.vdb", white)
    common.add_camera((0.0, -4.0, 0.0), (0.0, 0.0, 0.0), 50.0)
    print(common.save(FOLDER))


main()
