# SPDX-License-Identifier: GPL-3.0-or-later
"""Panels: render settings by parameter group, passes, shader nodes; and Blender's own panels that serve us
too."""

from typing import ClassVar

import bpy
from bpy_extras.node_utils import find_node_input

from . import engine
from .export.film import toggle_of
from .export.nodes import uses_nodes
from .parameters import PARAMETERS
from .passes import PASSES

ENGINE = "NEPHELE"

GROUPS = (  # (group of parameters, label, closed at first), in the order shown
    ("sampling", "Sampling", False),
    ("paths", "Light Paths", False),
    ("volumes", "Volumes", False),
    ("guiding", "Guiding", False),
    ("film", "Film", False),
    ("performance", "Performance", True),
    ("advanced", "Advanced", True),
)

# Blender's properties shown beside ours: group -> names in Scene.render.
BLENDER_PROPERTIES = {
    "film": ("film_transparent",),
    "performance": ("threads_mode", "threads", "use_persistent_data"),
}

# Ours that Blender's stand for in its panels: the command line's --threads comes before Blender's setting.
COMMAND_LINE_ONLY = {"threads"}

# Panels for every engine that would promise what we do not have, or that ours replace.
EXCLUDED = {
    "DATA_PT_light",
    "DATA_PT_preview",
    "MATERIAL_PT_preview",
    "RENDER_PT_stereoscopy",
    "VIEWLAYER_PT_filter",
}
# Panels that Blender gives to its own engines only, and that serve us as they are.
ADOPTED = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "EEVEE_WORLD_PT_mist",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_layer_passes_cryptomatte",
}


class OurPanel:
    """Mixin: a panel of the properties editor, shown when Nephele renders."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = frozenset({ENGINE})

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class _GroupPanel(OurPanel):
    """Mixin: the parameters of one group."""

    bl_context = "render"
    group = ""

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for parameter in PARAMETERS:
            if parameter.group == self.group and parameter.name not in COMMAND_LINE_ONLY:
                layout.prop(context.scene.nephele, parameter.name)
        render = context.scene.render
        for name in BLENDER_PROPERTIES.get(self.group, ()):
            row = layout.row()
            row.enabled = name != "threads" or render.threads_mode == "FIXED"
            row.prop(render, name)


def _group_panel(group, label, closed):
    """Returns the panel class of a parameter group."""
    members = {"bl_label": label, "bl_options": {"DEFAULT_CLOSED"} if closed else set(), "group": group}
    return type(f"NEPHELE_PT_{group}", (_GroupPanel, bpy.types.Panel), members)


class NEPHELE_PT_report(OurPanel, bpy.types.Panel):
    """What the last render took, and how its error fell, where it was estimated."""

    bl_label = "Report"
    bl_context = "render"
    bl_options: ClassVar[set] = {"DEFAULT_CLOSED"}

    def draw(self, context):
        column = self.layout.column(align=True)
        for line in report_lines(engine.last_render):
            column.label(text=line)


def report_lines(record):
    """Returns the Report panel's lines for an engine.RenderRecord or None."""
    if record is None:
        return ["Nothing was rendered yet"]
    told = record.statistics
    lines = [f"Frame {record.frame}, {record.view_layer}: {record.state}"]
    lines += [f"{stage.capitalize()}: {seconds:.2f} s" for stage, seconds in record.seconds.items()]
    if "samples_done" in told:
        lines.append(f"Samples: {told['samples_done']}")
    marks = told.get("errors", ())
    for number, mark in enumerate(marks):
        if mark["samples"].bit_count() == 1 or number == len(marks) - 1:  # powers of two, and the last
            time = engine.clock(mark["seconds"])
            lines.append(f"Error after {mark['samples']} samples, {time}: {mark['error']:.3g}")
    if told.get("target_reached"):
        lines.append("The target error is reached")
    elif told and not marks:
        lines.append("Error: not estimated (Sampling, Estimate Error)")
    return lines


class NEPHELE_PT_passes(OurPanel, bpy.types.Panel):
    """Toggles of the passes, Blender's and ours, in the order of the table."""

    bl_label = "Nephele"
    bl_context = "view_layer"
    bl_parent_id = "VIEWLAYER_PT_layer_passes"
    bl_options: ClassVar[set] = {"HIDE_HEADER"}

    def draw(self, context):
        layout, layer = self.layout, context.view_layer
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(heading="Include", align=True)
        drawn = set()
        for row in PASSES:
            if row.denoised or row.levels or (toggle := toggle_of(layer, row)) in drawn:
                continue
            drawn.add(toggle)  # one may ask for several passes
            column.prop(*toggle, text="Denoising Data" if row.cycles in toggle[1:] else row.name)


class _NodePanel(OurPanel):
    """Mixin: the tree of nodes behind one socket of the output node. block: "material", "world" or
    "light"."""

    block = ""
    socket = ""

    @classmethod
    def poll(cls, context):
        return getattr(context, cls.block, None) is not None and super().poll(context)

    def draw(self, context):
        block = getattr(context, self.block)
        if not uses_nodes(block):
            self.layout.prop(block, "use_nodes")
            return
        self.layout.use_property_split = True
        node = block.node_tree.get_output_node("CYCLES")
        found = find_node_input(node, self.socket) if node is not None else None
        if found is None:
            self.layout.label(text="No output node")
        else:
            self.layout.template_node_view(block.node_tree, node, found)


def _node_panel(block, context, socket, label, closed=False):
    """Returns the panel class of one socket."""
    members = {
        "bl_label": label,
        "bl_context": context,
        "bl_options": {"DEFAULT_CLOSED"} if closed else set(),
        "block": block,
        "socket": socket,
    }
    return type(f"NEPHELE_PT_{block}_{socket.lower()}", (_NodePanel, bpy.types.Panel), members)


CLASSES = (
    *(_group_panel(*row) for row in GROUPS),
    NEPHELE_PT_report,
    NEPHELE_PT_passes,
    _node_panel("material", "material", "Surface", "Surface"),
    _node_panel("material", "material", "Volume", "Volume"),
    _node_panel("world", "world", "Surface", "Surface"),
    _node_panel("world", "world", "Volume", "Volume", closed=True),
    _node_panel("light", "data", "Surface", "Nodes", closed=True),
)


def compatible_panels():
    """Yields the panels of Blender that serve us: those for every engine but EXCLUDED, and ADOPTED."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", ())
        for_all = (
            "BLENDER_RENDER" in engines
            # The shader editor's copy of a panel shares its set of engines with the original.
            and panel.__name__.removeprefix("NODE_") not in EXCLUDED
            and "freestyle" not in panel.__name__
        )
        if for_all or panel.__name__ in ADOPTED:
            yield panel


def register():
    for panel in compatible_panels():
        panel.COMPAT_ENGINES.add(ENGINE)
    for cls in CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
    for panel in bpy.types.Panel.__subclasses__():
        if not issubclass(panel, OurPanel) and hasattr(panel, "COMPAT_ENGINES"):
            panel.COMPAT_ENGINES.discard(ENGINE)
