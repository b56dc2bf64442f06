# SPDX-License-Identifier: GPL-3.0-or-later
"""Description files: what is saved comes back, VDB files included; damage and other versions are refused."""

import dataclasses
import gc
import math

import fake_native
import numpy as np
import pytest
from nephele import archive, description, description_file
from nephele.errors import InputError


def full_scene(vdb):
    """Returns a description.Scene in which every kind of value occurs."""
    generator = np.random.default_rng(5)
    shared = generator.random((4, 3, 3), np.float32)
    program = description.Program(
        registers=generator.random((3, 3), np.float32),
        code=np.arange(16, dtype=np.int32).reshape(2, 8),
        parameters=np.zeros(0, np.float32),
        closures=(description.Closure("principled", 0, (1, -1, 2), 1),),
    )
    mesh = description.Mesh(
        "Ümlaut/..\\n",
        generator.random((5, 3), np.float32),
        np.array([[0, 1, 2]] * 4, np.int32),
        corner_normals=shared,
        uvs=(shared[..., :2].copy(), shared[..., 1:].copy()),
        material_index=np.zeros(4, np.int32),
    )
    base = fake_native.scene(crop=(1, 2, 9, 7), transparent=True, mist=(1.0, math.inf, "linear"))
    return dataclasses.replace(
        base,
        settings={"samples": 3, "clamp": 0.5, "sampler": "independent"},
        meshes=(mesh, dataclasses.replace(mesh, name="Twin")),
        volumes=tuple(description.Volume(f"Smoke {n}", str(vdb), np.eye(4) * n, 0, n / 3) for n in (1, 2)),
        materials=(
            description.Material("Both", program, (description.VolumeClosure(emission_grid="flame"),)),
        ),
        images=(description.Image("Bricks", generator.integers(0, 255, (2, 3, 4), np.uint8), srgb=True),),
        lights=(
            description.Light("Sun", "sun", np.eye(4), (np.float32(0.1), 2.0, 3.0), angle=np.float64(0.01)),
        ),
        world=description.World(program, visibility=3),
        warnings=("Something was left out",),
    )


@pytest.fixture
def vdb(tmp_path):
    path = tmp_path / "source" / "smoke_0001.vdb"
    path.parent.mkdir()
    path.write_bytes(np.random.default_rng(2).bytes(5000))
    return path


def assert_equal(a, b):
    """Compares two values of a description, arrays with their types."""
    if isinstance(a, np.ndarray):
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    elif dataclasses.is_dataclass(a):
        assert type(a) is type(b)
        for field in dataclasses.fields(a):
            assert_equal(getattr(a, field.name), getattr(b, field.name))
    elif isinstance(a, tuple):
        assert len(a) == len(b)
        for one, other in zip(a, b, strict=True):
            assert_equal(one, other)
    else:
        assert a == b


def test_round_trip_needs_no_other_file(tmp_path, vdb):
    scene, path, content = full_scene(vdb), tmp_path / "scene.nephele", vdb.read_bytes()
    description_file.save(path, scene)
    vdb.unlink()
    loaded = description_file.load(path, tmp_path / "new")
    assert {volume.path for volume in loaded.volumes} == {str(tmp_path / "new" / "0" / "smoke_0001.vdb")}
    assert (tmp_path / "new" / "0" / "smoke_0001.vdb").read_bytes() == content
    restored = tuple(dataclasses.replace(volume, path=str(vdb)) for volume in loaded.volumes)
    assert_equal(dataclasses.replace(loaded, volumes=restored), scene)


def test_shared_arrays_are_stored_once(tmp_path, vdb):
    description_file.save(tmp_path / "scene.nephele", full_scene(vdb))
    loaded = description_file.load(tmp_path / "scene.nephele", tmp_path / "new")
    assert loaded.meshes[0].corner_normals is loaded.meshes[1].corner_normals


def test_missing_vdb_is_named_and_leaves_no_file(tmp_path, vdb):
    scene = full_scene(vdb)
    vdb.unlink()
    with pytest.raises(InputError, match=r"smoke_0001\.vdb: cannot be read"):
        description_file.save(tmp_path / "scene.nephele", scene)
    assert [entry.name for entry in tmp_path.iterdir()] == ["source"]


def test_damage_never_goes_unnoticed(tmp_path, vdb):
    """Flipped bits and cut ends: refused, or (in bytes that carry nothing, such as dates) without effect."""
    scene, path, broken = full_scene(vdb), tmp_path / "scene.nephele", tmp_path / "broken.nephele"
    description_file.save(path, scene)
    good, generator = path.read_bytes(), np.random.default_rng(11)
    reference = description_file.fingerprint(scene)
    refused = 0
    for trial in range(300):
        data = bytearray(good)
        if trial % 10 == 0:
            del data[generator.integers(len(data)) :]
        else:
            data[generator.integers(len(data))] ^= 1 << generator.integers(8)
        broken.write_bytes(data)
        try:
            loaded = description_file.load(broken, tmp_path / f"new{trial}")
        except InputError as error:
            refused += 1
            assert str(error).startswith(str(broken))
        else:
            assert description_file.fingerprint(loaded) == reference
    assert refused > 200


@pytest.mark.parametrize(
    ("kind", "version", "content", "words"),
    [
        (description_file.KIND, 99, {}, "of version 99"),
        ("Nephele checkpoint", 1, {}, "holds a Nephele checkpoint"),
        (description_file.KIND, description_file.VERSION, {}, "damaged"),
        (
            description_file.KIND,
            description_file.VERSION,
            {"scene": {"type": "Popen", "fields": {}}},
            "Popen",
        ),
        (
            description_file.KIND,
            description_file.VERSION,
            {"scene": {"type": "Film", "fields": {"x": 1}}},
            "'x'",
        ),
        (description_file.KIND, description_file.VERSION, {"scene": 3, "vdbs": []}, "no Scene"),
    ],
)
def test_other_content_is_refused(tmp_path, kind, version, content, words):
    archive.write(tmp_path / "other", kind, version, content, {})
    with pytest.raises(InputError, match=words):
        description_file.load(tmp_path / "other", tmp_path / "new")


def test_pickles_are_refused(tmp_path):
    with (tmp_path / "evil").open("wb") as file:
        np.savez(file, header=np.array([{"kind": description_file.KIND}], object))
    with pytest.raises(InputError, match="evil"):
        description_file.load(tmp_path / "evil", tmp_path / "new")


def test_fingerprint_tells_content_from_circumstances(tmp_path, vdb):
    scene = full_scene(vdb)
    reference = description_file.fingerprint(scene)
    other_film = dataclasses.replace(scene, settings={}, warnings=(), film=description.Film(3, 3))
    assert description_file.fingerprint(other_film) == reference

    moved = tmp_path / "moved.vdb"
    data = bytearray(vdb.read_bytes())
    data[21:57] = b"-" * 36  # the file's UUID, new each time the same grids are written
    moved.write_bytes(data)
    volumes = tuple(dataclasses.replace(volume, path=str(moved)) for volume in scene.volumes)
    assert description_file.fingerprint(dataclasses.replace(scene, volumes=volumes)) == reference

    data[100] ^= 1
    moved.write_bytes(data)
    assert description_file.fingerprint(dataclasses.replace(scene, volumes=volumes)) != reference
    scene.meshes[0].positions[1, 1] += 1
    assert description_file.fingerprint(scene) != reference


def test_digests_are_remembered_only_while_they_hold():
    array = np.arange(1 << 17, dtype=np.float64)
    before = description_file.array_digest(array)
    array[5] = -1
    assert description_file.array_digest(array) != before
    array[5] = 5
    array.flags.writeable = False
    assert description_file.array_digest(array) == description_file.array_digest(array) == before
    assert description_file.array_digest(array.reshape(2, -1)) != before
    remembered = len(description_file._digests)
    del array
    gc.collect()
    assert len(description_file._digests) < remembered
