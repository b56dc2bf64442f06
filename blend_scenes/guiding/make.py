# SPDX-License-Identifier: GPL-3.0-or-later
"""Six small scenes to measure the guiding of the volume scattering probability: `nephele bench guiding`.

    alley         thin fog before lit surfaces: delta tracking scatters too seldom in it
    mist          thin patchy mist before dark surfaces, shafts of sun: too seldom as well
    ember         glowing things inside a thick cloud: delta tracking seldom gets through to them
    smoke_screen  a bright sky and sunlit houses behind dark smoke: seldom gets through as well
    cumulus       clouds of moderate depth above sunlit fields: delta tracking is about right
    milk          a deep white plume before black: whatever the probability, its paths are long

Writes mist.vdb and all .blend files beside this file, or those named as arguments. The other volumes are
those of the scenes next door.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from noise import fractal, gradient_noise, smoothstep  # noqa: E402
from props import add_sun, box, cloud, glow, matt, sun_from  # noqa: E402

RESOLUTION = (480, 270)
MIST_SHAPE, MIST_VOXEL_M, SEED = (64, 88, 38), 0.16, 31


def make_alley():
    """A wet alley at night, 18 m long, in homogeneous fog (extinction 0.02 per metre, albedo 0.95, g = 0.5):
    two lanterns, a door left open, a lit window."""
    shading.set_world((0.02, 0.03, 0.06))
    brick, plaster = matt("Brick", 0.30, 0.14, 0.09), matt("Plaster", 0.40, 0.36, 0.30)
    asphalt, _ = shading.surface_material("Asphalt", Base_Color=(0.05, 0.05, 0.055), Roughness=0.32)
    wood, _ = shading.surface_material("Wood", Base_Color=(0.20, 0.11, 0.05), Roughness=0.6)
    box("Ground", (-8, -4, -0.2), (8, 24, 0), asphalt)
    box("Left houses", (-4, -3, 0), (-1.7, 11.0, 7), brick)
    box("Far left house", (-4, 12.4, 0), (-1.5, 18, 8), plaster)
    box("Right houses", (1.7, -3, 0), (4, 8.5, 6), plaster)
    box("Far right house", (1.9, 9.6, 0), (4, 18, 7), brick)
    box("End", (-6, 18, 0), (6, 18.3, 6.5), brick)
    for i, (x, y, size, turn) in enumerate(
        ((-1.2, 4.2, 0.7, 0.2), (-1.1, 5.1, 0.5, -0.4), (1.2, 7.0, 0.8, 0.5))
    ):
        box(f"Crate {i + 1}", (x - size / 2, y - size / 2, 0), (x + size / 2, y + size / 2, size), wood, turn)
    box("Window", (-1.699, 6.6, 2.9), (-1.68, 7.6, 4.2), glow("Lit window", (1.0, 0.62, 0.25), 5.0))

    iron = matt("Iron", 0.03, 0.03, 0.03)
    for name, (x, y, z), colour, strength in (
        ("Near lantern", (1.35, 4.6, 2.9), (1.0, 0.70, 0.38), 550.0),
        ("Far lantern", (-1.1, 13.0, 3.2), (0.75, 0.88, 1.0), 800.0),
    ):
        common.link(name, common.sphere_mesh(name, 0.1, 12, 6), (x, y, z), glow(name, colour, strength))
        box(f"{name}'s hood", (x - 0.2, y - 0.2, z + 0.14), (x + 0.2, y + 0.2, z + 0.18), iron)
    door = {"shape": "RECTANGLE", "size": 1.0, "size_y": 2.0}
    common.add_light(
        "AREA", "Open door", (2.4, 9.05, 1.1), 420.0, (1.0, 0.45, 0.2), (-2.0, 9.05, 0.8), **door
    )

    inputs = {"Color": (0.95, 0.95, 0.95), "Density": 0.02, "Anisotropy": 0.5}
    fog = shading.volume_material("Fog", ("ShaderNodeVolumeScatter", inputs))
    box("Fog", (-6.5, -3.5, -0.1), (6.5, 20, 9), fog)
    common.add_camera((0.2, -1.6, 1.5), (-0.1, 10.0, 2.0), 26.0)


def mist_density():
    """Density in [0, 1], float32 MIST_SHAPE, and the centre of voxel (0, 0, 0): banks, denser low."""
    origin = -(np.array(MIST_SHAPE) - 1) / 2 * MIST_VOXEL_M
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in MIST_SHAPE), indexing="ij"), axis=-1).reshape(-1, 3)
    p = (origin + grid * MIST_VOXEL_M).astype(np.float32)
    drift = np.stack([fractal(gradient_noise, p * 0.35, SEED + i, 2) for i in range(3)], axis=1)
    banks = fractal(gradient_noise, (p + 1.2 * drift) * (0.45, 0.45, 0.8), SEED + 9, 3, gain=0.55)
    density = 0.15 + 0.85 * smoothstep(-0.15, 0.5, banks)
    density *= 0.35 + 0.65 * smoothstep(3.0, -3.0, p[:, 2])
    return common.quantise(density.reshape(MIST_SHAPE), 32), origin


def make_mist():
    """A dark hall, 10 m wide, with sun through its windows and mist in it: extinction up to 0.12 per metre,
    albedo 0.9, g = 0.6."""
    shading.set_world((0.25, 0.40, 0.70))
    stone = matt("Dark stone", 0.10, 0.09, 0.08)
    box("Floor", (-5.5, -7.5, -0.3), (5.5, 7.5, 0), stone)
    box("Roof", (-5.5, -7.5, 6), (5.5, 7.5, 6.3), stone)
    box("Left wall", (-5.5, -7.5, 0), (-5.0, 7.5, 6), stone)
    box("Back wall", (-5.5, 7.0, 0), (5.5, 7.5, 6), stone)
    box("Front wall", (-5.5, -7.5, 0), (5.5, -7.0, 6), stone)
    box("Sill", (5.0, -7.5, 0), (5.5, 7.5, 1.8), stone)
    box("Lintel", (5.0, -7.5, 5.2), (5.5, 7.5, 6), stone)
    for i, (first, last) in enumerate(((-7.5, -3.4), (-2.3, -0.3), (0.8, 2.8), (3.9, 5.6), (6.5, 7.5))):
        box(f"Pier {i + 1}", (5.0, first, 1.8), (5.5, last, 5.2), stone)
    for i, y in enumerate((-0.4, 2.4, 5.2)):
        box(f"Column {i + 1}", (0.6, y - 0.3, 0), (1.2, y + 0.3, 6), stone)
    add_sun(sun_from(32.0, 24.0), 90.0, (1.0, 0.86, 0.66))
    common.add_volume("Mist", "//mist.vdb", cloud("Mist", (0.9, 0.9, 0.9), 0.12, 0.6), (0, 0, 3.0))
    common.add_camera((-3.2, -6.6, 1.7), (1.0, 3.0, 2.2), 22.0)


def make_ember():
    """Three glowing bodies in a patchy ball of smoke: extinction up to 12 per metre, albedo 0.8, g = 0.3."""
    shading.set_world((0.012, 0.016, 0.030))
    ground, _ = shading.surface_material("Basalt", Base_Color=(0.10, 0.10, 0.11), Roughness=0.5)
    box("Ground", (-5, -5, -1.25), (5, 6, -1.05), ground)
    for name, centre, radius, colour, strength in (
        ("Ember", (-0.30, 0.05, -0.20), 0.12, (1.0, 0.32, 0.06), 160.0),
        ("Coal", (0.36, -0.15, 0.05), 0.09, (1.0, 0.50, 0.14), 220.0),
        ("Spark", (0.02, 0.20, 0.42), 0.06, (0.40, 0.62, 1.0), 300.0),
    ):
        common.link(name, common.sphere_mesh(name, radius, 24, 12), centre, glow(name, colour, strength))
    common.add_volume("Smoke", "//../lamps/lamps.vdb", cloud("Smoke", (0.8, 0.8, 0.8), 12.0, 0.3))
    moon = {"shape": "DISK", "size": 1.5}
    common.add_light("AREA", "Moon", (3.0, -2.5, 4.0), 60.0, (0.55, 0.7, 1.0), (0, 0, 0), **moon)
    common.add_camera((0.0, -4.4, 0.55), (0.0, 0.0, -0.08), 46.0)


def evening_sky():
    """Linear radiance (32, 64, 3): a bright band at the horizon, brightest ahead (+y), blue above."""
    directions = shading.lat_long_directions(32)
    up = directions[..., 2:3]
    ahead = directions @ sun_from(90.0, 8.0)
    sky = np.array((0.12, 0.20, 0.38)) * (1.2 - 0.8 * np.clip(up, 0, 1))
    sky = sky + np.array((1.6, 1.0, 0.45)) * np.exp(-5.0 * np.abs(up))
    sky = sky + np.array((10.0, 5.2, 2.0)) * np.exp(-40.0 * (1 - ahead))[..., None]
    return np.where(up < -0.02, np.array((0.05, 0.04, 0.04)), sky)


def make_smoke_screen():
    """Sooty plumes (extinction 15 per metre, albedo 0.15 to 0.2) before white houses in the sun and an
    evening sky."""
    shading.set_world(image=shading.pack_image("evening", evening_sky(), "Linear Rec.709", "OPEN_EXR"))
    white, roof = matt("Whitewash", 0.80, 0.78, 0.74), matt("Tiles", 0.45, 0.14, 0.07)
    box("Quay", (-12, -4, -0.3), (12, 8, 0), matt("Quay", 0.28, 0.26, 0.24))
    for i, (x, y, width, height, turn) in enumerate(
        (
            (-3.1, 4.2, 1.3, 1.2, 0.3),
            (-1.5, 4.8, 1.2, 1.7, -0.2),
            (0.7, 4.4, 1.5, 1.0, 0.15),
            (2.7, 4.6, 1.2, 1.5, -0.3),
        )
    ):
        low, high = (x - width / 2, y - 0.6, 0), (x + width / 2, y + 0.6, height)
        box(f"House {i + 1}", low, high, white, turn)
        over = np.array((0.08, 0.08, 0))
        box(f"Roof {i + 1}", (*(low - over)[:2], height), (*(high + over)[:2], height + 0.12), roof, turn)
    add_sun(sun_from(-60.0, 30.0), 4.5, (1.0, 0.82, 0.60))
    soot = cloud("Soot", (0.20, 0.17, 0.15), 15.0, 0.2)
    for name, filepath, place, turn in (
        ("Left plume", "//../smoke/smoke_0001.vdb", (-1.5, 0.3, -0.2), 0.0),
        ("Right plume", "//../smoke/smoke_0002.vdb", (0.75, -0.2, -0.2), 2.0),
    ):
        common.add_volume(name, filepath, soot, place).rotation_euler = (0, 0, turn)
    common.add_camera((0.0, -6.6, 1.0), (0.0, 0.0, 1.30), 50.0)


def field_image():
    """Fields of eight crops and the lanes between them, 96 x 96, display-referred."""
    rows, columns = np.indices((96, 96))
    crops = np.array(
        [
            (0.42, 0.50, 0.22),
            (0.58, 0.55, 0.28),
            (0.30, 0.42, 0.18),
            (0.66, 0.58, 0.36),
            (0.36, 0.46, 0.26),
            (0.50, 0.40, 0.26),
            (0.26, 0.36, 0.16),
            (0.60, 0.62, 0.34),
        ]
    )
    shifted = columns + 5 * ((rows // 12) % 3)
    image = crops[(rows // 12 * 5 + shifted // 16 * 3) % 8]
    lanes = (rows % 12 == 0) | (shifted % 16 == 0)
    return np.where(lanes[..., None], np.array((0.70, 0.66, 0.56)), image)


def make_cumulus():
    """Two clouds above sunlit fields, from above: extinction 2.2 per metre (optical depth up to 5 or so
    downwards), albedo 0.99, g = 0.7."""
    shading.set_world((0.35, 0.55, 0.95), 0.6)
    crop, shader = shading.surface_material("Fields", "ShaderNodeBsdfDiffuse")
    shading.textured(crop, shader, shading.pack_image("fields", field_image(), "sRGB"), "Color")
    ground = common.mesh_from_arrays(
        "Ground", [(-16, -10, 0), (16, -10, 0), (16, 22, 0), (-16, 22, 0)], [(0, 1, 2, 3)]
    )
    ground.uv_layers.new(name="UVMap").data.foreach_set("uv", np.array([0, 0, 2, 0, 2, 2, 0, 2], np.float32))
    common.link("Ground", ground, material=crop)
    add_sun(sun_from(205.0, 48.0), 6.5, (1.0, 0.93, 0.82))
    vapour = cloud("Vapour", (0.99, 0.99, 0.99), 2.2, 0.7)
    for name, place, turn in (("Near cloud", (-1.2, 0.4, 1.3), 0.4), ("Far cloud", (2.4, 4.4, 1.6), 2.6)):
        common.add_volume(name, "//../cloud/cloud.vdb", vapour, place).rotation_euler = (0, 0, turn)
    common.add_camera((0.2, -5.2, 7.4), (0.4, 2.0, 1.2), 34.0)


def make_milk():
    """Milk poured into clear water, before black: extinction up to 70 per metre, albedo 0.999 to 0.99,
    g = 0.4; a key light and a rim light."""
    shading.set_world((0, 0, 0))
    milk = cloud("Milk", (0.999, 0.997, 0.99), 70.0, 0.4)
    plume = common.add_volume("Plume", "//../smoke/smoke_0002.vdb", milk, (0, 0, 2.9))
    plume.rotation_euler = (np.pi, 0, 0.6)  # a rising plume upside down
    panel = {"shape": "RECTANGLE", "size": 1.6, "size_y": 2.4}
    common.add_light("AREA", "Key", (-3.2, -2.6, 2.6), 260.0, (1.0, 0.95, 0.88), (0, 0, 1.2), **panel)
    common.add_light("AREA", "Rim", (2.6, 2.4, 2.2), 200.0, (0.55, 0.75, 1.0), (0, 0, 1.3), **panel)
    common.add_camera((0.0, -5.6, 1.45), (0.0, 0.0, 1.42), 56.0)


# name: (what builds it, bounces)
SCENES = {
    "alley": (make_alley, 16),
    "mist": (make_mist, 16),
    "ember": (make_ember, 32),
    "smoke_screen": (make_smoke_screen, 16),
    "cumulus": (make_cumulus, 32),
    "milk": (make_milk, 128),
}


def main():
    """Write the mist and the scenes."""
    wanted = sys.argv[1:] or list(SCENES)
    if unknown := set(wanted) - set(SCENES):
        sys.exit(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    if "mist" in wanted:
        density, origin = mist_density()
        common.write_vdb(FOLDER / "mist.vdb", {"density": density}, MIST_VOXEL_M, origin)
    for name in wanted:
        build, bounces = SCENES[name]
        common.new_scene(RESOLUTION, 64, bounces, view_transform="AgX")
        build()
        print(common.save(FOLDER, name))


main()
