# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: the bundled files, Blender's menu of them, and the command line."""

import json
from pathlib import Path

import fake_native
import pytest
from nephele import description_file, parameters, preset_files
from nephele.errors import InputError


def settings_of(bpy):
    """Returns the values of what presets govern."""
    return {p.name: getattr(bpy.context.scene.nephele, p.name) for p in preset_files.governed()}


def run_preset(bpy, path):
    """Does what choosing a preset in the menu does."""
    assert bpy.ops.script.execute_preset(filepath=str(path), menu_idname="NEPHELE_PT_presets") == {"FINISHED"}


@pytest.fixture
def user_folder(bpy, tmp_path, monkeypatch):
    """Returns the folder in which the user's own presets are."""
    folder = tmp_path / "presets" / preset_files.SUBFOLDER

    def user_resource(kind, *, path="", create=False):
        assert kind == "SCRIPTS"
        (tmp_path / path).mkdir(parents=True, exist_ok=True)
        return str(tmp_path / path)

    paths = bpy.utils.preset_paths
    monkeypatch.setattr(bpy.utils, "user_resource", user_resource)
    monkeypatch.setattr(bpy.utils, "preset_paths", lambda subdir: [str(folder), *paths(subdir)])
    return folder


@pytest.mark.parametrize("name", preset_files.NAMES)
def test_bundled_presets_are_sound(name):
    path = preset_files.find(name.upper())
    governed = {p.name for p in preset_files.governed()}
    assert set(preset_files.stated(path)) <= governed == set(preset_files.values(path))
    assert preset_files.about(path).endswith(".")


def test_no_other_preset_is_bundled():
    assert {path.stem for path in preset_files.BUNDLED.glob("*")} - {"__pycache__"} == set(preset_files.NAMES)


@pytest.mark.parametrize("name", preset_files.NAMES)
def test_menu_sets_what_the_command_line_sets(bpy, name):
    settings = bpy.context.scene.nephele
    settings.seed, settings.film_exposure, settings.vsp_criterion = 7, 2.0, "contribution"
    run_preset(bpy, preset_files.find(name))
    wanted = preset_files.values(preset_files.find(name))
    assert settings_of(bpy) == {k: v if isinstance(v, str) else pytest.approx(v) for k, v in wanted.items()}
    assert (settings.seed, settings.film_exposure) == (7, 2.0)


def test_menu_lists_the_bundled_presets(bpy):
    folders = map(Path, bpy.utils.preset_paths(preset_files.SUBFOLDER))
    assert any(folder.samefile(preset_files.BUNDLED) for folder in folders)


def test_own_preset_is_saved_chosen_and_removed(bpy, user_folder):
    settings = bpy.context.scene.nephele
    settings.samples, settings.target_error, settings.transmittance = 33, 0.25, "residual_ratio"
    saved = settings_of(bpy)
    assert bpy.ops.nephele.preset_add(name="Mine") == {"FINISHED"}
    path = user_folder / "Mine.py"
    assert preset_files.values(path) == saved
    run_preset(bpy, preset_files.find("reference"))
    assert settings_of(bpy) != saved
    run_preset(bpy, path)
    assert settings_of(bpy) == saved
    assert bpy.ops.nephele.preset_add(name="Mine", remove_name=True) == {"FINISHED"}
    assert not path.exists()


def test_bundled_preset_is_not_removed(bpy):
    bpy.ops.nephele.preset_add(name="Final", remove_name=True)
    assert preset_files.find("final").is_file()


def overrides(run, scene_file, tmp_path, *arguments):
    """Returns the settings of a render by the command line."""
    stats = tmp_path / "stats.json"
    code, _, stderr = run("render", scene_file, "-o", tmp_path / "a.exr", "--stats", stats, *arguments)
    assert code == 0, stderr
    return json.loads(stats.read_text())["settings"]


def test_command_line_takes_a_preset(run, scene_file, tmp_path):
    preset = tmp_path / "mine.py"
    preset.write_text("import bpy\nnephele = bpy.context.scene.nephele\n\nnephele.samples = 5\n")
    settings = overrides(run, scene_file, tmp_path, "--preset", preset, "--set", "clamp=3")
    assert settings == parameters.defaults() | {"samples": 5, "clamp": 3.0}


def test_options_come_before_the_preset_and_that_before_the_scene(run, tmp_path):
    scene = tmp_path / "scene.nephele"
    made = fake_native.scene()
    made.settings.update(seed=5, max_bounces=3)
    description_file.save(scene, made)
    settings = overrides(run, scene, tmp_path, "--preset", "preview", "--samples", 2)
    assert (settings["samples"], settings["seed"], settings["max_bounces"]) == (2, 5, 64)


def test_unknown_preset_is_refused(run, scene_file, tmp_path):
    code, _, stderr = run("render", scene_file, "-o", tmp_path / "a.exr", "--preset", "best")
    assert code == 2
    assert "'best'" in stderr
    assert "reference" in stderr


@pytest.mark.parametrize("line", ["nephele.samples = many", "nephele.none = 1", "nephele.samples = 0", "a b"])
def test_damaged_preset_is_refused(tmp_path, line):
    path = tmp_path / "bad.py"
    path.write_text(line)
    with pytest.raises(InputError, match=r"bad\.py: is no preset"):
        preset_files.values(path)


def test_settings_lists_presets(run):
    told = json.loads(run("settings", "--presets", "--json")[1])
    assert [entry["name"] for entry in told] == [name.lower() for name in preset_files.NAMES]
    text = run("settings")[1]
    assert all(f"\n{entry['name']} " in text for entry in told)
