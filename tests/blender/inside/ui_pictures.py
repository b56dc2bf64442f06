# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the pictures of docs/user: the panels, with what each picture is of opened, and a first render.

The extension is installed already. Arguments: folder for screenshots, .blend of a scene. Beside the
screenshots goes crops.json: name -> (left, top, right, bottom).
"""

import json
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage

crops = {}


def package():
    """Returns the add-on's package."""
    return sys.modules[common.MODULE]


def our_panels():
    return [cls for cls in bpy.types.Panel.__subclasses__() if cls.__name__.startswith("NEPHELE_PT_")]


def open_only(beginnings):
    """Has the panels whose names begin so drawn open, and our others closed, where they were never drawn
    yet."""
    engine, samples = bpy.context.scene.render.engine, bpy.context.scene.nephele.samples
    package().unregister()
    for cls in our_panels():
        if getattr(cls, "bl_options", None) == {"HIDE_HEADER"}:
            continue
        cls.bl_options = set() if cls.__name__.startswith(beginnings) else {"DEFAULT_CLOSED"}
    package().register()
    bpy.context.scene.render.engine, bpy.context.scene.nephele.samples = engine, samples


def new_editor(workspace, tab):
    """Makes the largest area of a workspace that was not shown yet a properties editor. Yields what to wait
    for; returns the area."""
    stage.window().workspace = bpy.data.workspaces[workspace]
    yield 1.5
    area = stage.largest_area()
    area.type = "PROPERTIES"
    yield 1.0
    area.spaces.active.context = tab
    yield 1.5
    return area


def take(name, area, height):
    """Takes the screenshot of the upper part of an area."""
    stage.screenshot(name)
    screen = stage.window().height
    top = screen - area.y - area.height
    crops[name] = (area.x, top, area.x + area.width, min(top + height, top + area.height))


def spoil(scene):
    """Gives a scene something that is not supported."""
    material = next(m for m in bpy.data.materials if m.node_tree and "Principled BSDF" in m.node_tree.nodes)
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeShaderToRGB")
    tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    stage.window().view_layer.use_pass_shadow = True


def scenario():
    folder, blend = common.arguments()
    bpy.context.preferences.view.ui_scale = 1.0
    scene = common.open_scene(blend, 480, 270, 32)
    scene.render.engine = "NEPHELE"
    yield 1.0
    area = yield from new_editor("Layout", "RENDER")
    take("render_tab", area, 1250)
    with stage.override(area=area, region=next(r for r in area.regions if r.type == "WINDOW")):
        bpy.ops.wm.call_panel(name="NEPHELE_PT_presets")
    yield 1.5
    stage.screenshot("presets")
    crops["presets"] = crops["render_tab"]
    stage.press("Escape")
    yield 0.5

    for name, workspace, tab, beginnings, height in (
        ("guiding", "Modeling", "RENDER", "NEPHELE_PT_guiding", 640),
        ("passes", "Sculpting", "VIEW_LAYER", "NEPHELE_PT_passes", 640),
    ):
        open_only(beginnings)
        area = yield from new_editor(workspace, tab)
        take(name, area, height)

    volume = next(o for o in bpy.data.objects if o.type == "VOLUME")
    stage.window().view_layer.objects.active = volume
    area = yield from new_editor("Rendering", "DATA")
    take("volume", area, 960)

    spoil(scene)
    open_only("NEPHELE_PT_issues")
    area = yield from new_editor("Compositing", "RENDER")
    with stage.override():
        bpy.ops.nephele.check_scene()
    area.tag_redraw()
    yield 1.5
    take("issues", area, 640)
    Path(folder, "crops.json").write_text(json.dumps(crops))


stage.play(scenario)
