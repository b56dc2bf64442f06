# SPDX-License-Identifier: GPL-3.0-or-later
"""A session: settings, undo, save, reload, disabling the extension and enabling it again, quitting.

The extension is installed already. Arguments: folder for screenshots, .blend of a scene, .blend to save to.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage


def settings():
    """Returns our settings of the scene; Blender gives new objects after undo and reload."""
    return bpy.context.scene.nephele


def scenario():
    _, blend, copy = common.arguments()
    bpy.ops.wm.open_mainfile(filepath=blend)
    yield 2.0
    bpy.context.scene.render.engine = "NEPHELE"
    with stage.override():
        bpy.ops.ed.undo_push(message="Choose the engine")
        settings().samples = 77
        bpy.ops.ed.undo_push(message="Samples")
        settings().samples = 99
        bpy.ops.ed.undo_push(message="Samples again")
        bpy.ops.ed.undo()
    assert (bpy.context.scene.render.engine, settings().samples) == ("NEPHELE", 77)
    with stage.override():
        bpy.ops.ed.redo()
    assert settings().samples == 99

    bpy.context.view_layer.nephele.use_pass_transmittance = True
    bpy.ops.wm.save_as_mainfile(filepath=copy)
    settings().samples = 1
    bpy.ops.wm.open_mainfile(filepath=copy)
    yield 2.0
    assert (bpy.context.scene.render.engine, settings().samples) == ("NEPHELE", 99)
    assert bpy.context.view_layer.nephele.use_pass_transmittance

    with stage.override():
        bpy.ops.preferences.addon_disable(module=common.MODULE)
    yield 2.0
    stage.screenshot("disabled")
    assert not hasattr(bpy.types.Scene, "nephele")
    with stage.override():
        bpy.ops.preferences.addon_enable(module=common.MODULE)
    yield 2.0
    assert (bpy.context.scene.render.engine, settings().samples) == ("NEPHELE", 99)
    stage.screenshot("enabled_again")


stage.play(scenario)
