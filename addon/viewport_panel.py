# SPDX-License-Identifier: GPL-3.0-or-later
"""What the 3D view's shading popover offers for Nephele: which pass is shown, and whether it is denoised."""

import bpy

from . import viewport_picture

ITEMS = [
    (name.upper().replace(" - ", "_MINUS_").replace(" ", "_"), name, viewport_picture.doc(name), number)
    for number, name in enumerate(viewport_picture.CHOICES)
]
NAMES = {identifier: name for identifier, name, *_ in ITEMS}


class NepheleShadingSettings(bpy.types.PropertyGroup):
    """Settings of one 3D view."""

    render_pass: bpy.props.EnumProperty(
        name="Pass", description="What the rendered view shows", items=ITEMS, default="COMBINED"
    )
    denoise: bpy.props.BoolProperty(
        name="Denoise",
        description="Take the noise out of what the rendered view shows of Combined",
        default=False,
    )

    def shown_pass(self):
        """Returns the name of the pass or map that is shown."""
        return NAMES[self.render_pass]


class NEPHELE_VIEW3D_PT_shading(bpy.types.Panel):
    """The pass and the denoiser of the rendered view."""

    bl_space_type = "VIEW_3D"
    bl_region_type = "HEADER"
    bl_label = "Render Pass"
    bl_parent_id = "VIEW3D_PT_shading"

    @classmethod
    def poll(cls, context):
        return context.engine == "NEPHELE" and context.space_data.shading.type == "RENDERED"

    def draw(self, context):
        shading = context.space_data.shading.nephele
        self.layout.prop(shading, "render_pass", text="")
        row = self.layout.row()
        row.active = viewport_picture.denoiser() is not None and shading.shown_pass() == "Combined"
        row.prop(shading, "denoise")


CLASSES = (NepheleShadingSettings, NEPHELE_VIEW3D_PT_shading)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.View3DShading.nephele = bpy.props.PointerProperty(type=NepheleShadingSettings)


def unregister():
    del bpy.types.View3DShading.nephele
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
