# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of what Nephele reads from objects and volumes. Blender shows those of its own properties that are
among them for Cycles alone."""

from typing import ClassVar

import bpy

from .panels import OurPanel

# Types of objects that are meshes or become one.
SOLID = {"MESH", "CURVE", "FONT", "SURFACE", "META"}
# Kinds of rays, as Blender's properties of objects name them: visible_*.
RAYS = ("camera", "diffuse", "glossy", "transmission", "volume_scatter", "shadow")


class NEPHELE_PT_object(OurPanel, bpy.types.Panel):
    """Settings of an object that can be made of a dielectric."""

    bl_label = "Nephele"
    bl_context = "object"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type in SOLID and super().poll(context)

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.layout.prop(context.object.nephele, "dielectric_priority")


class NEPHELE_PT_ray_visibility(OurPanel, bpy.types.Panel):
    """Which kinds of rays see the object."""

    bl_label = "Ray Visibility"
    bl_context = "object"
    bl_parent_id = "OBJECT_PT_visibility"

    @classmethod
    def poll(cls, context):
        kinds = SOLID | {"VOLUME", "LIGHT", "EMPTY"}
        return context.object is not None and context.object.type in kinds and super().poll(context)

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        column = self.layout.column()
        for rays in RAYS:
            column.prop(context.object, f"visible_{rays}", text=rays.replace("_", " ").title())


class NEPHELE_PT_object_motion_blur(OurPanel, bpy.types.Panel):
    """Whether the object and its shape are blurred. The properties are those that Cycles adds to objects."""

    bl_label = "Motion Blur"
    bl_context = "object"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        kinds = SOLID | {"VOLUME", "EMPTY", "CAMERA"}
        return context.object is not None and context.object.type in kinds and super().poll(context)

    def draw_header(self, context):
        settings = getattr(context.object, "cycles", None)
        self.layout.active = context.scene.render.use_motion_blur
        if settings is not None:
            self.layout.prop(settings, "use_motion_blur", text="")

    def draw(self, context):
        self.layout.use_property_split = True
        settings = getattr(context.object, "cycles", None)
        if settings is None:
            self.layout.label(text="Enable the add-on Cycles, whose settings these are", icon="INFO")
            return
        column = self.layout.column()
        column.active = context.scene.render.use_motion_blur and settings.use_motion_blur
        column.prop(settings, "use_deform_motion", text="Deformation")
        column.prop(settings, "motion_steps", text="Steps")


class NEPHELE_PT_volume(OurPanel, bpy.types.Panel):
    """How a volume's grids are read and move."""

    bl_label = "Nephele"
    bl_context = "data"
    bl_parent_id = "DATA_PT_volume_render"
    bl_options: ClassVar[set] = {"HIDE_HEADER"}
    needs = "volume"

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        volume, column = context.volume, self.layout.column()
        column.prop(volume.render, "clipping")
        column.prop(volume.render, "precision")
        self.layout.label(text="There is no step size: volumes are sampled without bias", icon="INFO")


class NEPHELE_PT_volume_velocity(OurPanel, bpy.types.Panel):
    """What blurs a volume's motion."""

    bl_label = "Velocity"
    bl_context = "data"
    bl_parent_id = "DATA_PT_volume_render"
    needs = "volume"

    def draw(self, context):
        layout, volume = self.layout, context.volume
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column()
        column.active = context.scene.render.use_motion_blur
        for name in ("grid", "unit", "scale"):
            column.prop(volume, f"velocity_{name}", text=name.title())


CLASSES = (
    NEPHELE_PT_object,
    NEPHELE_PT_ray_visibility,
    NEPHELE_PT_object_motion_blur,
    NEPHELE_PT_volume,
    NEPHELE_PT_volume_velocity,
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
