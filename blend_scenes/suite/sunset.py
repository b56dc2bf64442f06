# SPDX-License-Identifier: GPL-3.0-or-later
"""A sea of clouds at sunset, and the towers that rise from it: 160 x 160 x 48 voxels of 0.1, extinction up to
60 per unit of length (optical depth tens to hundreds), albedo 0.999, g = 0.85."""

import common
import numpy as np
import shading
from noise import cellular_noise, fractal, gradient_noise, smoothstep
from props import add_sun, cloud, sun_from

BOUNCES = 256
SHAPE, VOXEL, SEED = (160, 160, 48), 0.1, 23
TOWERS = (
    (-2.6, 1.0, 1.5, 2.6),
    (2.7, 3.2, 1.3, 2.2),
    (0.4, -2.4, 0.9, 0.9),
    (5.4, 0.0, 1.1, 1.3),
)  # x, y, r, h


def write_volume(path):
    """Density in [0, 1]: below a bumpy ceiling, which heaps up at the towers."""
    origin = np.array((-(SHAPE[0] - 1) / 2, -(SHAPE[1] - 1) / 2, 0)) * VOXEL
    index = np.stack(np.meshgrid(*(np.arange(n) for n in SHAPE), indexing="ij"), axis=-1).reshape(-1, 3)
    p = (origin + index * VOXEL).astype(np.float32)
    drift = np.stack([fractal(gradient_noise, p * 0.5, SEED + i, 2) for i in (1, 2, 3)], axis=1)
    p = p + 0.7 * drift
    flat = p * (1, 1, 0)
    ceiling = 0.75 + 0.9 * fractal(gradient_noise, flat * 0.33, SEED, 2)
    for x, y, radius, height in TOWERS:
        away2 = ((p[:, 0] - x) ** 2 + (p[:, 1] - y) ** 2) / radius**2
        ceiling = ceiling + height * np.exp(-(away2**1.5))
    depth = ceiling - p[:, 2]
    near = np.flatnonzero(np.abs(depth) < 1.6)
    billow = 0.6 - fractal(cellular_noise, p[near] * 0.75, SEED + 5, 4, gain=0.55)
    depth[near] += 1.5 * billow
    margin = np.abs(p[:, :2]).max(1)
    density = smoothstep(0.0, 0.22, depth) * smoothstep(0.5 * SHAPE[0] * VOXEL, 7.2, margin)
    density *= 0.35 + 0.65 * smoothstep(0.0, 0.8, depth)
    density[density < 1 / 32] = 0
    common.write_vdb(path, {"density": common.quantise(density.reshape(SHAPE), 32)}, VOXEL, origin)


def build():
    low = sun_from(62.0, 7.0)
    shading.set_sky(
        "sunset", (0.03, 0.08, 0.26), (1.1, 0.42, 0.20), (0.85, 0.34, 0.18), (4.0, 1.3, 0.3), low, 14.0, 11.0
    )
    add_sun(low, 60.0, (1.0, 0.46, 0.18))
    vapour = cloud("Vapour", (0.999, 0.999, 0.999), 60.0, 0.85)
    common.add_volume("Clouds", "//sunset.vdb", vapour)
    common.add_camera((-0.6, -9.6, 3.3), (0.2, 0.0, 1.75), 30.0)
