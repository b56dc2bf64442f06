# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a bundled .blend with Nephele once per seed, for statistics over seeds and for timing.

The scene is exported once, in a process of its own (the command line), and rendered from its description
here."""

import dataclasses
import subprocess
import sys
from pathlib import Path

import numpy as np
from nephele import description_file
from nephele.bridge import create_renderer
from nephele.errors import InputError


def export(scene, folder, resolution=None, frame=None):
    """Returns the description.Scene of a .blend; its files are unpacked into `folder`, which must be kept.

    Raises InputError with the command's words.
    """
    path = Path(folder, "scene.nephele")
    command = [
        sys.executable,
        "-m",
        "nephele",
        "render",
        str(scene),
        "--quiet",
        "--save-description",
        str(path),
    ]
    if resolution is not None:
        command += ["--resolution", f"{resolution[0]}x{resolution[1]}"]
    if frame is not None:
        command += ["--frame", str(frame)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise InputError(
            f"{scene}: cannot be exported: {done.stderr.strip().removeprefix('nephele: error: ')}"
        )
    return description_file.load(path, folder)


def render(scene, seeds, passes=("Combined",), **settings):
    """Returns (dict of pass name -> (seeds, height, width, channels) float32, top row first; statistics).

    scene: a description.Scene. statistics: what the native renderer tells, one dict per seed.
    """
    film = dataclasses.replace(scene.film, passes=tuple(passes))
    images, statistics = {name: [] for name in passes}, []
    for seed in seeds:
        values = scene.settings | settings | {"seed": seed}
        renderer = create_renderer(dataclasses.replace(scene, film=film, settings=values))
        renderer.start()
        while not renderer.wait(1.0):
            pass
        for name in passes:
            pixels = renderer.read_pass(name)[::-1]
            images[name].append(pixels[..., :3] if name == "Combined" else pixels)
        statistics.append(renderer.statistics())
    return {name: np.stack(stack) for name, stack in images.items()}, statistics
