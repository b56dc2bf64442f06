# SPDX-License-Identifier: GPL-3.0-or-later
"""The hero scene: a small cumulus at sunset above dunes, with a glass, a metal and a chequered ball.

Cloud: 128 x 128 x 96 voxels of 4.5 cm, extinction 11 per metre at full density, albedo 0.995, g = 0.7.
Writes cloud.vdb and cloud.blend beside this file.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from noise import cellular_noise, fractal, gradient_noise, smoothstep  # noqa: E402

SHAPE = (128, 128, 96)
VOXEL_M = 0.045
SEED = 7
SIGMA_T_PER_M = 11.0
CLOUD_CENTRE_M = (0.1, 7.0, 1.22)  # of the cloud's underside


def puffs(rng):
    """Centres (N, 3) and radii (N,) of a cauliflower: big balls bear smaller ones, those smaller ones yet.

    Metres, underside at z = 0.
    """
    trunk = np.array(
        [
            # x, y, z, radius
            (-0.25, 0.00, 0.95, 0.95),
            (0.55, 0.20, 0.75, 0.80),
            (-1.10, 0.15, 0.55, 0.65),
            (1.30, -0.05, 0.45, 0.55),
            (0.10, -0.55, 0.55, 0.60),
            (0.05, 0.10, 1.75, 0.75),
            (-0.55, -0.10, 1.55, 0.55),
            (-1.70, -0.05, 0.30, 0.36),
            (1.85, 0.10, 0.28, 0.33),
            (0.55, -0.05, 2.20, 0.50),
        ]
    )
    generations = [trunk]
    for count, smaller, rise in ((11, 0.44, 0.25), (7, 0.42, 0.1)):
        parents = np.repeat(generations[-1], count, axis=0)
        direction = rng.normal(size=(len(parents), 3)) + np.array((0, 0, rise))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        radius = parents[:, 3] * smaller * rng.uniform(0.7, 1.25, len(parents))
        centre = parents[:, :3] + direction * (parents[:, 3] * rng.uniform(0.8, 1.02, len(parents)))[:, None]
        generations.append(np.column_stack([centre, radius]))
    balls = np.concatenate(generations)
    balls = balls[balls[:, 2] > 0.02]
    return balls[:, :3], balls[:, 3]


def ball_union(points, centres, radii):
    """Signed distance (negative inside) from points (X, Y, Z, 3) to the union of balls, up to 0.5 m away."""
    distance = np.full(points.shape[:3], 0.5, np.float32)
    low, step = points[0, 0, 0], VOXEL_M
    for centre, radius in zip(centres, radii, strict=True):
        reach = radius + 0.5 + 0.3  # 0.3: the points have been pushed about
        first = np.maximum(np.floor((centre - reach - low) / step).astype(int), 0)
        last = np.ceil((centre + reach - low) / step).astype(int) + 1
        window = tuple(slice(a, max(a, b)) for a, b in zip(first, last, strict=True))
        here = np.linalg.norm(points[window] - centre.astype(np.float32), axis=-1) - radius
        distance[window] = np.minimum(distance[window], here)
    return distance


def cloud_density():
    """Density in [0, 1], float32 SHAPE, and the object-space centre of voxel (0, 0, 0)."""
    origin = np.array([-(SHAPE[0] - 1) / 2, -(SHAPE[1] - 1) / 2, 0.0]) * VOXEL_M - (0, 0, 0.4)
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in SHAPE), indexing="ij"), axis=-1)
    points = (origin + grid * VOXEL_M).astype(np.float32)
    flat = points.reshape(-1, 3)
    push = np.stack([fractal(gradient_noise, flat * 1.1, SEED + i, 2) for i in range(3)], axis=-1)
    pushed = points + 0.16 * push.reshape(points.shape)

    distance = ball_union(pushed, *puffs(np.random.default_rng(SEED))).reshape(-1)
    near = np.flatnonzero(distance < 0.3)  # noise only where it can matter
    p = flat[near]
    billow = 0.55 - fractal(cellular_noise, p * 3.6, SEED + 10, 3, gain=0.55)  # round bumps, sharp creases
    wisp = fractal(gradient_noise, p * 5.0, SEED + 20, 3, gain=0.6)
    d = distance[near] - 0.36 * billow
    lift = smoothstep(0.45, -0.05, p[:, 2])  # 1 at the underside, which dissolves into wisps
    d = np.maximum(d, 0.12 - p[:, 2] + 0.14 * wisp)
    edge = 0.10 + 0.22 * lift
    body = smoothstep(0.0, -1.0, (d + 0.12 * lift * wisp) / edge)
    core = 0.75 + 0.25 * smoothstep(0.0, 0.5, -d)
    density = np.zeros(len(flat), np.float32)
    density[near] = body * core * (1 + 0.25 * wisp * (1 - lift))
    density = np.clip(density, 0, 1).reshape(SHAPE)
    density[density < 1 / 64] = 0
    return common.quantise(density, 128), origin


def sky_image():
    """A warm horizon under a blue zenith, brighter towards the sun's side: linear radiance, 32 x 64."""
    directions = shading.lat_long_directions(32)
    up = directions[..., 2:3]
    zenith, high, horizon = (
        np.array(c) for c in ((0.020, 0.06, 0.21), (0.055, 0.14, 0.34), (0.72, 0.36, 0.20))
    )
    sky = high + (zenith - high) * smoothstep(0.2, 0.9, up)
    sky = sky + (horizon - sky) * np.exp(-8.0 * np.maximum(up, 0))
    toward_sun = np.einsum("ijk,k->ij", directions, sun_direction())[..., None]
    sky = sky + np.array((0.9, 0.45, 0.18)) * np.exp(-6 * (1 - toward_sun)) * np.exp(-3.0 * np.maximum(up, 0))
    ground = np.array((0.10, 0.075, 0.06))
    return sky + (ground - sky) * smoothstep(0.02, -0.06, up)


def sun_direction():
    """Unit vector towards the sun: low, from the left and a little behind the cloud."""
    azimuth, elevation = np.radians(152.0), np.radians(19.0)
    return np.array(
        [np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)]
    )


def dune_height(x, y):
    """Wind-blown sand, calm where the balls stand, higher far away; metres."""
    p = np.stack([x * 0.10 + y * 0.03, y * 0.13, np.zeros_like(x)], axis=1)
    crest = (1 - np.abs(fractal(gradient_noise, p + 3.3, SEED + 40, 2, gain=0.25))) ** 3
    ripples = 0.008 * np.sin(11.0 * y + 3.0 * x + 3.0 * gradient_noise(p * 5, SEED + 50))
    calm = smoothstep(3.0, 16.0, np.hypot(x, y - 4.0))
    return (0.05 + 0.9 * calm) * crest - 0.1 + ripples * (1 - calm)


def chequer_image():
    """16 x 8 squares of two colours, one texel each side enlarged eight times; display-referred."""
    rows, columns = np.indices((64, 128)) // 8
    dark, light = np.array((0.62, 0.20, 0.12)), np.array((0.93, 0.88, 0.78))
    return np.where(((rows + columns) % 2)[..., None] == 0, dark, light)


def add_ground():
    """Dunes out to 60 m, finer near the camera."""
    half = np.linspace(0, 1, 42)
    xs = np.concatenate([-(half[:0:-1] ** 2.2), half**2.2]) * 36
    ys = -4 + 64 * np.linspace(0, 1, 90) ** 2.0
    sand, _ = shading.surface_material(
        "Sand", Base_Color=(0.42, 0.30, 0.20), Roughness=0.9, Specular_IOR_Level=0.1
    )
    common.link("Dunes", common.heightfield_mesh("Dunes", xs, ys, dune_height), material=sand)


def add_balls():
    """Glass, rough metal and chequered balls on the sand, under the cloud."""
    glass, _ = shading.surface_material(
        "Glass", "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.45
    )
    metal, _ = shading.surface_material("Copper", Base_Color=(0.95, 0.62, 0.45), Metallic=1.0, Roughness=0.28)
    chequer, shader = shading.surface_material("Chequer", "ShaderNodeBsdfDiffuse", Roughness=0.0)
    shading.textured(chequer, shader, shading.pack_image("chequer", chequer_image(), "sRGB"), "Color")
    for name, material, radius, x, y in (
        ("Glass ball", glass, 0.42, -1.35, 4.6),
        ("Copper ball", metal, 0.34, 1.45, 4.7),
        ("Chequered ball", chequer, 0.25, 0.40, 3.9),
    ):
        z = float(dune_height(np.array([x]), np.array([y]))[0]) + radius - 0.02
        ball = common.link(name, common.sphere_mesh(name, radius), (x, y, z), material)
        ball.rotation_euler = (0.5, 0.3, 0.4)


def main():
    """Write both files."""
    density, origin = cloud_density()
    common.write_vdb(FOLDER / "cloud.vdb", {"density": density}, VOXEL_M, origin)

    scene = common.new_scene((960, 540), 64, pixel_filter="BLACKMAN_HARRIS", view_transform="AgX")
    shading.set_world(image=shading.pack_image("sky", sky_image(), "Linear Rec.709", "OPEN_EXR"))
    vapour = shading.volume_material(
        "Cloud",
        (
            "ShaderNodeVolumePrincipled",
            {"Color": (0.995, 0.995, 0.995), "Density": SIGMA_T_PER_M, "Anisotropy": 0.7},
        ),
    )
    common.add_volume("Cloud", "//cloud.vdb", vapour, CLOUD_CENTRE_M)
    add_ground()
    add_balls()

    sun = np.array(sun_direction())
    common.add_light("SUN", "Sun", tuple(20 * sun), 12.0, (1.0, 0.67, 0.42), (0, 0, 0), angle=np.radians(1.0))
    common.add_light(
        "AREA",
        "Panel",
        (3.6, 4.0, 1.7),
        60.0,
        (0.35, 0.60, 1.0),
        (0.6, 7.0, 1.8),
        shape="RECTANGLE",
        size=1.2,
        size_y=0.8,
    )
    camera = common.add_camera((0.0, -1.5, 0.95), (0.0, 7.0, 1.68), 34.0)
    camera.data.dof.use_dof = True
    camera.data.dof.focus_distance = 7.5
    camera.data.dof.aperture_fstop = 2.8
    scene.view_settings.look = "AgX - Medium High Contrast"
    print(common.save(FOLDER))


main()
