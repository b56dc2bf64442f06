# SPDX-License-Identifier: GPL-3.0-or-later
"""Media on top of each other: fog, a VDB cloud, and a mesh ball of coloured medium reaching into it.

The camera stands in the fog. Where media overlap their coefficients add. The ball absorbs and scatters
in different colours and holds a small diffuse ball.
Fog: extinction 0.02 per metre, albedo 1. Cloud: 64^3 voxels of 5 cm, extinction up to 6 per metre, g = 0.6.

Two files, two kinds of fog:
    overlap.blend       the world's own volume. It has no end, so nothing of the sky image arrives, and the
                        light comes from an area and a point lamp;
    overlap_dome.blend  a mesh ball of 12 m about everything. The sky image shines in, with its small sun.
Writes both, and overlap.vdb, beside this file.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from noise import cellular_noise, fractal, smoothstep  # noqa: E402

CELLS = 64
VOXEL_M = 0.05
SEED = 5


def cloud_density():
    """Density in [0, 1], float32 (64, 64, 64): one flattened, billowy clump."""
    origin = np.full(3, -(CELLS - 1) / 2 * VOXEL_M)
    grid = np.stack(np.meshgrid(*(np.arange(CELLS),) * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    p = (origin + grid * VOXEL_M).astype(np.float32)
    billow = 0.55 - fractal(cellular_noise, p * 2.0, SEED, 3)
    distance = np.linalg.norm(p * np.array((1.0, 1.0, 1.45), np.float32), axis=1) - 1.05 - 0.6 * billow
    density = smoothstep(0.06, -0.18, distance).reshape((CELLS,) * 3)
    density[density < 1 / 64] = 0
    return common.quantise(density, 64), origin


def sky_image():
    """Blue gradient over dim earth with a small bright sun, linear radiance, (64, 128, 3)."""
    directions = shading.lat_long_directions(64)
    up = directions[..., 2:3]
    sky = np.where(
        up > 0, np.array((0.45, 0.6, 0.9)) * (1 - 0.6 * np.maximum(up, 0)), np.array((0.10, 0.09, 0.08))
    )
    sun = np.array((-0.55, -0.35, 0.62))
    cosine = directions @ (sun / np.linalg.norm(sun))
    return (
        sky
        + np.array((1.0, 0.85, 0.65)) * (400.0 * smoothstep(np.cos(0.10), np.cos(0.05), cosine))[..., None]
    )


def add_contents():
    """Cloud, tinted ball, chalk ball, ground and camera."""
    vapour = shading.volume_material(
        "Cloud",
        ("ShaderNodeVolumePrincipled", {"Color": (0.98, 0.98, 0.98), "Density": 6.0, "Anisotropy": 0.6}),
    )
    common.add_volume("Cloud", "//overlap.vdb", vapour, (-0.35, 0.0, 0.1))

    tinted = shading.volume_material(
        "Tinted medium",
        ("ShaderNodeVolumeAbsorption", {"Color": (0.2, 0.6, 0.9), "Density": 1.2}),
        ("ShaderNodeVolumeScatter", {"Color": (0.9, 0.5, 0.2), "Density": 1.5, "Anisotropy": -0.2}),
    )
    common.link("Tinted ball", common.sphere_mesh("Tinted ball", 0.8, 64, 32), (0.85, -0.3, -0.2), tinted)
    chalk, _ = shading.surface_material("Chalk", "ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.75))
    common.link("Chalk ball", common.sphere_mesh("Chalk ball", 0.22, 32, 16), (1.0, -0.55, -0.2), chalk)
    slate, _ = shading.surface_material("Slate", "ShaderNodeBsdfDiffuse", Color=(0.25, 0.25, 0.28))
    common.link("Ground", common.box_mesh("Ground", (-6, -6, -1.4), (6, 8, -1.2)), material=slate)
    common.add_camera((0.2, -5.6, 0.5), (0.1, 0.0, -0.1), 45.0)


def main():
    """Write all files."""
    density, origin = cloud_density()
    common.write_vdb(FOLDER / "overlap.vdb", {"density": density}, VOXEL_M, origin)
    fog = ("ShaderNodeVolumeScatter", {"Color": (1, 1, 1), "Density": 0.02, "Anisotropy": 0.0})

    common.new_scene((128, 128), 64)
    sky = shading.pack_image("sky", sky_image(), "Linear Rec.709", "OPEN_EXR")
    shading.set_world(image=sky, volume=[fog])
    add_contents()
    common.add_light("AREA", "Panel", (-3.5, -2.5, 3.5), 450.0, (1.0, 0.9, 0.75), (0, 0, 0), size=1.0)
    common.add_light("POINT", "Lamp", (2.2, 1.6, 1.2), 120.0, (0.6, 0.8, 1.0), shadow_soft_size=0.1)
    print(common.save(FOLDER))

    common.new_scene((128, 128), 64)
    sky = shading.pack_image("sky", sky_image(), "Linear Rec.709", "OPEN_EXR")
    shading.set_world(image=sky)
    add_contents()
    dome = shading.volume_material("Fog", fog)
    common.link("Fog dome", common.sphere_mesh("Fog dome", 12.0, 32, 16), material=dome)
    print(common.save(FOLDER, "overlap_dome"))


main()
