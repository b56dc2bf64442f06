# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene descriptions with anything in them: refused with one clear error, or built and rendered.

What the command line promises is checked: InputError from files and settings, ValueError from the native
module, and nothing else.
"""

import dataclasses
import functools
import tempfile
from pathlib import Path

import nephele_native
from mutation import Bytes, mutated
from nephele import description_file, render_request
from nephele.errors import InputError
from scenes import all_scenes

MOST_PIXELS = 1 << 12
MOST_SAMPLES = 4
SECONDS = 60  # for a few pixels

bases = functools.cache(all_scenes)


def test_one(data):
    """Takes any bytes; raises where the renderer does not keep its promise."""
    take = Bytes(data)
    scene = take.one_of(bases())
    through_file = take.below(4) == 0
    while take:
        scene = mutated(scene, take)
        if not dataclasses.is_dataclass(scene) or not hasattr(scene, "film"):
            return
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        if through_file:
            try:
                scene = written_and_read(scene, Path(folder))
                scene = render_request.Request("fuzz", True, overrides=overrides(scene)).applied(scene)
            except InputError:
                return
        elif isinstance(scene.settings, dict):
            scene = dataclasses.replace(scene, settings=scene.settings | overrides(scene))
        if not is_large(scene.film):
            render(scene)


def written_and_read(scene, folder):
    """Returns the scene after a round trip. What cannot be written is no fault of a file's."""
    path = folder / "scene.npz"
    try:
        description_file.save(path, scene)
    except Exception as error:
        raise InputError("not to be written") from error
    return description_file.load(path, folder / "unpacked")


def overrides(scene):
    settings = scene.settings if isinstance(scene.settings, dict) else {}
    few = isinstance(settings.get("samples"), int) and settings["samples"] <= MOST_SAMPLES
    return {"threads": 1} if few else {"threads": 1, "samples": MOST_SAMPLES}


def is_large(film):
    """Tells whether the film is of a valid size that would only take long."""
    sizes = [getattr(film, name, None) for name in ("width", "height")]
    if not all(isinstance(n, int) for n in sizes):
        return False
    crop = film.crop if isinstance(film.crop, tuple) else ()
    sizes += [n for n in crop if isinstance(n, int)]
    return any(n > MOST_PIXELS for n in sizes) or sizes[0] * sizes[1] > MOST_PIXELS


def render(scene):
    try:
        renderer = nephele_native.Renderer(scene)
    except ValueError as error:
        if not str(error).strip() or "std::" in str(error):
            raise AssertionError(f"an error that says nothing: {error}") from error
        return
    renderer.start()
    if not renderer.wait(SECONDS):
        renderer.cancel()
        raise AssertionError(f"a few pixels took more than {SECONDS} s")
    for name in scene.film.passes:
        renderer.read_pass(name)
    renderer.statistics()
