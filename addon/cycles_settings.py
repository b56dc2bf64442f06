# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes over what Cycles and Nephele mean alike, for scenes that were made for Cycles.

Left alone: Cycles' noise threshold (another measure than ours), its clamping (a bias that ours starts
without), its guiding and the steps of its volumes (we have none).
"""

import bpy

from .parameters import BY_NAME

SAME = (  # (our name, Cycles')
    ("samples", "samples"),
    ("viewport_samples", "preview_samples"),
    ("time_limit", "time_limit"),
    ("seed", "seed"),
    ("denoise", "use_denoising"),
    ("max_bounces", "max_bounces"),
    ("volume_bounces", "volume_bounces"),
    ("film_exposure", "film_exposure"),
    ("filter_width", "filter_width"),
)
SURFACES = ("diffuse_bounces", "glossy_bounces", "transmission_bounces")


def of_cycles(cycles):
    """Returns our settings that stand for those of Cycles. cycles: object with Cycles' as attributes."""
    found = {
        ours: getattr(cycles, theirs) for ours, theirs in SAME if ours in BY_NAME and hasattr(cycles, theirs)
    }
    found["surface_bounces"] = max(getattr(cycles, name) for name in SURFACES)
    found["pixel_filter"] = cycles.pixel_filter_type.lower()
    return {name: _within(BY_NAME[name], value) for name, value in found.items()}


def _within(parameter, value):
    if parameter.kind in ("int", "float"):
        value = min(max(value, parameter.minimum), parameter.maximum)
    return parameter.checked(value)


class NEPHELE_OT_copy_cycles_settings(bpy.types.Operator):
    """Take over Cycles' samples, time limit, seed, bounces, exposure and pixel filter"""

    bl_idname = "nephele.copy_cycles_settings"
    bl_label = "Copy Settings from Cycles"
    bl_options = {"REGISTER", "UNDO"}  # noqa: RUF012  as Blender has it

    @classmethod
    def poll(cls, context):
        if not hasattr(context.scene, "cycles"):
            cls.poll_message_set("Cycles is not enabled")
            return False
        return True

    def execute(self, context):
        settings = context.scene.nephele
        changed = 0
        for name, value in of_cycles(context.scene.cycles).items():
            changed += getattr(settings, name) != value
            setattr(settings, name, value)
        self.report({"INFO"}, f"{changed} settings changed")
        return {"FINISHED"}


CLASSES = (NEPHELE_OT_copy_cycles_settings,)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
