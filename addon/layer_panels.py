# SPDX-License-Identifier: GPL-3.0-or-later
"""The view layer tab: toggles of the passes, Blender's and ours, in the order of the table."""

from typing import ClassVar

import bpy

from .export.film import toggle_of
from .panels import OurPanel
from .passes import PASSES, RADIANCE

# What is for judging the render, not for making the picture.
OF_SAMPLING = {
    "Variance",
    "Volume Variance",
    "Surface Variance",
    "VSP Target",
    "VSP Achieved",
    "Majorant Optical Depth",
    "Sample Count",
    "Cost",
}


def kind(row):
    """Returns which of KINDS shows a pass: "light", "data" or "sampling"."""
    if row.name in OF_SAMPLING:
        return "sampling"
    return "light" if row.unit == RADIANCE else "data"


KINDS = (  # (kind, label, closed at first)
    ("light", "Light", False),
    ("data", "Data", False),
    ("sampling", "Guiding, Noise and Cost", True),
)


class _PassesPanel(OurPanel):
    """Mixin: the toggles of the passes of one kind."""

    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"
    kind = ""

    def draw(self, context):
        layout, layer = self.layout, context.view_layer
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(heading="Include", align=True)
        drawn = set()
        for row in PASSES:
            if kind(row) != self.kind or row.denoised or row.levels:
                continue
            toggle = toggle_of(layer, row)
            if toggle not in drawn:
                drawn.add(toggle)  # one may ask for several passes
                column.prop(*toggle, text="Denoising Data" if row.cycles in toggle[1:] else row.name)


def _panel(identifier, label, closed):
    members = {"bl_label": label, "bl_options": {"DEFAULT_CLOSED"} if closed else set()}
    return type(
        f"NEPHELE_PT_passes_{identifier}", (_PassesPanel, bpy.types.Panel), members | {"kind": identifier}
    )


class NEPHELE_PT_override(OurPanel, bpy.types.Panel):
    """What the view layer puts in the place of the objects' own."""

    bl_label = "Override"
    bl_context = "view_layer"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.layout.prop(context.view_layer, "material_override")
        if hasattr(context.view_layer, "world_override"):  # Blender has it since 4.4
            self.layout.prop(context.view_layer, "world_override")


FILTERED = (
    ("use_sky", "Environment"),
    ("use_solid", "Surfaces"),
    ("use_strand", "Curves"),
    ("use_volumes", "Volumes"),
)


class NEPHELE_PT_layer_filter(OurPanel, bpy.types.Panel):
    """What of the scene the view layer leaves out: of Blender's choices those that Nephele has."""

    bl_label = "Filter"
    bl_context = "view_layer"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        column = self.layout.column(heading="Include")
        for name, label in FILTERED:
            column.prop(context.view_layer, name, text=label)


CLASSES = (*(_panel(*row) for row in KINDS), NEPHELE_PT_layer_filter, NEPHELE_PT_override)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
