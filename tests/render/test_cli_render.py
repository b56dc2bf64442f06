# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed command line with Blender, the exporter and the native renderer, on bundled scenes, as
processes."""

import json
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from nephele import exr

SCENES = Path(__file__).resolve().parents[2] / "blend_scenes"
FURNACE = SCENES / "furnace" / "furnace.blend"
CLOUD = SCENES / "cloud" / "cloud.blend"
TINY = ("--resolution", "32x18", "--samples", "4")
FOREVER = ("--resolution", "256x144", "--samples", "1000000")


def command(*arguments):
    return [sys.executable, "-m", "nephele", *map(str, arguments)]


def run(*arguments):
    """Returns the finished process of a command line."""
    return subprocess.run(command(*arguments), capture_output=True, text=True, check=False, timeout=300)


def assert_refused(done, *words):
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1), done.stderr
    assert all(word in done.stderr for word in words), done.stderr


def pixels(path):
    return exr.read(path)["Combined"][1]


def test_denoise_cleans_combined_and_keeps_the_noisy_image(tmp_path):
    noisy, clean = tmp_path / "noisy.exr", tmp_path / "clean.exr"
    same_kernel = ("--passes", "Combined,Denoising Albedo")  # rounding differs from kernel to kernel
    for out, more in ((noisy, same_kernel), (clean, ("--denoise",))):
        done = run("render", CLOUD, "-o", out, "--quiet", *TINY, *more)
        assert done.returncode == 0, done.stderr
    passes = exr.read(clean)
    assert "Noisy Image" not in exr.read(noisy) and "Denoising Albedo" not in passes
    np.testing.assert_array_equal(passes["Noisy Image"][1], pixels(noisy))
    combined = passes["Combined"][1]
    np.testing.assert_array_equal(combined[..., 3], pixels(noisy)[..., 3])

    def roughness(image):
        return np.abs(np.diff(image[..., :3], axis=1)).mean()

    assert roughness(combined) < 0.7 * roughness(pixels(noisy))


def test_render_writes_image_and_statistics(tmp_path):
    out, png, stats = (tmp_path / name for name in ("a.exr", "a.png", "a.json"))
    done = run(
        "render",
        CLOUD,
        "-o",
        out,
        "--png",
        png,
        "--stats",
        stats,
        "--passes",
        "Combined,Depth,Variance",
        *TINY,
    )
    assert (done.returncode, done.stdout) == (0, ""), done.stderr
    content = json.loads(stats.read_text())
    assert content["samples_done"] == 4
    assert content["nonfinite_samples"] == 0
    assert content["rays"] > 32 * 18 * 4
    assert content["density_lookups"] > 0
    assert 0 < content["path_segments"] <= content["rays"]
    assert content["grids"]
    assert content["seconds"]["render"] > 0
    assert (
        0
        < content["first_tile_seconds"]
        < content["process_to_first_tile_seconds"]
        < content["seconds"]["total"]
    )
    assert set(content["passes"]) == set(exr.read(out)) == {"Combined", "Depth", "Variance"}
    assert np.isfinite(pixels(out)).all()
    assert pixels(out)[..., :3].max() > 0
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.exr", "a.json", "a.png"]


def test_the_same_seed_gives_the_same_image_on_any_number_of_threads(tmp_path):
    for name, options in (("a", ("--threads", 1)), ("b", ("--threads", 3)), ("c", ("--seed", 1))):
        assert run("render", CLOUD, "-o", tmp_path / f"{name}.exr", *TINY, *options).returncode == 0
    a, b, c = (pixels(tmp_path / f"{name}.exr") for name in "abc")
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


def test_description_renders_bit_for_bit_like_its_blend(tmp_path):
    saved = tmp_path / "cloud.nephele"
    assert run("render", CLOUD, "-o", tmp_path / "a.exr", *TINY, "--save-description", saved).returncode == 0
    done = run("render", saved, "-o", tmp_path / "b.exr")
    assert done.returncode == 0, done.stderr
    np.testing.assert_array_equal(pixels(tmp_path / "a.exr"), pixels(tmp_path / "b.exr"))


def cancel_in(seconds, *arguments):
    """Starts a command line and sends SIGINT once it has rendered for `seconds`; returns (process, seconds to
    exit)."""
    process = subprocess.Popen(command(*arguments), stderr=subprocess.PIPE, stdout=subprocess.PIPE)
    try:
        deadline = time.monotonic() + 120
        line = b""
        while b"samples" not in line:  # the first line of progress comes some seconds into the render
            assert time.monotonic() < deadline
            line = process.stderr.readline()
        time.sleep(seconds)
        process.send_signal(signal.SIGINT)
        begin = time.monotonic()
        process.communicate(timeout=60)
        return process, time.monotonic() - begin
    finally:
        process.kill()
        process.wait()


def test_interrupt_exits_with_130_within_a_second_and_writes_no_image(tmp_path):
    process, seconds = cancel_in(0.3, "render", CLOUD, "-o", tmp_path / "a.exr", *FOREVER)
    assert process.returncode == 130
    assert seconds < 1
    assert [path.name for path in tmp_path.iterdir()] == ["a.exr.checkpoint.npz"]


def test_interrupt_while_starting_leaves_nothing(tmp_path):
    process = subprocess.Popen(
        command("render", CLOUD, "-o", tmp_path / "a.exr", *FOREVER), stderr=subprocess.PIPE
    )
    time.sleep(1.0)
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode in (130, -signal.SIGINT)  # the latter before Python is ready for signals
    assert {path.name for path in tmp_path.iterdir()} <= {"a.exr.checkpoint.npz"}


def test_resumed_render_equals_uninterrupted_one(tmp_path):
    arguments = (CLOUD, "--resolution", "64x36", "--samples", "64")
    out, stats = tmp_path / "a.exr", tmp_path / "a.json"
    assert run("render", *arguments, "-o", tmp_path / "whole.exr").returncode == 0
    limited = run("render", *arguments, "-o", out, "--stats", stats, "--time-limit", "0.15")
    assert limited.returncode == 0, limited.stderr
    assert json.loads(stats.read_text())["samples_done"] < 64
    assert (tmp_path / "a.exr.checkpoint.npz").exists()
    resumed = run("render", *arguments, "-o", out, "--stats", stats, "--resume")
    assert resumed.returncode == 0, resumed.stderr
    assert json.loads(stats.read_text())["samples_done"] == 64
    np.testing.assert_array_equal(pixels(out), pixels(tmp_path / "whole.exr"))
    assert not (tmp_path / "a.exr.checkpoint.npz").exists()


def test_resume_refuses_another_seed(tmp_path):
    arguments = ("render", CLOUD, "-o", tmp_path / "a.exr", *FOREVER)
    assert run(*arguments, "--time-limit", "0.3").returncode == 0
    assert_refused(run(*arguments, "--resume", "--seed", 7), "a.exr.checkpoint.npz", "seed")


@pytest.mark.parametrize("damage", ["missing", "empty", "cut", "noise"])
def test_bad_vdb_is_named(tmp_path, damage):
    """Copies the cloud's folder and spoils its VDB file."""
    folder = tmp_path / "cloud"
    shutil.copytree(CLOUD.parent, folder)
    vdb = folder / "cloud.vdb"
    data = vdb.read_bytes()
    if damage == "missing":
        vdb.unlink()
    else:
        vdb.write_bytes({"empty": b"", "cut": data[: len(data) // 2], "noise": b"VDB?" + bytes(500)}[damage])
    assert_refused(run("render", folder / "cloud.blend", "-o", tmp_path / "a.exr", *TINY), "cloud.vdb")
    assert [path.name for path in tmp_path.iterdir()] == ["cloud"]


def test_info_and_settings_print_json():
    done = run("info", CLOUD, "--json")
    assert (done.returncode, done.stderr) == (0, "")
    report = json.loads(done.stdout)
    grids = report["volumes"][0]["grids"]
    assert any(grid["used"] and grid["active_voxels"] > 1000 for grid in grids)
    assert report["kernel_features"]
    assert json.loads(run("settings", "--json").stdout)[0]["name"] == "samples"


def test_compare_against_itself(tmp_path):
    out = tmp_path / "a.exr"
    assert run("render", FURNACE, "-o", out, *TINY).returncode == 0
    done = run("compare", out, out, "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["passes"]["Combined"]["relmse"] == 0
