# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the extension in Blender's window, chooses the engine, opens every tab of the properties.

Arguments: folder for screenshots, zip, .blend of a scene with volume, light, camera and meshes.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage

# Tab -> type of the object that is active while it is looked at.
TABS = (
    ("RENDER", None),
    ("OUTPUT", None),
    ("VIEW_LAYER", None),
    ("SCENE", None),
    ("WORLD", None),
    ("OBJECT", "MESH"),
    ("MATERIAL", "MESH"),
    ("MATERIAL", "VOLUME"),
    ("DATA", "VOLUME"),
    ("DATA", "LIGHT"),
    ("DATA", "CAMERA"),
    ("DATA", "MESH"),
)


def open_all_panels():
    """Makes our panels that are closed at first open: Blender offers scripts no other way."""
    for cls in reversed(common.part("panels").CLASSES):
        bpy.utils.unregister_class(cls)
    for cls in common.part("panels").CLASSES:
        cls.bl_options = set(getattr(cls, "bl_options", ())) - {"DEFAULT_CLOSED"}
        bpy.utils.register_class(cls)


def activate(kind):
    """Makes the first object of a type the active one."""
    found = next(item for item in bpy.context.scene.objects if item.type == kind)
    stage.window().view_layer.objects.active = found
    found.select_set(True)


def scenario():
    """Looks at the preferences after the installation, then at the tabs, with the panels closed and open."""
    _, package, blend = common.arguments()
    with stage.override():
        common.install(package)
        bpy.ops.screen.userpref_show(section="ADDONS")
    bpy.context.window_manager.addon_search = "Nephele"
    yield 2.0
    stage.screenshot("installed")
    preferences = next(w for w in bpy.context.window_manager.windows if w != stage.window())
    with bpy.context.temp_override(window=preferences):
        bpy.ops.wm.window_close()
    bpy.ops.wm.open_mainfile(filepath=blend)
    yield 2.0
    bpy.context.scene.render.engine = "NEPHELE"
    stage.screenshot("scene")
    area = stage.largest_area()
    area.type = "PROPERTIES"
    yield 1.0
    for state in ("", "_open"):
        if state:
            open_all_panels()
        for tab, kind in TABS:
            if kind:
                activate(kind)
                yield 0.5  # the tabs follow the active object
            area.spaces.active.context = tab
            yield 1.5
            stage.screenshot(f"tab_{tab.lower()}{'_' + kind.lower() if kind else ''}{state}")
    bpy.ops.wm.save_userpref()


stage.play(scenario)
