# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line: exit codes, one line per fault, overrides, resuming. The renderer is a fake
(fake_native.py)."""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import fake_native
import numpy as np
import pytest
from nephele import checkpoint, description, description_file, exr, parameters, passes, rendering


def slow(monkeypatch, seconds):
    monkeypatch.setattr(fake_native.Renderer, "SECONDS_PER_SAMPLE", seconds)


def combined(path):
    return exr.read(path)["Combined"][1]


def leftovers(folder):
    """Returns names of temporary files that should be gone."""
    return [entry.name for entry in Path(folder).iterdir() if entry.name.startswith(".")]


def test_render_writes_every_file(run, scene_file, tmp_path):
    out, png, stats = (tmp_path / name for name in ("a.exr", "a.png", "a.json"))
    code, stdout, _ = run(
        "render", scene_file, "-o", out, "--png", png, "--stats", stats, "--seed", 3, "--samples", 2
    )
    assert (code, stdout) == (0, "")
    content = json.loads(stats.read_text())
    assert content["settings"] == parameters.defaults() | {"samples": 2, "seed": 3}
    assert content["samples_done"] == 2
    assert content["resolution"] == [16, 8]
    assert set(content["seconds"]) >= {
        "export",
        "build",
        "train",
        "render",
        "write",
        "render_cpu",
        "blender_start",
    }
    assert 0 < content["first_tile_seconds"] <= content["process_to_first_tile_seconds"]
    assert content["peak_rss_bytes"] > 10**7
    assert len(content["passes"]["Combined"]["sha256"]) == 64
    assert content["warnings"] == ["the fake renders noise"]
    assert combined(out).shape == (8, 16, 4)
    assert png.read_bytes().startswith(b"\x89PNG")
    assert leftovers(tmp_path) == []
    assert not checkpoint.path_for(out).exists()


def test_description_needs_no_bpy(scene_file, tmp_path):
    code = f"""
import sys, fake_native
from nephele import cli
sys.modules["nephele.bridge"] = fake_native.bridge()
assert cli.main(["render", {str(scene_file)!r}, "-o", {str(tmp_path / "a.exr")!r}]) == 0
assert "bpy" not in sys.modules
"""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(Path(__file__).parent), *sys.path])}
    subprocess.run([sys.executable, "-c", code], check=True, env=environment)


def test_options_override_set_overrides_scene(run, scene_file, tmp_path):
    stats = tmp_path / "a.json"
    code, _, _ = run(
        "render", scene_file, "-o", tmp_path / "a.exr", "--stats", stats, "--passes", "depth,Combined",
        "--set", "samples=3", "--set", "seed=7", "--set", "integrator=plain", "--seed", "9",
    )  # fmt: skip
    content = json.loads(stats.read_text())
    assert code == 0
    assert (content["settings"]["samples"], content["settings"]["seed"]) == (3, 9)
    assert content["settings"]["integrator"] == "plain"
    assert list(content["passes"]) == ["Combined", "Depth"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["render", "missing.blend", "-o", "a.exr"], ["missing.blend", "no such file"]),
        (["render", "text.blend", "-o", "a.exr"], ["text.blend", "neither a .blend nor"]),
        (["render", "scene.nephele"], ["-o OUT.exr"]),
        (["render", "scene.nephele", "-o", "a.png"], ["a.png", ".exr"]),
        (["render", "scene.nephele", "-o", "missing/a.exr"], ["missing/a.exr", "does not exist"]),
        (["render", "scene.nephele", "-o", "/proc/a.exr"], ["/proc/a.exr", "cannot be written"]),
        (["render", "scene.nephele", "-o", "a.exr", "--stats", "a.exr"], ["a.exr", "twice"]),
        (["render", "scene.nephele", "-o", "a.exr", "--set", "sample=3"], ["'sample'", "samples"]),
        (["render", "scene.nephele", "-o", "a.exr", "--set", "samples"], ["NAME=VALUE"]),
        (["render", "scene.nephele", "-o", "a.exr", "--set", "samples=many"], ["samples", "'many'"]),
        (["render", "scene.nephele", "-o", "a.exr", "--samples", "0"], ["samples", "outside"]),
        (
            ["render", "scene.nephele", "-o", "a.exr", "--set", "tracking=magic"],
            ["'magic'", "weighted_delta"],
        ),
        (["render", "scene.nephele", "-o", "a.exr", "--passes", "Combined,Beauty"], ["'Beauty'", "Combined"]),
        (
            ["render", "scene.nephele", "-o", "a.exr", "--png", "a.png", "--passes", "Depth"],
            ["a.png", "Combined"],
        ),
        (["render", "scene.nephele", "-o", "a.exr", "--resolution", "16"], ["--resolution", "640x360"]),
        (["render", "scene.nephele", "-o", "a.exr", "--resolution", "16x0"], ["--resolution", "'16x0'"]),
        (["render", "scene.nephele", "-o", "a.exr", "--resolution", "16x16"], ["16x16", "16x8"]),
        (["render", "scene.nephele", "-o", "a.exr", "--frames", "3-1"], ["--frames", "'3-1'"]),
        (["render", "scene.nephele", "-o", "a.exr", "--frame", "3"], ["scene.nephele", "one frame"]),
        (["render", "cut.nephele", "-o", "a.exr"], ["cut.nephele", "damaged"]),
        (["render", "scene.nephele", "--frobnicate"], ["frobnicate"]),
        (["compare", "missing.exr", "missing.exr"], ["missing.exr", "no such file"]),
        (["compare", "text.blend", "text.blend"], ["text.blend", "not an OpenEXR file"]),
        (["compare", "a", "b", "--metric", "psnr"], ["'psnr'", "relmse"]),
        (["info", "text.blend"], ["text.blend"]),
        (["paint"], ["paint"]),
        ([], ["COMMAND"]),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(run, scene_file, tmp_path, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    Path("text.blend").write_text("hello")
    Path("cut.nephele").write_bytes(scene_file.read_bytes()[:3000])
    before = sorted(Path().iterdir())
    code, stdout, stderr = run(*arguments)
    assert code == 2
    assert stdout == ""
    assert stderr.count("\n") == 1
    assert all(word in stderr for word in words), stderr
    assert sorted(Path().iterdir()) == before


def test_native_refusal_is_bad_input(run, tmp_path, monkeypatch):
    vdb = tmp_path / "smoke.vdb"
    vdb.write_bytes(bytes(100))
    path = tmp_path / "scene.nephele"
    description_file.save(
        path, fake_native.scene(volumes=(description.Volume("Smoke", str(vdb), np.eye(4), 0),))
    )

    def refuse(scene, parts):
        os.write(1, b"OpenVDB complains\n")
        os.write(2, b"twice\n")
        raise ValueError(f"{scene.volumes[0].path}: not a VDB file")

    monkeypatch.setattr(sys.modules["nephele.bridge"], "create_renderer", refuse)
    code, stdout, stderr = run("render", path, "-o", tmp_path / "a.exr")
    assert (code, stdout, stderr.count("\n")) == (2, "", 1)
    assert "smoke.vdb: not a VDB file" in stderr


def test_internal_fault_is_not_swallowed(run, scene_file, tmp_path, monkeypatch):
    def fail(self):
        raise RuntimeError("thread 3 failed")

    monkeypatch.setattr(fake_native.Renderer, "start", fail)
    with pytest.raises(RuntimeError, match="thread 3"):
        run("render", scene_file, "-o", tmp_path / "a.exr")
    assert not (tmp_path / "a.exr").exists()


def test_quiet_says_nothing(run, scene_file, tmp_path):
    assert run("render", scene_file, "-o", tmp_path / "a.exr", "--quiet") == (0, "", "")


def test_cancel_writes_checkpoint_and_resume_continues_bit_for_bit(run, scene_file, tmp_path, monkeypatch):
    whole, out = tmp_path / "whole.exr", tmp_path / "a.exr"
    assert run("render", scene_file, "-o", whole, "--samples", 30)[0] == 0
    slow(monkeypatch, 0.1)
    monkeypatch.setattr(fake_native.Renderer, "INTERRUPT_AT", 6)
    code, _, stderr = run("render", scene_file, "-o", out, "--samples", 30)
    assert code == 130
    assert "--resume continues" in stderr
    assert not out.exists()
    assert checkpoint.path_for(out).exists()
    slow(monkeypatch, 0.0)
    monkeypatch.setattr(fake_native.Renderer, "INTERRUPT_AT", None)
    code, _, stderr = run("render", scene_file, "-o", out, "--samples", 30, "--resume")
    assert code == 0
    assert "going on after" in stderr
    assert not checkpoint.path_for(out).exists()
    np.testing.assert_array_equal(combined(out), combined(whole))
    assert leftovers(tmp_path) == []


def test_cancel_while_building_does_not_wait_for_it(run, scene_file, tmp_path, monkeypatch):
    release, begin = threading.Event(), []

    def build(scene, parts):
        begin.append(time.monotonic())
        threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
        release.wait(30)

    monkeypatch.setattr(sys.modules["nephele.bridge"], "create_renderer", build)
    code, _, stderr = run("render", scene_file, "-o", tmp_path / "a.exr")
    assert time.monotonic() - begin[0] < 10
    assert code == 130
    assert stderr == "nephele: cancelled\n"
    assert rendering.abandoned()
    assert [path.name for path in tmp_path.iterdir()] == ["scene.nephele"]
    release.set()


def test_time_limit_writes_image_and_checkpoint(run, scene_file, tmp_path, monkeypatch):
    out, stats = tmp_path / "a.exr", tmp_path / "a.json"
    slow(monkeypatch, 0.05)
    arguments = ("render", scene_file, "-o", out, "--stats", stats, "--samples", 1000)
    assert run(*arguments, "--time-limit", 0.4)[0] == 0
    first = json.loads(stats.read_text())["samples_done"]
    assert 0 < first < 1000
    assert checkpoint.path_for(out).exists()
    slow(monkeypatch, 0.0)
    assert run(*arguments, "--resume")[0] == 0
    assert json.loads(stats.read_text())["samples_done"] == 1000


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (["--seed", 5], "setting seed was 0, is 5"),
        (["--set", "clamp=2"], "setting clamp was 0.0, is 2.0"),
        (["--resolution", "32x16"], "film's width was 16, is 32"),
        (["--passes", "Combined,Depth"], "film's passes was Combined, is Combined, Depth"),
        (["--samples", 1], "more than the 1 asked for"),
    ],
)
def test_resume_refuses_another_render(run, scene_file, tmp_path, monkeypatch, change, words):
    out = tmp_path / "a.exr"
    slow(monkeypatch, 0.05)
    run("render", scene_file, "-o", out, "--samples", 1000, "--time-limit", 0.3)
    out.unlink()
    code, _, stderr = run("render", scene_file, "-o", out, "--samples", 1000, "--resume", *change)
    assert code == 2
    assert stderr.count("\n") == 1
    assert words in stderr
    assert not out.exists()


def test_resume_refuses_another_scene(run, scene_file, tmp_path, monkeypatch):
    out = tmp_path / "a.exr"
    slow(monkeypatch, 0.05)
    run("render", scene_file, "-o", out, "--samples", 1000, "--time-limit", 0.3)
    changed = fake_native.scene()
    changed.meshes[0].positions[0, 0] = -2
    description_file.save(scene_file, changed)
    code, _, stderr = run("render", scene_file, "-o", out, "--samples", 1000, "--resume")
    assert code == 2
    assert "the scene's content changed" in stderr


def test_resume_of_a_complete_image_renders_nothing(run, scene_file, tmp_path):
    out = tmp_path / "a.exr"
    assert run("render", scene_file, "-o", out)[0] == 0
    before = out.stat().st_mtime_ns
    code, _, stderr = run("render", scene_file, "-o", out, "--resume")
    assert (code, out.stat().st_mtime_ns) == (0, before)
    assert "complete already" in stderr
    assert run("render", scene_file, "-o", out, "--resume", "--seed", 2)[0] == 0
    assert out.stat().st_mtime_ns != before


def test_save_description_alone(run, scene_file, tmp_path):
    copy = tmp_path / "copy.nephele"
    assert (
        run("render", scene_file, "--save-description", copy, "--samples", 9, "--resolution", "32x16")[0] == 0
    )
    scene = description_file.load(copy, tmp_path)
    assert scene.settings["samples"] == 9
    assert (scene.film.width, scene.film.height) == (32, 16)


def test_settings_lists_the_table(run):
    code, stdout, _ = run("settings", "--json")
    assert code == 0
    assert [row["name"] for row in json.loads(stdout)] == [p.name for p in parameters.PARAMETERS]
    assert "sobol | independent" in run("settings")[1]


def test_compare_reports_per_pass(run, tmp_path):
    film = description.Film(20, 10, passes=("Combined", "Depth", "Variance"))
    generator = np.random.default_rng(1)
    a = {
        name: generator.random((10, 20, len(passes.BY_NAME[name].channels)), np.float32)
        for name in film.passes
    }
    b = {name: pixels.copy() for name, pixels in a.items() if name != "Depth"} | {
        "Albedo": a["Combined"][..., :3]
    }
    b["Combined"][..., :3] *= 2
    b["Combined"][3, 4, 0] = np.nan
    exr.write(tmp_path / "a.exr", a, film)
    exr.write(tmp_path / "b.exr", b, film, layer="Other")
    code, stdout, _ = run(
        "compare", tmp_path / "a.exr", tmp_path / "b.exr", "--json", "--metric", "relmse,bias"
    )
    report = json.loads(stdout)
    assert code == 0
    assert list(report["passes"]) == ["Combined", "Combined.A", "Variance"]
    assert report["passes"]["Combined"]["bias"] == pytest.approx(-0.5, abs=1e-6)
    assert report["passes"]["Combined"]["nonfinite_pixels"] == 1
    assert report["passes"]["Combined"]["bias_z"] < -3
    assert report["passes"]["Combined.A"]["relmse"] == 0
    assert report["only_in_image"] == ["Depth"]
    assert report["only_in_reference"] == ["Albedo"]
    table = run("compare", tmp_path / "a.exr", tmp_path / "b.exr")[1]
    assert "relmse_trimmed" in table
    assert "flip" in table


def test_compare_refuses_other_sizes(run, tmp_path):
    for name, width in (("a.exr", 20), ("b.exr", 21)):
        exr.write(
            tmp_path / name, {"Depth": np.ones((10, width, 1), np.float32)}, description.Film(width, 10)
        )
    code, _, stderr = run("compare", tmp_path / "a.exr", tmp_path / "b.exr")
    assert code == 2
    assert "20x10" in stderr
    assert "21x10" in stderr
