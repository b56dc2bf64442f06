# SPDX-License-Identifier: GPL-3.0-or-later
"""Nephele, a render engine for scenes where light meets volumes.

This file only registers: modules in rank order, unregistered in reverse. It never loads the native module, so
that a Blender without it still shows the engine and says what is missing when a render starts.
"""

import importlib

# engine reads properties and uses viewport; panels of ours stand inside of Blender's, vsp_view's in one of
# render_panels; these show presets; Report and Issues show what engine made
RANKS = (
    "properties",
    "viewport_panel",
    "viewport",
    "engine",
    "panels",
    "cycles_settings",
    "preset_menu",
    "render_panels",
    "issue_panel",
    "layer_panels",
    "node_panels",
    "object_panels",
    "camera_panels",
    "vsp_view",
)


def _modules():
    return [importlib.import_module(f".{name}", __package__) for name in RANKS]


def register():
    """Registers everything, or nothing: what was registered is undone where a later module fails."""
    done = []
    try:
        for module in _modules():
            module.register()
            done.append(module)
    except BaseException:
        for module in reversed(done):
            module.unregister()
        raise


def unregister():
    for module in reversed(_modules()):
        module.unregister()
