# SPDX-License-Identifier: GPL-3.0-or-later
"""Damaged files of Nephele's own: descriptions, checkpoints and guiding files, with bytes of the archive
altered, or its header, or its arrays. They are refused with InputError, or a renderer takes them up."""

import dataclasses
import functools
import io
import json
import tempfile
from pathlib import Path

import nephele_native
import numpy as np
from mutation import Bytes, mutated_array, strange
from nephele import checkpoint, description_file, guiding_file, parameters
from nephele.errors import InputError
from scenes import all_scenes

VERSION = nephele_native.__version__
KINDS = ("description", "checkpoint", "guiding")


@functools.cache
def scene():
    small = all_scenes()[0]
    return dataclasses.replace(
        small, settings=parameters.checked({**small.settings, "train_field": "always"})
    )


@functools.cache
def identity():
    return checkpoint.identity(scene(), description_file.fingerprint(scene()), VERSION)


@functools.cache
def originals():
    """Returns the bytes of one good file of each kind."""
    renderer = nephele_native.Renderer(scene())
    renderer.start()
    renderer.wait(60)
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / kind for kind in KINDS]
        description_file.save(paths[0], dataclasses.replace(scene(), volumes=()))
        checkpoint.save(paths[1], renderer, identity(), 1)
        guiding_file.save(paths[2], renderer, scene(), VERSION)
        return [path.read_bytes() for path in paths]


def test_one(data):
    """Takes any bytes; raises where a damaged file gets further than it should."""
    take = Bytes(data)
    kind = take.below(len(KINDS))
    content = originals()[kind]
    content = damaged_bytes(content, take) if take.below(4) == 0 else damaged_members(content, take)
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:
        path = Path(folder) / KINDS[kind]
        path.write_bytes(content)
        try:
            load(kind, path)
        except InputError as error:
            assert str(path) in str(error), f"an error that does not name the file: {error}"


def load(kind, path):
    """Does with the file what the command line would."""
    if kind == 0:
        description_file.load(path, path.parent / "unpacked")
        return  # what a description may hold is for fuzz_description.py
    renderer = nephele_native.Renderer(scene())
    if kind == 1:
        state, _ = checkpoint.load(path, identity(), scene().settings["samples"])
        take_up = renderer.restore
    else:
        state = guiding_file.load(path, scene(), VERSION)
        take_up = renderer.inherit
    try:
        take_up(state)
    except ValueError as error:
        raise InputError(f"{path}: {error}") from error
    renderer.start()
    assert renderer.wait(60), "it did not end"


def damaged_bytes(content, take):
    content = bytearray(content)
    for _ in range(1 + take.below(8)):
        place = (
            take.below(len(content))
            if take.below(2)
            else len(content) - 1 - take.below(min(len(content), 2000))
        )
        content[place] = take.below(256)
    return bytes(content[: take.below(len(content) + 1)] if take.below(8) == 0 else content)


def damaged_members(content, take):
    """Returns the archive with its header and arrays altered, whole as an archive."""
    with np.load(io.BytesIO(content)) as archive:
        members = {name: archive[name] for name in archive.files}
    header = json.loads(members["header"].tobytes())
    arrays = [name for name in members if name != "header"]
    for _ in range(1 + take.below(3)):
        if take.below(3) == 0:
            header = damaged_json(header, take)
        elif arrays:
            name = take.one_of(arrays)
            members[name] = mutated_array(members[name], take)
    text = json.dumps(header, default=str)
    members["header"] = np.frombuffer(text.encode(), np.uint8)
    file = io.BytesIO()
    np.savez(file, **members)
    return file.getvalue()


def damaged_json(value, take):
    """Returns JSON values with one of them replaced or taken away."""
    if isinstance(value, dict) and value and take.below(8):
        key = take.one_of(sorted(value))
        if take.below(8) == 0:
            return {k: v for k, v in value.items() if k != key}
        return {**value, key: damaged_json(value[key], take)}
    if isinstance(value, list) and value and take.below(8):
        place = take.below(len(value))
        return [*value[:place], damaged_json(value[place], take), *value[place + 1 :]]
    return strange(take)
