# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render learned, in a file, from which the next frame or another render of the scene starts.

It fits a scene with the same objects: a guiding field holds for places, and says nothing of another set. What
has moved, or shines differently, makes it a worse guide, never a wrong image.
"""

from . import archive
from .errors import InputError

KIND = "Nephele guiding field"
VERSION = 3
SHOWN = 3  # names in a message


def signature(scene):
    """Returns what a description.Scene must have in common with the one the field was learned in: the names
    of what is in it, and from where single precision counts."""
    return {
        "meshes": sorted({instance.name for instance in scene.instances}),
        "volumes": sorted({volume.name for volume in scene.volumes}),
        "lights": sorted({light.name for light in scene.lights}),
    }


def save(path, renderer, scene, program_version):
    """Writes what `renderer`, which is not running, has learned of a description.Scene."""
    header = {"program": program_version, "scene": signature(scene)}
    archive.write(path, KIND, VERSION, header, renderer.knowledge())


def load(path, scene, program_version):
    """Returns the arrays for Renderer.inherit. Raises InputError where the file is damaged, of another
    version of the program or of another scene."""
    header, arrays = archive.read(path, KIND, VERSION)
    try:
        program, found = header["program"], header["scene"]
        strange = differences(found, signature(scene))
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not a {KIND}, or damaged ({error})") from error
    if program != program_version:
        raise InputError(f"{path}: made by version {program}, this is {program_version}; make it anew")
    if strange:
        raise InputError(
            f"{path}: was learned in another scene ({'; '.join(strange)}); leave --guiding-load out"
        )
    return arrays


def differences(old, new):
    """Returns how the signatures of two scenes differ, a phrase each."""
    phrases = []
    for kind in new:
        for names, words in (
            (set(old[kind]) - set(new[kind]), "are not here"),
            (set(new[kind]) - set(old[kind]), "were not there"),
        ):
            if names:
                listed = ", ".join(f"'{name}'" for name in sorted(names)[:SHOWN])
                more = f" and {len(names) - SHOWN} more" if len(names) > SHOWN else ""
                phrases.append(f"{kind} {listed}{more} {words}")
    return phrases
