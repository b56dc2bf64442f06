# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels of materials, the world and lights: the node trees behind the sockets of their output nodes, and the
few settings beside them that Nephele reads."""

from typing import ClassVar

import bpy
from bpy_extras.node_utils import find_node_input

from .export.nodes import uses_nodes
from .panels import OurPanel


class _NodePanel(OurPanel):
    """Mixin: the tree of nodes behind one socket of the output node. block: "material", "world" or
    "light"."""

    block = ""
    socket = ""
    note = ""

    @classmethod
    def poll(cls, context):
        block = getattr(context, cls.block, None)
        return block is not None and not getattr(block, "grease_pencil", None) and super().poll(context)

    def draw(self, context):
        block = getattr(context, self.block)
        if not uses_nodes(block):
            self.layout.prop(block, "use_nodes")
            return
        if self.note:
            self.layout.label(text=self.note, icon="INFO")
        self.layout.use_property_split = True
        node = block.node_tree.get_output_node("CYCLES")
        found = find_node_input(node, self.socket) if node is not None else None
        if found is None:
            self.layout.label(text="No output node")
        else:
            self.layout.template_node_view(block.node_tree, node, found)


def _node_panel(block, context, socket, label, *, closed=False, note=""):
    """Returns the panel class of one socket."""
    members = {
        "bl_label": label,
        "bl_context": context,
        "bl_options": {"DEFAULT_CLOSED"} if closed else set(),
        "block": block,
        "socket": socket,
        "note": note,
    }
    return type(f"NEPHELE_PT_{block}_{socket.lower()}", (_NodePanel, bpy.types.Panel), members)


class NEPHELE_PT_material_settings(OurPanel, bpy.types.Panel):
    """What shaders may read of a material."""

    bl_label = "Settings"
    bl_context = "material"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.material is not None and not context.material.grease_pencil and super().poll(context)

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.use_property_decorate = False
        self.layout.prop(context.material, "pass_index")


class NEPHELE_PT_world_preview(OurPanel, bpy.types.Panel):
    """Blender's picture of the world, of which it has a panel for its own engines alone."""

    bl_label = "Preview"
    bl_context = "world"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}
    needs = "world"

    def draw(self, context):
        self.layout.template_preview(context.world)


class NEPHELE_PT_light(OurPanel, bpy.types.Panel):
    """Settings of lights that Blender shows for other engines alone."""

    bl_label = "Nephele"
    bl_context = "data"
    bl_parent_id = "DATA_PT_EEVEE_light"
    bl_options: ClassVar[set] = {"HIDE_HEADER"}
    needs = "light"

    def draw(self, context):
        layout, light = self.layout, context.light
        layout.use_property_split = True
        column = layout.column()
        if light.type == "AREA":
            column.prop(light, "spread")
        column.prop(light, "use_shadow", text="Cast Shadow")
        settings = getattr(light, "cycles", None)  # what Cycles adds to lights, and Nephele reads
        if settings is not None:
            column.prop(settings, "max_bounces")
            if light.type == "AREA":
                column.prop(settings, "is_portal", text="Portal")


class NEPHELE_PT_mist(OurPanel, bpy.types.Panel):
    """What the pass Mist is made by."""

    bl_label = "Mist Pass"
    bl_context = "world"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}
    needs = "world"

    def draw(self, context):
        mist, column = context.world.mist_settings, self.layout.column()
        column.use_property_split = True
        for name in ("start", "depth", "falloff"):
            column.prop(mist, name)


class NEPHELE_PT_world_visibility(OurPanel, bpy.types.Panel):
    """Which kinds of rays see the world. The properties are those that Cycles adds to worlds."""

    bl_label = "Ray Visibility"
    bl_context = "world"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return hasattr(context.world, "cycles_visibility") and super().poll(context)

    def draw(self, context):
        visibility, column = context.world.cycles_visibility, self.layout.column()
        column.use_property_split = True
        column.use_property_decorate = False
        for rays in ("camera", "diffuse", "glossy", "transmission", "scatter"):
            column.prop(visibility, rays)


BUMP = "Rendered as bump: the surface itself stays as it is"
CLASSES = (
    NEPHELE_PT_world_preview,
    _node_panel("material", "material", "Surface", "Surface"),
    _node_panel("material", "material", "Volume", "Volume"),
    _node_panel("material", "material", "Displacement", "Displacement", closed=True, note=BUMP),
    NEPHELE_PT_material_settings,
    _node_panel("world", "world", "Surface", "Surface"),
    _node_panel("world", "world", "Volume", "Volume", closed=True),
    NEPHELE_PT_mist,
    NEPHELE_PT_world_visibility,
    NEPHELE_PT_light,
    _node_panel("light", "data", "Surface", "Nodes", closed=True),
)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
