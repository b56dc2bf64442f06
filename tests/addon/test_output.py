# SPDX-License-Identifier: GPL-3.0-or-later
"""Output files: EXR channels and windows, PNG encoding, frame numbers, all or nothing."""

import json
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from nephele import cryptomatte, description, description_source, exr, output
from nephele.errors import InputError
from PIL import Image


def test_exr_has_blenders_layout(tmp_path):
    film = description.Film(6, 5, crop=(1, 2, 5, 5), passes=("Combined", "Depth", "Volume Albedo"))
    generator = np.random.default_rng(4)
    images = {
        name: generator.normal(size=(3, 4, n)).astype(np.float32)
        for name, n in zip(film.passes, (4, 1, 3), strict=True)
    }
    exr.write(tmp_path / "a.exr", images, film, "My Layer", {"samples": "7"})
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        assert len(file.parts) == 1
        header, channels = file.header(), file.channels()
        assert set(channels) == {
            *(f"My Layer.Combined.{c}" for c in "RGBA"),
            *(f"My Layer.Volume Albedo.{c}" for c in "RGB"),
            "My Layer.Depth.Z",
        }
        assert header["compression"] == OpenEXR.ZIP_COMPRESSION
        # Rows count from the top: the crop's rows 2..4 from the bottom of 5 are rows 0..2.
        assert np.array(header["dataWindow"]).tolist() == [[1, 0], [4, 2]]
        assert np.array(header["displayWindow"]).tolist() == [[0, 0], [5, 4]]
        pixels = channels["My Layer.Combined.G"].pixels
        assert pixels.dtype == np.float32
        np.testing.assert_array_equal(pixels, images["Combined"][::-1, :, 1])
    read = exr.read(tmp_path / "a.exr")
    assert {name: letters for name, (letters, _) in read.items()} == {
        "Combined": "RGBA",
        "Volume Albedo": "RGB",
        "Depth": "Z",
    }
    np.testing.assert_array_equal(read["Combined"][1], images["Combined"][::-1])
    assert exr.read_attributes(tmp_path / "a.exr") == {"samples": "7"}


def test_exr_keeps_mattes_and_their_manifest(tmp_path):
    class Native:
        @staticmethod
        def matte_hash(name):
            return len(name) << 8  # a stand-in

    instances = tuple(
        description.Instance(name, 0, np.eye(4), materials, asset=asset)
        for name, materials, asset in (("Cube", (0, -1), "Root"), ("Ball", (0,), ""))
    )
    film = description.Film(2, 1, passes=("Combined", "CryptoAsset00", "CryptoMaterial00"))
    camera = description.Camera("camera", "perspective", np.eye(4), (-1, 1, -1, 1))
    scene = description.Scene(camera, film, instances=instances, materials=(description.Material("Gold"),))
    texts = cryptomatte.metadata(scene, "Layer", Native)
    assert set(texts) == {
        f"cryptomatte/{hashed:08x}"[: len("cryptomatte/") + 7] + f"/{what}"
        for hashed in (len("Layer.CryptoAsset") << 8, len("Layer.CryptoMaterial") << 8)
        for what in ("name", "hash", "conversion", "manifest")
    }
    manifests = [set(json.loads(text)) for name, text in texts.items() if name.endswith("manifest")]
    assert manifests == [{"Gold", "default_surface"}, {"Root", "Ball"}]
    images = {"CryptoAsset00": np.arange(8, dtype=np.float32).reshape(1, 2, 4)}
    exr.write(tmp_path / "a.exr", images, film, "Layer", {}, texts)
    letters, pixels = exr.read(tmp_path / "a.exr")["CryptoAsset00"]
    assert letters == "rgba"
    np.testing.assert_array_equal(pixels, images["CryptoAsset00"])
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        assert texts.items() <= file.header().items()


def test_exr_keeps_every_float(tmp_path):
    values = np.array([[[np.nan], [np.inf], [-np.inf], [1e-45], [3e38], [-0.0]]], np.float32)
    exr.write(tmp_path / "a.exr", {"Depth": values}, description.Film(6, 1))
    np.testing.assert_array_equal(exr.read(tmp_path / "a.exr")["Depth"][1], values)


def write_parts(path, parts):
    OpenEXR.File([OpenEXR.Part({}, channels, name) for name, channels in parts.items()]).write(str(path))


def test_reading_multi_part_files(tmp_path):
    """Blender 5 writes a part per pass with full channel names; others put the pass into the part's name
    alone."""
    one, two = np.ones((2, 3), np.float32), np.full((2, 3), 2, np.float32)
    colour = {f"ViewLayer.Combined.{c}": one * n for n, c in enumerate("RGB")}
    write_parts(
        tmp_path / "full.exr", {"ViewLayer.Combined": colour, "ViewLayer.Depth": {"ViewLayer.Depth.Z": two}}
    )
    write_parts(
        tmp_path / "short.exr",
        {"Combined": dict(zip("BGR", (two, one, 0 * one), strict=True)), "Depth": {"Z": two}},
    )
    for name in ("full.exr", "short.exr"):
        read = exr.read(tmp_path / name)
        assert {key: letters for key, (letters, _) in read.items()} == {"Combined": "RGB", "Depth": "Z"}
        assert read["Combined"][1][0, 0].tolist() == [0, 1, 2]
        assert read["Depth"][1][0, 0].tolist() == [2]


def test_reading_plain_and_several_layers(tmp_path):
    half = np.full((2, 3), 0.5, np.float16)
    OpenEXR.File({}, {"RGBA": np.dstack([half] * 4)}).write(str(tmp_path / "plain.exr"))
    letters, pixels = exr.read(tmp_path / "plain.exr")["Combined"]
    assert (letters, pixels.dtype, pixels.shape) == ("RGBA", np.float32, (2, 3, 4))
    layers = {f"{layer}.Depth.Z": half for layer in ("Near", "Far")}
    OpenEXR.File({}, layers).write(str(tmp_path / "layers.exr"))
    assert set(exr.read(tmp_path / "layers.exr")) == {"Near.Depth", "Far.Depth"}


def test_damaged_exr_is_named(tmp_path):
    exr.write(
        tmp_path / "a.exr",
        {"Depth": np.random.default_rng(1).random((40, 40, 1), np.float32)},
        description.Film(40, 40),
    )
    data = (tmp_path / "a.exr").read_bytes()
    (tmp_path / "a.exr").write_bytes(data[: len(data) // 2])
    with pytest.raises(InputError, match=r"a\.exr"):
        exr.read(tmp_path / "a.exr")


def test_atomic_leaves_the_old_file_on_failure(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("old")
    with pytest.raises(RuntimeError), output.atomic(path) as temporary:
        temporary.write_text("half")
        raise RuntimeError
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
    with output.atomic(path) as temporary:
        assert temporary.parent == tmp_path
        temporary.write_text("new")
        assert path.read_text() == "old"
    assert path.read_text() == "new"
    assert list(tmp_path.iterdir()) == [path]


def test_full_disk_is_told_in_one_line(tmp_path):
    with (
        pytest.raises(InputError, match=r"a\.txt: cannot be written: No space left"),
        output.atomic(tmp_path / "a.txt"),
    ):
        Path("/dev/full").write_text("x")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("path", "frame", "several", "expected"),
    [
        ("out/a.exr", None, False, "out/a.exr"),
        ("a#.exr", None, False, "a#.exr"),
        ("a.exr", 7, False, "a.exr"),
        ("a.exr", 7, True, "a0007.exr"),
        ("a_##.exr", 7, True, "a_07.exr"),
        ("#/a_###.exr", 1234, False, "#/a_1234.exr"),
        ("a####.exr", -5, True, "a-005.exr"),
    ],
)
def test_frame_path(path, frame, several, expected):
    assert output.frame_path(path, frame, several) == Path(expected)


def test_png_of_a_description_is_srgb_with_straight_alpha(tmp_path):
    pixels = np.zeros((2, 3, 4), np.float32)
    pixels[0, 0] = (0.5, 0.0, 2.0, 1.0)  # bottom left
    pixels[1, 2] = (0.25, 0.05, 0.0, 0.5)  # top right; premultiplied
    opaque = description_source.srgb_bytes(pixels[::-1], transparent=False)
    assert opaque.shape == (2, 3, 3)
    assert opaque[1, 0].tolist() == [188, 0, 255]  # IEC 61966-2-1 of 0.5 is 187.5 / 255
    straight = description_source.srgb_bytes(pixels[::-1], transparent=True)
    assert straight[0, 2].tolist() == [188, 89, 0, 128]
    Image.fromarray(straight).save(tmp_path / "a.png")
    assert Image.open(tmp_path / "a.png").mode == "RGBA"
