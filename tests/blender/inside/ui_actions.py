# SPDX-License-Identifier: GPL-3.0-or-later
"""Rounds of what users do: settings, presets, tabs, engines, undo, F12 and Escape, save and reload. Writes
what each round left of memory.

The extension is installed already. Arguments: folder for screenshots, .blend of a scene, .blend to save to,
JSON to write, rounds; then, to find what takes memory, the only PARTS to play.
"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage

SIZE = (96, 54)
TABS = ("RENDER", "OUTPUT", "VIEW_LAYER", "SCENE", "WORLD", "OBJECT", "DATA")
done = []  # names of the actions so far


def engine():
    """Returns the add-on's module engine."""
    return common.part("engine")


def settings():
    """Returns our settings of the scene; Blender gives new objects after undo and reload."""
    return bpy.context.scene.nephele


def act(name, function, *arguments, wait=0.3):
    """Does one thing as a user would, and waits for Blender to draw; a step of stage.play()."""
    with stage.override():
        function(*arguments)
        bpy.ops.ed.undo_push(message=name)
    done.append(name)
    yield wait


def ended():
    """Whether the last render is over, for Blender, too."""
    record = engine().last_render
    over = record is not None and record.state != "running"
    return over and not bpy.app.is_job_running("RENDER")


def prepare(blend):
    """Opens the scene for small pictures of ours, with a node that is not supported."""
    scene = common.open_scene(blend, *SIZE, 2)
    scene.render.engine = "NEPHELE"
    tree = next(
        m for m in bpy.data.materials if m.node_tree and "Principled BSDF" in m.node_tree.nodes
    ).node_tree
    node = tree.nodes.new("ShaderNodeShaderToRGB")
    tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])


def properties_editor():
    """Returns the properties editor's space."""
    return next(area for area in stage.window().screen.areas if area.type == "PROPERTIES").spaces.active


def turn_to(tab, search):
    space = properties_editor()
    space.context, space.search_filter = tab, search


def activate(item):
    bpy.context.view_layer.objects.active = item


def tabs():
    """Looks at every tab for a mesh, a volume, lights and the camera; the search opens every panel."""
    for kind in ("MESH", "VOLUME", "LIGHT", "CAMERA"):
        yield from act(f"choose {kind}", activate, next(o for o in bpy.data.objects if o.type == kind))
        for tab in TABS if kind == "MESH" else ("OBJECT", "DATA"):
            yield from act(f"{kind}: {tab}", turn_to, tab, "e")
    yield from act("render tab", turn_to, "RENDER", "")


def run_preset(path):
    bpy.ops.script.execute_preset(filepath=str(path), menu_idname="NEPHELE_PT_presets")


def presets():
    """Chooses each bundled preset; saves one, chooses and removes it."""
    files = common.part("preset_files")
    for name in files.NAMES:
        yield from act(f"preset {name}", run_preset, files.find(name))
        assert settings().samples == files.values(files.find(name))["samples"]
    settings().samples = 21
    yield from act("save preset", lambda: bpy.ops.nephele.preset_add(name="Mine"))
    settings().samples = 4
    path = bpy.utils.preset_find("Mine", files.SUBFOLDER)
    yield from act("own preset", run_preset, path)
    assert settings().samples == 21
    yield from act("remove preset", lambda: bpy.ops.nephele.preset_add(name="Mine", remove_name=True))
    assert not Path(path).exists()


def undo():
    """Changes a setting, undoes and redoes it."""
    for value in (5, 6):
        yield from act(f"samples {value}", setattr, settings(), "samples", value)
    with stage.override():
        bpy.ops.ed.undo()
    done.append("undo")
    yield 0.3
    assert settings().samples == 5
    with stage.override():
        bpy.ops.ed.redo()
    done.append("redo")
    yield 0.3
    assert settings().samples == 6


def engines():
    """Switches engines and takes over Cycles' settings."""
    for name in ("CYCLES", "BLENDER_WORKBENCH", "NEPHELE"):
        yield from act(f"engine {name}", setattr, bpy.context.scene.render, "engine", name, wait=0.6)
    yield from act("copy from Cycles", lambda: bpy.ops.nephele.copy_cycles_settings())
    assert settings().samples == 1


def issues():
    """Checks the scene and goes to what was found."""
    yield from act("check", lambda: bpy.ops.nephele.check_scene(), wait=0.6)
    (warning,) = [w for w in common.part("issue_panel").findings.warnings if "Shader to RGB" in w]
    found = common.part("issues").issue(warning)
    named = {"kind": found.kind, "name": found.name, "node": found.node}
    yield from act("go to issue", lambda: bpy.ops.nephele.go_to_issue(**named))
    assert bpy.context.object.active_material.name == found.name


def renders():
    """F12 to the end; a long one that Escape ends; a map of the first."""
    settings().samples = 2
    bpy.context.view_layer.nephele.use_pass_vsp_achieved = True
    for name, samples, state in (("F12", 2, "done"), ("F12 and Escape", 1_000_000, "cancelled")):
        settings().samples, engine().last_render = samples, None
        with stage.override():
            bpy.ops.render.render("INVOKE_DEFAULT", use_viewport=True)
        if state == "cancelled":
            yield lambda: getattr(engine().last_render, "state", "") == "running"
            yield 2.0
            stage.press("Escape")
        yield ended
        assert engine().last_render.state == state, engine().last_render
        done.append(name)
    yield from act("map", lambda: bpy.ops.nephele.vsp_view(map="VSP Achieved"))
    bpy.context.view_layer.nephele.use_pass_vsp_achieved = False


def save_and_reload(copy):
    settings().samples = 44
    bpy.ops.wm.save_as_mainfile(filepath=copy)
    done.append("save")
    settings().samples = 1
    bpy.ops.wm.open_mainfile(filepath=copy)
    yield 1.0
    done.append("reload")
    assert (bpy.context.scene.render.engine, settings().samples) == ("NEPHELE", 44)


def resident_megabytes():
    """Returns the memory that this process holds."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("VmRSS")) / 1024


PARTS = ("tabs", "presets", "undo", "engines", "issues", "renders")


def scenario():
    _, blend, copy, result, rounds, *parts = common.arguments()
    prepare(blend)
    yield 1.0
    memory = []
    for number in range(int(rounds)):
        for part in parts or PARTS:
            yield from globals()[part]()
        if not parts:
            yield from save_and_reload(copy)
        if number == 0:
            stage.screenshot("actions")
        memory.append(resident_megabytes())
        print(f"round {number}: {len(done)} actions, {memory[-1]:.1f} MiB", flush=True)
    Path(result).write_text(json.dumps({"actions": done, "memory": memory}))


stage.play(scenario)
