# SPDX-License-Identifier: GPL-3.0-or-later
"""What a new user does: install the zip, choose the engine, turn the default cube into fog, choose the preset
Preview, F12. Writes how long each step took.

Arguments: folder for screenshots, zip, JSON to write.
"""

import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage

PERCENTAGE = 50  # of the 1920x1080 that Blender starts with


def fill_with_fog(item):
    """Does what the material tab's menus do: removes the surface, and chooses Principled Volume."""
    tree = item.active_material.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    fog = tree.nodes.new("ShaderNodeVolumePrincipled")
    tree.links.new(fog.outputs[0], tree.get_output_node("ALL").inputs["Volume"])


def ended():
    """Whether the render is over, for Blender, too."""
    record = common.part("engine").last_render
    return record is not None and record.state != "running" and not bpy.app.is_job_running("RENDER")


def scenario():
    _, package, result = common.arguments()
    times = {}
    begin = time.monotonic()
    with stage.override():
        common.install(package)
    times["install"] = time.monotonic() - begin
    yield 0.5
    bpy.context.scene.render.engine = "NEPHELE"
    bpy.context.scene.render.resolution_percentage = PERCENTAGE
    space = next(area for area in stage.window().screen.areas if area.type == "PROPERTIES").spaces.active
    space.context = "RENDER"
    fill_with_fog(bpy.data.objects["Cube"])
    files = common.part("preset_files")
    with stage.override():
        bpy.ops.script.execute_preset(filepath=str(files.find("preview")), menu_idname="NEPHELE_PT_presets")
    yield 1.0
    begin = time.monotonic()
    with stage.override():
        bpy.ops.render.render("INVOKE_DEFAULT", use_viewport=True)
    yield ended
    record = common.part("engine").last_render
    times["F12"] = time.monotonic() - begin
    assert (record.state, record.warnings) == ("done", []), record
    yield 1.5
    stage.screenshot("first_render")
    times |= {f"of it {part}": seconds for part, seconds in record.seconds.items()}
    times["of it render, processor"] = record.statistics["render_cpu_seconds"]
    Path(result).write_text(json.dumps(times))


stage.play(scenario)
