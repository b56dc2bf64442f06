# SPDX-License-Identifier: GPL-3.0-or-later
"""The menu of presets in the header of the Sampling panel, as other engines have it: the bundled ones and the
user's own, which it saves and removes."""

from pathlib import Path

import bpy
from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from . import preset_files
from .cycles_settings import NEPHELE_OT_copy_cycles_settings


class NEPHELE_OT_preset_add(AddPresetBase, bpy.types.Operator):
    """Save the settings as a preset, or remove one"""

    bl_idname = "nephele.preset_add"
    bl_label = "Add Render Preset"
    preset_menu = "NEPHELE_PT_presets"
    preset_subdir = preset_files.SUBFOLDER
    # In full: Blender 4.3 does not see names of preset_defines under Python 3.13.
    preset_values = tuple(f"bpy.context.scene.nephele.{p.name}" for p in preset_files.governed())

    def remove(self, context, filepath):
        if Path(filepath).is_relative_to(preset_files.BUNDLED):
            self.report({"WARNING"}, "presets that come with Nephele cannot be removed")
        else:
            Path(filepath).unlink()


class NEPHELE_PT_presets(PresetPanel, bpy.types.Panel):
    """The menu."""

    bl_label = "Render Presets"
    preset_subdir = preset_files.SUBFOLDER
    preset_operator = "script.execute_preset"
    preset_add_operator = NEPHELE_OT_preset_add.bl_idname

    @staticmethod
    def reset_cb(context, _filepath):
        """Before a preset is run: what it does not name gets its default."""
        for parameter in preset_files.governed():
            setattr(context.scene.nephele, parameter.name, parameter.default)

    @staticmethod
    def post_cb(context, _filepath):
        """After a preset was run: views that render learn of it, as they do not of an add-on's properties."""
        context.scene.update_tag()

    def draw(self, context):
        super().draw(context)
        self.layout.separator()
        self.layout.operator(NEPHELE_OT_copy_cycles_settings.bl_idname)


CLASSES = (NEPHELE_OT_preset_add, NEPHELE_PT_presets)


def register():
    bpy.utils.register_preset_path(str(Path(__file__).parent))
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    bpy.utils.unregister_preset_path(str(Path(__file__).parent))
