# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes in which a guiding field has something to learn: light that comes round a corner, a dense
cloud, glass and leaves, burning smoke."""

from nephele import description as d
from truth import (
    RAY,
    ROUGH_BALL,
    Scene,
    box,
    constant_program,
    diffuse,
    emission,
    facing,
    glass,
    half_world,
    medium,
    perspective,
    placed,
    sphere,
)  # fmt: skip


def baffle_room(fog=0.08, fog_g=0.3):
    """A closed room of white and coloured walls, filled with thin fog, whose only lamp is hidden behind a
    baffle: all light that the camera sees has bounced. fog: 1/m, none where 0."""
    lamp = d.Light(
        "lamp", "area", facing((1.5, 0.9, 0.3), (2, 1.4, 0.6)), (60.0, 50.0, 35.0), size=(0.4, 0.4)
    )
    scene = Scene(perspective((-1.7, -1.6, 0), (0.2, 1.0, -0.2), 0.6), lights=(lamp,))
    walls = {
        "left": ((-2.2, -2, -2), (-2, 2, 2), (0.7, 0.2, 0.15)),
        "right": ((2, -2, -2), (2.2, 2, 2), (0.8, 0.8, 0.8)),
        "near": ((-2, -2.2, -2), (2, -2, 2), (0.75, 0.75, 0.75)),
        "far": ((-2, 2, -2), (2, 2.2, 2), (0.75, 0.75, 0.75)),
        "floor": ((-2, -2, -2.2), (2, 2, -2), (0.6, 0.6, 0.6)),
        "ceiling": ((-2, -2, 2), (2, 2, 2.2), (0.2, 0.3, 0.7)),
        "baffle": ((0.9, -0.8, -2), (1.0, 2, 2), (0.7, 0.7, 0.7)),
    }
    for name, (low, high, albedo) in walls.items():
        scene.add(box(low, high, name), diffuse(albedo))
    if fog:
        scene.add(box((-1.95, -1.95, -1.95), (1.95, 1.95, 1.95), "fog"), None, (medium(fog, 0.01, fog_g),))
    return scene


def cloud():
    """A dense block that scatters forwards, of another albedo in each channel, over a floor under a sky."""
    sky = half_world((0.4, 0.6, 1.0), (0.1, 0.08, 0.05))
    scene = Scene(perspective((0, -4, 0.8), (0, 0, 0), 0.4), sky)
    scene.add(box((-1, -0.7, -0.5), (1, 0.7, 0.7), "cloud"), None, (medium((7, 8, 9), (0.1, 0.4, 1.2), 0.8),))
    return scene.add(box((-3, -3, -1.2), (3, 3, -0.9), "floor"), diffuse((0.7, 0.5, 0.3)))


def glass_and_leaves():
    """Surfaces without media: rough and smooth glass, a glossy floor, a translucent leaf, a half-transparent
    veil; a ball that some rays do not see, and a lamp that glossy and transmitted rays do not find."""
    blind = d.ALL_RAYS & ~(RAY["camera"] | RAY["glossy"] | RAY["transmission"])
    lights = (
        d.Light("soft", "point", placed(0.9, -0.8, 1.2), (25.0, 20.0, 15.0), radius=0.3, visibility=blind),
        d.Light("area", "area", facing((-1.2, 0.6, 1.6), (0, 0, 0)), (20.0, 25.0, 30.0), size=(0.8, 0.8)),
    )
    glossy = constant_program(
        ("glossy", (0.6, 0.5, 0.4), 0.35, None), ("diffuse", (0.2, 0.25, 0.3), 0.0, None)
    )
    leaf = constant_program(("translucent", (0.3, 0.5, 0.1), None), ("glossy", (0.15, 0.15, 0.15), 0.5, None))
    veil = constant_program(("transparent", (0.5, 0.4, 0.6)), ("diffuse", (0.3, 0.3, 0.2), 0.0, None))
    scene = Scene(perspective((0, -4, 0.9), (0, 0, 0), 0.38), half_world((0.2, 0.25, 0.3), 0.05), (), lights)
    scene.add(box((-3, -3, -1.0), (3, 3, -0.7), "floor"), glossy)
    scene.add(box((-3, 1.5, -1), (3, 1.7, 2), "wall"), diffuse((0.7, 0.6, 0.5)))
    scene.add(sphere(0.45, 2, "rough glass"), glass(1.4, 0.45), (), placed(-0.6, 0, -0.2))
    scene.add(sphere(0.3, 2, "glass"), glass(1.5), (), placed(0.1, -0.7, -0.35))
    scene.add(box((0.3, 0.3, -0.6), (1.2, 0.34, 0.6), "leaf"), leaf)
    scene.add(box((0.0, -1.1, -0.2), (1.0, -1.08, 0.6), "veil"), veil)
    scene.add(
        sphere(0.3, 2, "hidden"),
        diffuse((0.8, 0.3, 0.2)),
        (),
        placed(0.8, -0.3, -0.3),
        visibility=d.ALL_RAYS & ~(RAY["camera"] | RAY["glossy"]),
    )
    return scene.add(
        sphere(0.15, 2, "shining"),
        emission((5.0, 4.0, 3.0)),
        (),
        placed(-0.2, 0.8, 0.6),
        visibility=d.ALL_RAYS & ~RAY["diffuse"],
    )


def burning_smoke():
    """A grid that shines, over a floor in the dark, beside a wall."""
    scene = Scene(perspective((0, -4, 0.5), (0, 0, 0), 0.4), emission(0.05))
    fire = medium(
        (2, 2.5, 3),
        (1.0, 0.8, 0.6),
        0.4,
        emission=(1.5, 0.6, 0.15),
        density_grid="density",
        emission_grid="density",
    )
    scene.add_volume(ROUGH_BALL, fire)
    scene.add(box((-3, -3, -1.4), (3, 3, -1), "floor"), diffuse((0.8, 0.6, 0.4)))
    return scene.add(box((1.2, -1, -1), (1.4, 1, 1), "wall"), diffuse(0.7))
