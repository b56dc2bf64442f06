# SPDX-License-Identifier: GPL-3.0-or-later
"""The render tab: settings by parameter group, with what Blender has of each beside them, and the report."""

from typing import ClassVar

import bpy

from . import engine
from .blender_panels import (
    NEPHELE_PT_compositor,
    NEPHELE_PT_curves,
    NEPHELE_PT_motion_blur,
    NEPHELE_PT_shutter_curve,
    NEPHELE_PT_simplify,
)
from .panels import OurPanel
from .parameters import PARAMETERS
from .preset_menu import NEPHELE_PT_presets
from .settings_use import is_used

GROUPS = (  # (group of parameters, label, closed at first), in the order shown
    ("sampling", "Sampling", False),
    ("guiding", "Volume Guiding", False),
    ("volumes", "Volumes", False),
    ("paths", "Light Paths", False),
    ("film", "Film", False),
    ("performance", "Performance", True),
    ("advanced", "Verification", True),
)

# Panels inside of a group's: (group, identifier, label, closed at first, names). The group shows the rest.
SUBPANELS = (
    ("sampling", "error", "Stop at an Error", False, ("target_error", "adaptive_sampling", "estimate_error")),
    ("sampling", "random", "Advanced", True, ("sampler", "seed")),
    (
        "guiding",
        "vsp",
        "Camera Rays",
        True,
        (
            "vsp_primary",
            "vsp_criterion",
            "vsp_control",
            "vsp_defensive",
            "vsp_cost",
            "vsp_product",
            "vsp_gather",
            "vsp_target",
        ),
    ),
    (
        "guiding",
        "field",
        "After the Camera Ray",
        True,
        ("train_field", "guide_directions", "vsp_secondary", "guided_roulette", "guiding_memory"),
    ),
    ("volumes", "tracking", "Tracking", True, ("tracking", "transmittance", "majorant")),
    ("paths", "termination", "Termination and Clamping", True, ("roulette_depth", "clamp")),
    ("film", "filter", "Pixel Filter", False, ("pixel_filter", "filter_width")),
)

# Blender's properties shown beside ours: panel's identifier -> names in Scene.render.
BLENDER_PROPERTIES = {
    "film": ("film_transparent",),
    "performance": ("threads_mode", "threads", "use_persistent_data", "preview_pixel_size"),
}

# Ours that Blender's stand for in its panels: the command line's --threads comes before Blender's setting.
COMMAND_LINE_ONLY = {"threads"}

# Shorter texts, where the panel says the rest: labels are cut off in a narrow editor.
SHORT = {"surface_bounces": "Surface", "volume_bounces": "Volume", "distance_sampling": "Distances"}


class _SettingsPanel(OurPanel):
    """Mixin: some parameters, greyed out where others make them idle, and Blender's properties of the same
    matter."""

    bl_context = "render"
    identifier = ""
    names: ClassVar[tuple] = ()

    def draw(self, context):
        layout, settings, render = self.layout, context.scene.nephele, context.scene.render
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(align=self.identifier == "paths")
        for name in self.names:
            row = column.row(align=True)
            row.enabled = is_used(name, settings)
            row.prop(settings, name, **({"text": SHORT[name]} if name in SHORT else {}))
        for name in BLENDER_PROPERTIES.get(self.identifier, ()):
            row = layout.row()
            row.enabled = name != "threads" or render.threads_mode == "FIXED"
            row.prop(render, name)


def _draw_presets(self, _context):
    NEPHELE_PT_presets.draw_panel_header(self.layout)


def _panel(identifier, label, closed, names, parent=None):
    """Returns the panel class of some parameters."""
    options = {"DEFAULT_CLOSED"} if closed else set()
    members = {"bl_label": label, "bl_options": options, "identifier": identifier, "names": names}
    if parent:
        members["bl_parent_id"] = f"NEPHELE_PT_{parent}"
    if identifier == "sampling":
        members["draw_header_preset"] = _draw_presets
    return type(f"NEPHELE_PT_{identifier}", (_SettingsPanel, bpy.types.Panel), members)


def _group_panels(group, label, closed):
    """Yields the panel class of a parameter group and those inside of it."""
    inside = [row for row in SUBPANELS if row[0] == group]
    elsewhere = {name for row in inside for name in row[4]} | COMMAND_LINE_ONLY
    names = [p.name for p in PARAMETERS if p.group == group and p.name not in elsewhere]
    yield _panel(group, label, closed, tuple(names))
    for _, identifier, sublabel, subclosed, subnames in inside:
        yield _panel(f"{group}_{identifier}", sublabel, subclosed, subnames, parent=group)


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
        lines.append("Error: not estimated (Stop at an Error, Estimate Error)")
    return lines


def _classes():
    """Yields the panels in the order shown."""
    for row in GROUPS:
        yield from _group_panels(*row)
        if row[0] == "paths":
            yield NEPHELE_PT_motion_blur
            yield NEPHELE_PT_shutter_curve
            yield NEPHELE_PT_curves
        if row[0] == "performance":
            yield NEPHELE_PT_compositor
            yield NEPHELE_PT_simplify
    yield NEPHELE_PT_report


CLASSES = tuple(_classes())

register, unregister = bpy.utils.register_classes_factory(CLASSES)
