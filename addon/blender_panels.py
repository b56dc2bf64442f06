# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of the render tab for settings that are Blender's own, or that Cycles adds. render_panels.py says
where they stand among ours."""

from typing import ClassVar

import bpy

from .panels import OurPanel

SHUTTER_SHAPES = (  # of Blender's operator, with the beginning of its icon's name
    ("SMOOTH", "SMOOTH"),
    ("ROUND", "SPHERE"),
    ("ROOT", "ROOT"),
    ("SHARP", "SHARP"),
    ("LINE", "LIN"),
    ("MAX", "NO"),
)


class NEPHELE_PT_motion_blur(OurPanel, bpy.types.Panel):
    """Blender's settings of the shutter."""

    bl_label = "Motion Blur"
    bl_context = "render"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.use_property_split = True
        layout.active = render.use_motion_blur
        layout.prop(render, "motion_blur_position", text="Position")
        layout.prop(render, "motion_blur_shutter")


class NEPHELE_PT_shutter_curve(OurPanel, bpy.types.Panel):
    """How far the shutter is open, from its beginning to its end; with Blender's shapes to choose from."""

    bl_label = "Shutter Curve"
    bl_context = "render"
    bl_parent_id = "NEPHELE_PT_motion_blur"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.active = render.use_motion_blur
        layout.template_curve_mapping(render, "motion_blur_shutter_curve")
        row = layout.row(align=True)
        for shape, icon in SHUTTER_SHAPES:
            row.operator("render.shutter_curve_preset", icon=f"{icon}CURVE", text="").shape = shape


class NEPHELE_PT_curves(OurPanel, bpy.types.Panel):
    """How hair is divided. The properties are those that Cycles adds to scenes."""

    bl_label = "Curves"
    bl_context = "render"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return hasattr(context.scene, "cycles_curves") and super().poll(context)

    def draw(self, context):
        layout, settings = self.layout, context.scene.cycles_curves
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "shape")
        layout.prop(settings, "subdivisions", text="Curve Subdivisions")


class NEPHELE_PT_compositor(OurPanel, bpy.types.Panel):
    """Blender's settings of what the compositor runs on."""

    bl_label = "Compositor"
    bl_context = "render"
    bl_parent_id = "NEPHELE_PT_performance"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(render, "compositor_device", text="Device")
        layout.prop(render, "compositor_precision", text="Precision")


class NEPHELE_PT_simplify(OurPanel, bpy.types.Panel):
    """Blender's simplification, for final renders and for the 3D view."""

    bl_label = "Simplify"
    bl_context = "render"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_simplify", text="")

    def draw(self, context):
        layout, render = self.layout, context.scene.render
        layout.use_property_split = True
        layout.active = render.use_simplify
        column = layout.column(heading="Render", align=True)
        column.prop(render, "simplify_subdivision_render", text="Max Subdivision")
        column.prop(render, "simplify_child_particles_render", text="Child Particles")
        column = layout.column(heading="Viewport", align=True)
        column.prop(render, "simplify_subdivision", text="Max Subdivision")
        column.prop(render, "simplify_child_particles", text="Child Particles")
        column.prop(render, "simplify_volumes", text="Volume Resolution")
