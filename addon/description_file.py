# SPDX-License-Identifier: GPL-3.0-or-later
"""Scene descriptions in one file, which needs neither Blender nor any other file to be rendered.

An archive (see archive.py) whose header is the tree of dataclasses as JSON. A value that JSON lacks is an
object with one key: {"array": number}, {"tuple": [...]}, {"dict": {...}}; a dataclass is {"type": name,
"fields": {...}}. VDB files are embedded byte for byte.
"""

import dataclasses
import hashlib
import typing
import weakref
from pathlib import Path

import numpy as np

from . import archive, description
from .errors import InputError

KIND = "Nephele scene description"
VERSION = 2
CLASSES = {
    name: value
    for name, value in vars(description).items()
    if isinstance(value, type)
    and dataclasses.is_dataclass(value)
    and value.__module__ == description.__name__
}
BLOCK_BYTES = 1 << 24
UUID_BYTES = slice(21, 57)  # where a VDB file holds an identifier that is new each time it is written


def save(path, scene):
    """Writes `scene`, a description.Scene, with its VDB files to `path`. Raises InputError naming an
    unreadable file."""
    numbered = {}
    header = {"scene": encoded(scene, numbered), "vdbs": []}
    arrays = {str(number): array for number, array in numbered.values()}
    for number, vdb in enumerate(unique_vdbs(scene)):
        header["vdbs"].append({"path": str(vdb), "name": Path(vdb).name, "array": f"vdb{number}"})
        arrays[f"vdb{number}"] = vdb_bytes(vdb)
    archive.write(path, KIND, VERSION, header, arrays)


def load(path, directory):
    """Returns the description.Scene in `path`, its VDB files unpacked into `directory`.

    Raises InputError naming the file where it is missing, damaged or of another version.
    """
    header, arrays = archive.read(path, KIND, VERSION)
    try:
        scene = decoded(header["scene"], arrays)
        if not isinstance(scene, description.Scene):
            raise TypeError("its root is no Scene")
        places = {}
        for number, vdb in enumerate(header["vdbs"]):
            place = Path(directory) / str(number) / Path(vdb["name"]).name
            place.parent.mkdir(parents=True)
            place.write_bytes(arrays[vdb["array"]].tobytes())
            places[vdb["path"]] = str(place)
        volumes = tuple(dataclasses.replace(volume, path=places[volume.path]) for volume in scene.volumes)
        return dataclasses.replace(scene, volumes=volumes)
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise InputError(f"{path}: not a {KIND}, or damaged ({error})") from error


def fingerprint(scene):
    """Returns a text that is equal for scenes of equal content, settings, film and warnings apart; those may
    differ."""
    numbered = {}
    volumes = tuple(dataclasses.replace(volume, path="") for volume in scene.volumes)
    bare = dataclasses.replace(scene, volumes=volumes, settings={}, film=description.Film(1, 1), warnings=())
    digest = hashlib.blake2b(repr(encoded(bare, numbered)).encode(), digest_size=16)
    for _, array in numbered.values():
        digest.update(array_digest(array))
    for vdb in unique_vdbs(scene):
        for block in vdb_blocks(vdb):
            digest.update(block)
    return digest.hexdigest()


def array_digest(array):
    """Returns 16 bytes that stand for type, shape and content. Those of a large array that cannot change are
    remembered for as long as it lives: the frames of an animation share such."""
    known = _digests.get(id(array))
    if known is not None:
        return known
    digest = hashlib.blake2b(f"{array.dtype}{array.shape}".encode(), digest_size=16)
    digest.update(np.ascontiguousarray(array).data)
    if array.nbytes >= BLOCK_BYTES >> 8 and not array.flags.writeable:
        _digests[id(array)] = digest.digest()
        weakref.finalize(array, _digests.pop, id(array), None)
    return digest.digest()


_digests = {}  # id of an array -> digest


def unique_vdbs(scene):
    """Returns the paths of the scene's VDB files, each once, in order."""
    return list(dict.fromkeys(volume.path for volume in scene.volumes))


def vdb_bytes(path):
    """Returns the file's content as uint8. Raises InputError naming the file."""
    try:
        return np.fromfile(path, np.uint8)
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error


def vdb_blocks(path):
    """Yields the file's content piece by piece, its identifier zeroed. Raises InputError naming the file."""
    try:
        with Path(path).open("rb") as file:
            first = bytearray(file.read(UUID_BYTES.stop))
            first[UUID_BYTES] = bytes(len(first[UUID_BYTES]))
            yield first
            while block := file.read(BLOCK_BYTES):
                yield block
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error


def encoded(value, numbered):
    """Returns `value` as JSON values; adds its numpy arrays to `numbered`, a dict of id(array) -> (number,
    array).

    An array that several meshes or programs share is stored once.
    """
    if value is None or isinstance(value, (bool, int, float, str)):
        return value
    if isinstance(value, np.generic):
        return value.item()
    if isinstance(value, np.ndarray):
        return {"array": numbered.setdefault(id(value), (len(numbered), value))[0]}
    if isinstance(value, (tuple, list)):
        return {"tuple": [encoded(item, numbered) for item in value]}
    if isinstance(value, dict):
        return {"dict": {key: encoded(item, numbered) for key, item in value.items()}}
    fields = {
        field.name: encoded(getattr(value, field.name), numbered) for field in dataclasses.fields(value)
    }
    return {"type": type(value).__name__, "fields": fields}


def decoded(value, arrays):
    """Returns what encoded() was given. `arrays`: dict of number as text -> array."""
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return arrays[str(value["array"])]
    if "tuple" in value:
        return tuple(decoded(item, arrays) for item in value["tuple"])
    if "dict" in value:
        return {key: decoded(item, arrays) for key, item in value["dict"].items()}
    fields = {name: decoded(item, arrays) for name, item in value["fields"].items()}
    return checked(CLASSES[value["type"]](**fields))


def checked(item):
    """Returns a dataclass of the description; raises TypeError naming the field that is not of its type."""
    for name, kind in typing.get_type_hints(type(item)).items():
        kinds = typing.get_args(kind) or (kind,)
        value = getattr(item, name)
        if not isinstance(value, (*kinds, int) if float in kinds else kinds):
            raise TypeError(f"{type(item).__name__}.{name} is of type {type(value).__name__}")
    return item
