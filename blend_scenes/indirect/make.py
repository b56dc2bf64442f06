# SPDX-License-Identifier: GPL-3.0-or-later
"""Two small scenes that are lit only indirectly, to measure the guiding field with `nephele bench indirect`.

    door    a lamp behind a door left ajar, thin fog in both rooms
    window  a room whose light comes from a sunlit cloud and the ground below, through a pane of glass

Writes both .blend files beside this file, or those named as arguments. The cloud is that of the scene next
door.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from props import add_sun, box, cloud, matt, sun_from  # noqa: E402

RESOLUTION, BOUNCES = (480, 270), 32
WALL = 0.15  # thickness in metres


def shell(low, high, walls, openings=()):
    """Six walls of a box between two inner corners. walls: {side: material} of left, right, near, far, floor,
    ceiling; openings: sides left out."""
    (x0, y0, z0), (x1, y1, z1) = low, high
    t = WALL
    sides = {
        "left": ((x0 - t, y0, z0), (x0, y1, z1)),
        "right": ((x1, y0, z0), (x1 + t, y1, z1)),
        "near": ((x0 - t, y0 - t, z0), (x1 + t, y0, z1)),
        "far": ((x0 - t, y1, z0), (x1 + t, y1 + t, z1)),
        "floor": ((x0 - t, y0 - t, z0 - t), (x1 + t, y1 + t, z0)),
        "ceiling": ((x0 - t, y0 - t, z1), (x1 + t, y1 + t, z1 + t)),
    }
    for side, (a, b) in sides.items():
        if side not in openings:
            box(f"{walls['name']} {side}", a, b, walls[side])


def pierced_wall(name, y, width, height, opening, material):
    """A wall across x at y, from the floor up, with a rectangular opening ((x0, z0), (x1, z1))."""
    (x0, z0), (x1, z1) = opening
    left, right = width
    box(f"{name} left", (left, y, 0), (x0, y + WALL, height), material)
    box(f"{name} right", (x1, y, 0), (right, y + WALL, height), material)
    box(f"{name} above", (x0, y, z1), (x1, y + WALL, height), material)
    if z0 > 0:
        box(f"{name} below", (x0, y, 0), (x1, y + WALL, z0), material)


def make_door():
    """Two rooms of white and coloured walls in homogeneous fog (extinction 0.06 per metre, albedo 0.95, g =
    0.6). The lamp stands in the far one and shines at its ceiling; a door ajar lets its light through."""
    shading.set_world((0, 0, 0))
    white, wood = matt("White", 0.75, 0.74, 0.70), matt("Oak", 0.36, 0.22, 0.11)
    red, teal = matt("Red", 0.60, 0.16, 0.10), matt("Teal", 0.12, 0.40, 0.42)
    floor, _ = shading.surface_material("Floor", Base_Color=(0.22, 0.15, 0.10), Roughness=0.35)
    plain = dict.fromkeys(("near", "far", "ceiling"), white)
    shell(
        (-3, 0, 0), (3, 6, 3), {"name": "Hall", "left": red, "right": white, "floor": floor} | plain, ("far",)
    )
    shell(
        (-3, 6 + WALL, 0),
        (3, 10, 3),
        {"name": "Lit room", "left": white, "right": teal, "floor": floor} | plain,
        ("near",),
    )
    pierced_wall("Partition", 6.0, (-3 - WALL, 3 + WALL), 3.0, ((0.2, 0.0), (1.3, 2.2)), white)
    leaf = box("Door", (0.2, 5.95, 0.02), (1.28, 6.0, 2.18), wood)
    hinge = np.array((1.28, 5.95))
    angle = np.radians(38.0)
    centre = np.array((0.74, 5.95))
    turned = hinge + np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ (
        centre - hinge
    )
    leaf.location = (*turned, 0.02)
    leaf.rotation_euler = (0, 0, angle)
    box("Chest", (-2.6, 3.4, 0), (-1.6, 4.2, 0.8), teal, 0.15)
    ball, _ = shading.surface_material("Copper", Base_Color=(0.85, 0.45, 0.30), Metallic=1.0, Roughness=0.25)
    common.link("Ball", common.sphere_mesh("Ball", 0.4), (1.9, 3.4, 0.4), ball)
    lamp = {"shape": "RECTANGLE", "size": 0.7, "size_y": 0.7}
    common.add_light("AREA", "Lamp", (-1.8, 8.6, 1.1), 8000.0, (1.0, 0.82, 0.6), (-1.8, 8.6, 3.0), **lamp)
    inputs = {"Color": (0.95, 0.95, 0.95), "Density": 0.06, "Anisotropy": 0.6}
    box(
        "Fog",
        (-2.99, 0.01, 0.01),
        (2.99, 9.99, 2.99),
        shading.volume_material("Fog", ("ShaderNodeVolumeScatter", inputs)),
    )
    common.add_camera((-0.9, 0.35, 1.55), (0.3, 5.0, 1.15), 20.0)


def make_window():
    """A room seen towards its window: outside a cloud (extinction 3 per metre, albedo 0.995, g = 0.7) in a
    sun that stands behind the house and does not come in. The pane is glass: light sampling does not see
    through it."""
    shading.set_world((0.35, 0.6, 1.2))
    white, blue = matt("White", 0.78, 0.76, 0.72), matt("Blue", 0.18, 0.25, 0.45)
    boards, _ = shading.surface_material("Boards", Base_Color=(0.30, 0.18, 0.09), Roughness=0.3)
    walls = {"name": "Room", "left": blue, "floor": boards} | dict.fromkeys(
        ("right", "near", "ceiling"), white
    )
    shell((-2.5, -4.5, 0), (2.5, 0, 2.8), walls, ("far",))
    pierced_wall("Front", 0.0, (-2.5 - WALL, 2.5 + WALL), 2.8, ((-1.2, 0.8), (1.3, 2.3)), white)
    box("Mullion", (0.02, 0.05, 0.8), (0.08, 0.1, 2.3), white)
    glass, _ = shading.surface_material("Glass", "ShaderNodeBsdfGlass", Roughness=0.0, IOR=1.45)
    box("Pane", (-1.2, 0.07, 0.8), (1.3, 0.08, 2.3), glass)
    box("Table", (0.5, -1.9, 0.70), (1.9, -1.0, 0.76), matt("Oak", 0.36, 0.22, 0.11))
    box("Foot", (1.1, -1.5, 0.0), (1.3, -1.4, 0.70), white)
    vase, _ = shading.surface_material("Vase", Base_Color=(0.65, 0.12, 0.08), Roughness=0.2)
    common.link("Vase", common.sphere_mesh("Vase", 0.18), (1.0, -1.45, 0.94), vase)
    box("Meadow", (-40, 0.3, -1.2), (40, 60, -1.0), matt("Grass", 0.14, 0.22, 0.06))
    add_sun(sun_from(-110.0, 52.0), 60.0, (1.0, 0.93, 0.82))
    vapour = cloud("Vapour", (0.995, 0.995, 0.995), 3.0, 0.7)
    for name, place, turn in (("Near cloud", (-0.9, 5.6, 1.7), 0.4), ("Far cloud", (2.4, 7.5, 2.3), 2.6)):
        common.add_volume(name, "//../cloud/cloud.vdb", vapour, place).rotation_euler = (0, 0, turn)
    common.add_camera((-1.7, -4.2, 1.5), (0.5, 0.0, 1.45), 21.0)


SCENES = {"door": make_door, "window": make_window}


def main():
    wanted = sys.argv[1:] or list(SCENES)
    if unknown := set(wanted) - set(SCENES):
        sys.exit(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    for name in wanted:
        common.new_scene(RESOLUTION, 64, BOUNCES, view_transform="AgX")
        SCENES[name]()
        print(common.save(FOLDER, name))


main()
