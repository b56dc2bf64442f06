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


def activate(kind):
    """Makes the first object of a type the active one."""
    found = next(item for item in bpy.context.scene.objects if item.type == kind)
    stage.window().view_layer.objects.active = found
    found.select_set(True)


def variants(area):
    """Looks at the data of lights of each type, and of panoramic cameras of each: their panels differ."""
    activate("LIGHT")
    yield 0.5
    area.spaces.active.context = "DATA"
    for kind in ("POINT", "SPOT", "AREA"):
        bpy.context.object.data.type = kind
        yield 1.0
        stage.screenshot(f"light_{kind.lower()}")
    activate("CAMERA")
    yield 0.5
    camera = bpy.context.object.data
    camera.type = "PANO"
    values = camera if hasattr(camera, "panorama_type") else camera.cycles
    for item in values.bl_rna.properties["panorama_type"].enum_items:
        values.panorama_type = item.identifier
        yield 1.0
        stage.screenshot(f"panorama_{item.identifier.lower()}")


def scenario():
    """Looks at the preferences after the installation, then at the tabs: as they open at first, and searched
    for a letter that every label has, which opens and draws every panel there is."""
    _, package, blend = common.arguments()
    with stage.override():
        common.install(package)
    bpy.context.window_manager.addon_search = "Nephele"
    bpy.context.preferences.active_section = "ADDONS"
    stage.largest_area().type = "PREFERENCES"
    yield 2.0
    stage.screenshot("installed")
    bpy.ops.wm.open_mainfile(filepath=blend)
    yield 2.0
    bpy.context.scene.render.engine = "NEPHELE"
    stage.screenshot("scene")
    area = stage.largest_area()
    area.type = "PROPERTIES"
    yield 1.0
    for search in ("", "e"):
        area.spaces.active.search_filter = search
        for tab, kind in TABS:
            if kind:
                activate(kind)
                yield 0.5  # the tabs follow the active object
            area.spaces.active.context = tab
            yield 1.5
            stage.screenshot(
                f"tab_{tab.lower()}{'_' + kind.lower() if kind else ''}{'_searched' if search else ''}"
            )
    yield from variants(area)
    bpy.ops.wm.save_userpref()


stage.play(scenario)
