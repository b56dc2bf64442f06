# SPDX-License-Identifier: GPL-3.0-or-later
"""The Issues panel: what the scene uses that Nephele approximates or leaves out, each with a button that goes
to it.

The list is that of the last render, or of the button Check, which exports the scene as the viewport has it:
the exporter alone knows what it does with a scene, and a second opinion would not stay the same. An export
reads every mesh and image, so drawing the panel, or a change of the scene, never starts one.
"""

import functools
import textwrap
from dataclasses import dataclass
from typing import ClassVar

import bpy

from . import engine
from .export import export_scene
from .issues import OBJECT_KINDS, by_owner
from .panels import OurPanel

ICONS = {
    "object": "OBJECT_DATA",
    "volume": "VOLUME_DATA",
    "fluid domain": "MOD_FLUIDSIM",
    "camera": "CAMERA_DATA",
    "light": "LIGHT_DATA",
    "material": "MATERIAL_DATA",
    "world": "WORLD_DATA",
    "view layer": "RENDERLAYERS",
    "scene": "SCENE_DATA",
}
TABS = {"material": "MATERIAL", "world": "WORLD", "view layer": "VIEW_LAYER", "scene": "RENDER"}
LETTER, MARGIN = 7.0, 70.0  # pixels of an unscaled interface: a letter's mean width, and what frames the text


@dataclass
class Findings:
    """What the panel shows. origin: where it is from, "" where nothing was asked yet. fault: why there is
    no picture at all."""

    origin: str = ""
    warnings: tuple = ()
    fault: str = ""


findings = Findings()
_of_layers = {}  # name of a view layer -> warnings of its last render: a picture may take several


def _rendered(record):
    """Takes over what a render found, as its engine tells."""
    global findings
    _of_layers[record.view_layer] = tuple(record.warnings)
    warnings = dict.fromkeys(text for found in _of_layers.values() for text in found)
    fault = record.message if record.state == "failed" else ""
    findings = Findings(f"Last render, frame {record.frame}", tuple(warnings), fault)


@bpy.app.handlers.persistent
def _forget(*_):
    """Another file was opened: what was found is not of it."""
    global findings
    findings = Findings()
    _of_layers.clear()


class NEPHELE_OT_check_scene(bpy.types.Operator):
    """Look for what is approximated or left out, without a render. Reads all meshes and images"""

    bl_idname = "nephele.check_scene"
    bl_label = "Check Scene"

    def execute(self, context):
        global findings
        try:
            scene = export_scene(context.evaluated_depsgraph_get(), motion=False)
            findings = Findings("Scene as the viewport has it", scene.warnings)
        except engine.USER_FAULTS as fault:
            findings = Findings("Scene as the viewport has it", (), str(fault))
        count = len(findings.warnings) + bool(findings.fault)
        self.report({"INFO"}, f"{count} issues" if count != 1 else "1 issue")
        return {"FINISHED"}


class NEPHELE_OT_go_to_issue(bpy.types.Operator):
    """Go to what this is about: select the object, or open the material, world or view layer"""

    bl_idname = "nephele.go_to_issue"
    bl_label = "Go to Issue"
    bl_options: ClassVar[set] = {"REGISTER", "UNDO", "INTERNAL"}

    kind: bpy.props.StringProperty()
    name: bpy.props.StringProperty()
    node: bpy.props.StringProperty()

    def execute(self, context):
        found = _find(context, self.kind, self.name)
        if found is None:
            self.report({"WARNING"}, f"{self.kind} '{self.name}' is not in this view layer")
            return {"CANCELLED"}
        tab = _activate(context, self.kind, found)
        if self.node:
            _activate_node(found, self.node)
        if tab and context.area is not None and context.area.type == "PROPERTIES":
            _turn_to(context.screen.name, list(context.screen.areas).index(context.area), tab)
        return {"FINISHED"}


def _find(context, kind, name):
    """Returns the object, material, world or view layer of an issue, or None. Objects must be in the view
    layer."""
    objects = context.view_layer.objects
    if kind in OBJECT_KINDS:
        return objects.get(name)
    if kind == "light":  # by the object's name or the light's
        of_data = (item for item in objects if item.type == "LIGHT" and item.data.name == name)
        return objects.get(name) or next(of_data, None)
    if kind == "material":
        return bpy.data.materials.get(name)
    if kind == "world":
        return bpy.data.worlds.get(name)
    return context.scene.view_layers.get(name) if kind == "view layer" else context.scene


def _activate(context, kind, found):
    """Makes what was found the active thing of its kind. Returns the properties editor's tab that shows it,
    or ""."""
    if kind == "view layer":
        context.window.view_layer = found
    if kind == "material":
        item, slot = _user(context, found)
        if item is None:
            return ""
        _select(context, item)
        item.active_material_index = slot
    elif kind in (*OBJECT_KINDS, "light"):
        _select(context, found)
        return "OBJECT"
    return TABS[kind]


def _user(context, material):
    """Returns (object, slot) of the view layer that has the material, (None, 0) where none has."""
    for item in context.view_layer.objects:
        for number, slot in enumerate(item.material_slots):
            if slot.material == material:
                return item, number
    return None, 0


def _select(context, item):
    for other in context.selected_objects:
        other.select_set(False)
    context.view_layer.objects.active = item
    if item.visible_get():
        item.select_set(True)


def _activate_node(found, name):
    """Selects the node in the tree that warnings of this block name, where it is not inside a group."""
    block = found.data if isinstance(found, bpy.types.Object) else found
    tree = getattr(block, "node_tree", None)
    node = tree.nodes.get(name) if tree is not None else None
    if node is not None:
        for other in tree.nodes:
            other.select = other == node
        tree.nodes.active = node


def _turn_to(screen, number, tab, tries=1):
    """Shows a tab in the properties editor of this number on a screen. The tabs of an object that became
    active are there once Blender has drawn: then it tries again."""
    areas = bpy.data.screens[screen].areas if screen in bpy.data.screens else ()
    if number >= len(areas) or areas[number].type != "PROPERTIES":
        return
    try:
        areas[number].spaces.active.context = tab
    except TypeError:  # not among the tabs
        if tries:
            again = functools.partial(_turn_to, screen, number, tab, tries - 1)
            bpy.app.timers.register(again, first_interval=0.1)


class NEPHELE_PT_issues(OurPanel, bpy.types.Panel):
    """The list, by what it concerns."""

    bl_label = "Issues"
    bl_context = "render"

    def draw_header_preset(self, _context):
        count = len(findings.warnings) + bool(findings.fault)
        if count:
            self.layout.label(text=str(count), icon="ERROR")

    def draw(self, context):
        layout = self.layout
        layout.operator(NEPHELE_OT_check_scene.bl_idname, icon="FILE_REFRESH")
        layout.label(text=findings.origin or "Neither rendered nor checked yet")
        width = _letters(context)
        if findings.fault:
            box = layout.box()
            box.label(text="Cannot be rendered", icon="CANCEL")
            _paragraph(box, findings.fault, width)
        for (kind, name), issues in by_owner(findings.warnings).items():
            box = layout.box()
            _button(box, kind, name, name or "Scene", "", ICONS[kind])
            for issue in issues:
                if issue.node:
                    _button(box, kind, name, issue.node, issue.node, "NODE")
                _paragraph(box, issue.text, width)
        if findings.origin and not findings.warnings and not findings.fault:
            layout.label(text="All that the scene uses is supported", icon="CHECKMARK")


def _button(box, kind, name, text, node, icon):
    row = box.row()
    row.alignment = "LEFT"
    target = row.operator(NEPHELE_OT_go_to_issue.bl_idname, text=text, icon=icon, emboss=False)
    target.kind, target.name, target.node = kind, name, node


def _paragraph(box, text, width):
    """Shows a sentence in as many lines as it takes: Blender would cut it off."""
    column = box.column(align=True)
    column.scale_y = 0.75
    for line in textwrap.wrap(text[:1].upper() + text[1:], width):
        column.label(text=line)


def _letters(context):
    """Returns how many letters a line of the panel has room for."""
    scale = context.preferences.system.ui_scale
    return max(24, int((context.region.width / scale - MARGIN) / LETTER))


CLASSES = (NEPHELE_OT_check_scene, NEPHELE_OT_go_to_issue, NEPHELE_PT_issues)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    engine.listeners.append(_rendered)
    bpy.app.handlers.load_post.append(_forget)


def unregister():
    bpy.app.handlers.load_post.remove(_forget)
    engine.listeners.remove(_rendered)
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
