# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of what a render learned: round trip, and everything that is refused. The renderer is a stand-in."""

import dataclasses

import fake_native
import numpy as np
import pytest
from nephele import archive, description, guiding_file
from nephele.errors import InputError

VERSION = "1.2"


class Learned:
    """A renderer that has learned two arrays."""

    def knowledge(self):
        return {"field_nodes_volume": np.arange(3.0), "image_sums": np.zeros(0)}


@pytest.fixture
def saved(tmp_path):
    path = tmp_path / "field.npz"
    guiding_file.save(path, Learned(), fake_native.scene(), VERSION)
    return path


def test_round_trip(saved):
    arrays = guiding_file.load(saved, fake_native.scene(), VERSION)
    assert arrays.keys() == Learned().knowledge().keys()
    for name, values in Learned().knowledge().items():
        np.testing.assert_array_equal(arrays[name], values)


def test_what_moves_or_shines_otherwise_still_fits(saved):
    scene = fake_native.scene(width=99)
    moved = dataclasses.replace(scene.instances[0], world_from_object=np.diag((2.0, 2, 2, 1)))
    guiding_file.load(saved, dataclasses.replace(scene, instances=(moved,)), VERSION)


def test_another_scene_is_refused_by_the_names_of_its_objects(saved):
    scene = fake_native.scene()
    other = dataclasses.replace(
        scene,
        instances=tuple(dataclasses.replace(scene.instances[0], name=f"Cube {i}") for i in range(5)),
        lights=(description.Light("Key", "point", np.eye(4), (1.0, 1.0, 1.0)),),
    )
    with pytest.raises(InputError) as error:
        guiding_file.load(saved, other, VERSION)
    text = str(error.value)
    assert str(saved) in text
    assert "meshes 'Square' are not here" in text
    assert "'Cube 0', 'Cube 1', 'Cube 2' and 2 more were not there" in text
    assert "lights 'Key' were not there" in text


def test_another_version_of_the_program_is_refused(saved):
    with pytest.raises(InputError, match=r"made by version 1\.2, this is 2\.0"):
        guiding_file.load(saved, fake_native.scene(), "2.0")


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 cut", b"something else"])
def test_damaged_files_are_refused(saved, content):
    saved.write_bytes(content)
    with pytest.raises(InputError, match="not a Nephele guiding field, or damaged"):
        guiding_file.load(saved, fake_native.scene(), VERSION)


def test_files_of_another_kind_and_missing_ones_are_refused(saved, tmp_path):
    archive.write(saved, "Nephele checkpoint", 1, {}, {})
    with pytest.raises(InputError, match="holds a Nephele checkpoint"):
        guiding_file.load(saved, fake_native.scene(), VERSION)
    with pytest.raises(InputError, match="no such file"):
        guiding_file.load(tmp_path / "none.npz", fake_native.scene(), VERSION)


def test_a_header_without_its_parts_is_refused(saved):
    archive.write(saved, guiding_file.KIND, guiding_file.VERSION, {"program": VERSION, "scene": None}, {})
    with pytest.raises(InputError, match="damaged"):
        guiding_file.load(saved, fake_native.scene(), VERSION)
