# SPDX-License-Identifier: GPL-3.0-or-later
"""Descriptions with values of another type or out of place: each is refused with one ValueError that says
where."""

import dataclasses

import nephele_native
import numpy as np
import pytest
from nephele import description as d
from nephele import description_file
from nephele.errors import InputError
from small_world import small_world

SETTINGS = {"samples": 1, "threads": 1}


def world():
    return small_world().description(size=4, **SETTINGS)


def changed(part, **fields):
    """Returns the small world with fields of one of its parts, the first of its kind, replaced."""
    whole = world()
    old = getattr(whole, part)
    if not isinstance(old, tuple):
        return dataclasses.replace(whole, **{part: dataclasses.replace(old, **fields)})
    return dataclasses.replace(whole, **{part: (dataclasses.replace(old[0], **fields), *old[1:])})


CASES = [
    ("camera", {"clip_start": "near"}, "clip_start"),
    ("camera", {"viewplane": (0.0, 1.0)}, "camera"),
    ("camera", {"world_from_camera": None}, "world_from_camera"),
    ("film", {"width": 4.5}, "width"),
    ("film", {"crop": (0, 0)}, "film"),
    ("film", {"crop": (0, 0, 5, 4)}, "region inside it"),
    ("film", {"crop": (-(2**31), 0, 2**31 - 1, 4)}, "region inside it"),
    ("film", {"width": 2**40}, "width"),
    ("film", {"passes": 7}, "film"),
    ("film", {"mist": ()}, "film"),
    ("world", {"background": ()}, "world"),
    ("world", {"volume": 3.0}, "volume"),
    ("lights", {"power": (1.0, 2.0)}, "lights 'lamp'.*power"),
    ("lights", {"name": None}, "lights.*name"),
    ("instances", {"mesh": -1}, "instances 'box'.*mesh"),
    ("instances", {"color": "red"}, "instances 'box'"),
    ("materials", {"volume": (None,)}, "materials 'material 0'"),
    ("volumes", {"generated_min": 1.0}, "volumes 'volume'.*generated_min"),
    ("meshes", {"uvs": None}, "meshes 'box'.*uvs"),
]


@pytest.mark.parametrize(("part", "fields", "words"), CASES, ids=lambda v: str(v)[:30])
def test_what_is_wrong_is_named(part, fields, words):
    with pytest.raises(ValueError, match=words) as caught:
        nephele_native.Renderer(changed(part, **fields))
    assert "std::" not in str(caught.value)


@pytest.mark.parametrize("settings", [None, {"samples": None}, {"samples": "many"}, {1: 2}, {"seed": ()}])
def test_settings_of_other_types(settings):
    with pytest.raises(ValueError, match=r"settings|samples|seed"):
        nephele_native.Renderer(dataclasses.replace(world(), settings=settings))


def test_parts_of_other_types():
    for field in dataclasses.fields(d.Scene):
        if field.name == "warnings":
            continue  # for the user alone
        for value in (3.5, "text", (None,)):
            with pytest.raises(ValueError, match=r"\w"):
                nephele_native.Renderer(dataclasses.replace(world(), **{field.name: value}))


def test_a_file_with_a_field_of_another_type_is_damaged(tmp_path):
    path = tmp_path / "scene.npz"
    for part, fields in (
        ("film", {"width": "wide"}),
        ("camera", {"motion": 1.0}),
        ("volumes", {"random": None}),
    ):
        description_file.save(path, changed(part, **fields))
        with pytest.raises(InputError, match=f"damaged.*{next(iter(fields))}"):
            description_file.load(path, tmp_path / "unpacked")


def test_a_grid_that_the_file_lacks_is_left_out_with_a_warning():
    whole = world()
    material = whole.materials[whole.volumes[0].material]
    closure = dataclasses.replace(material.volume[0], density_grid="nothing")
    materials = (dataclasses.replace(material, volume=(*material.volume, closure)), *whole.materials[1:])
    renderer = nephele_native.Renderer(dataclasses.replace(whole, materials=materials))
    assert any('has no grid "nothing"' in warning for warning in renderer.warnings)
    assert any(grid["grid"] == "density" for grid in renderer.statistics()["grids"])


def test_whole_numbers_may_stand_for_others():
    scene = changed("camera", clip_start=1, motion=np.stack([np.eye(4)] * 2))
    nephele_native.Renderer(scene)
