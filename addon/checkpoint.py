# SPDX-License-Identifier: GPL-3.0-or-later
"""Checkpoints: the state of an unfinished render, from which it goes on as if it had never stopped.

An identity says which render a state or an image belongs to: the program's version, the settings, the film
and the fingerprint of the scene. More samples, another limit of time or error, or another number of threads
do not make it another render.
"""

import dataclasses
import json
from pathlib import Path

from . import archive, exr
from .errors import InputError

KIND = "Nephele checkpoint"
VERSION = 4
FREE_SETTINGS = ("samples", "time_limit", "threads", "target_error", "viewport_samples")


def identity(scene, fingerprint, program_version):
    """Returns the identity of rendering `scene` as a dict of JSON values."""
    settings = {name: value for name, value in scene.settings.items() if name not in FREE_SETTINGS}
    film = dataclasses.asdict(scene.film)
    return json.loads(
        json.dumps({"version": program_version, "settings": settings, "film": film, "scene": fingerprint})
    )


def path_for(image_path):
    """Returns where the checkpoint of an image lies."""
    return Path(f"{image_path}.checkpoint.npz")


def save(path, renderer, render_identity, samples_done):
    """Writes the state of `renderer`, which is not running."""
    header = {"identity": render_identity, "samples_done": samples_done}
    archive.write(path, KIND, VERSION, header, renderer.checkpoint())


def load(path, render_identity, samples):
    """Returns (state for Renderer.restore, samples done). Raises InputError where it belongs to another
    render."""
    header, state = archive.read(path, KIND, VERSION)
    try:
        found, samples_done = header["identity"], header["samples_done"]
        changes = differences(found, render_identity)
        if not isinstance(samples_done, int):
            raise TypeError(f"its number of samples is {samples_done!r}")
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not a {KIND}, or damaged ({error})") from error
    if changes:
        raise InputError(
            f"{path}: is of another render ({'; '.join(changes)}); undo that or leave --resume out"
        )
    if samples_done > samples:
        raise InputError(
            f"{path}: holds {samples_done} samples per pixel already, more than the {samples} asked for"
        )
    return state, samples_done


def differences(old, new):
    """Returns what changed between two identities, a phrase each."""
    changes = []
    if old["version"] != new["version"]:
        changes.append(f"made by version {old['version']}, this is {new['version']}")
    for group, noun in (("settings", "setting"), ("film", "film's")):
        for name in sorted(old[group].keys() | new[group].keys()):
            before, after = old[group].get(name), new[group].get(name)
            if before != after:
                changes.append(f"{noun} {name} was {shown(before)}, is {shown(after)}")
    if old["scene"] != new["scene"]:
        changes.append("the scene's content changed")
    return changes


def shown(value):
    """Returns a setting's value as a user writes it."""
    return ", ".join(map(str, value)) if isinstance(value, list) else str(value)


def image_attributes(render_identity, samples_done, error=None):
    """Returns what an image's header says of its render. error: estimated, None where none was."""
    attributes = {"identity": json.dumps(render_identity), "samples": str(samples_done)}
    return attributes | ({} if error is None else {"error": repr(error)})


def is_complete(image_path, render_identity, settings):
    """Tells whether the EXR at `image_path` is this very render with as many samples as the settings ask for,
    or at most their target error."""
    if not Path(image_path).is_file():
        return False
    attributes = exr.read_attributes(image_path)
    if attributes.get("identity") != json.dumps(render_identity):
        return False
    reached = float(attributes.get("error", "inf")) <= settings["target_error"]
    return reached or int(attributes["samples"]) >= settings["samples"]
