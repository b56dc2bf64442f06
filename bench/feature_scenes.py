# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes that lack a feature, for bench/specialisation.py: bundled ones, and small ones made here."""

import dataclasses
import sys
from pathlib import Path

from nephele import description as d
from nephele import description_file

from bench import ours

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests" / "render"))
import truth  # noqa: E402  the tests' scenes are on the path only now

RESOLUTION = (48, 27)
BUNDLED = {
    "cloud": "cloud/cloud.blend",
    "alley": "guiding/alley.blend",
    "smoke_screen": "guiding/smoke_screen.blend",
}


def floor():
    """Returns next to nothing: a grey floor under a white sky."""
    scene = truth.Scene(truth.perspective((0, -4, 1.5), (0, 0, 0), 0.5), truth.emission(1.0))
    scene.add(truth.box((-3, -3, -0.2), (3, 3, 0)), truth.diffuse(0.5))
    return scene.description(RESOLUTION)


def without_volumes(scene):
    """Returns the description.Scene without media, and without the meshes that only bound them."""
    seen = tuple(
        instance
        for instance in scene.instances
        if any(index < 0 or scene.materials[index].surface is not None for index in instance.materials)
    )
    return dataclasses.replace(
        scene,
        materials=tuple(dataclasses.replace(material, volume=()) for material in scene.materials),
        instances=seen,
        volumes=(),
        world=dataclasses.replace(scene.world, volume=()),
    )


def flame():
    """Returns glowing smoke in a ball: one medium that emits."""
    lamp = d.Light("lamp", "area", truth.facing((1, -1, 3), (0, 0, 0)), (50.0, 40.0, 30.0))
    scene = truth.Scene(truth.perspective((0, -4, 0.5), (0, 0, 0), 0.4), lights=(lamp,))
    closure = d.VolumeClosure((2, 2, 2), (0.5, 0.5, 0.5), (0.2, 0.1, 0.05))
    scene.add(truth.sphere(0.9, 3), None, (closure,))
    scene.add(truth.box((-3, -3, -1.4), (3, 3, -1)), truth.diffuse((0.8, 0.6, 0.4)))
    return scene.description(RESOLUTION)


def save(folder):
    """Writes every scene into `folder`. Returns {name: path}."""
    paths = {name: Path(folder, f"{name}.nephele") for name in (*BUNDLED, "floor", "room", "flame")}
    made = {
        "floor": floor,
        "flame": flame,
        "room": lambda: without_volumes(_bundled("slab_room/slab_room.blend", folder)),
    }
    for name, path in paths.items():
        scene = made[name]() if name in made else _bundled(BUNDLED[name], folder)
        description_file.save(path, scene)
    return paths


def _bundled(name, folder):
    place = Path(folder, Path(name).stem)
    place.mkdir(exist_ok=True)
    return ours.export(ROOT / "blend_scenes" / name, place, RESOLUTION)


def changed(scene, settings, passes=("Combined",)):
    """Returns the scene on one thread, with other settings and passes."""
    values = scene.settings | {"threads": 1, "seed": 1} | settings
    film = dataclasses.replace(scene.film, passes=tuple(passes))
    return dataclasses.replace(scene, settings=values, film=film)
