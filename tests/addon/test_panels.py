# SPDX-License-Identifier: GPL-3.0-or-later
"""Which panels the properties editor shows for Nephele, and what they show. tests/blender draws them."""

from collections import Counter

from nephele import (
    camera_panels,
    layer_panels,
    object_panels,
    panels,
    parameters,
    passes,
    render_panels,
    settings_use,
)
from nephele.export.objects import VISIBILITY


def ours():
    """Returns our panels of the render tab, in the order of registration."""
    return [cls for cls in render_panels.CLASSES if issubclass(cls, render_panels._SettingsPanel)]


def test_no_excluded_panel_is_ours(bpy):
    shown = {
        p.__name__ for p in bpy.types.Panel.__subclasses__() if "NEPHELE" in getattr(p, "COMPAT_ENGINES", ())
    }
    assert {"DATA_PT_EEVEE_light", "MATERIAL_PT_preview", "DATA_PT_preview"} <= shown
    assert shown & panels.EXCLUDED == set()


def test_lists_name_panels_of_blender(bpy):
    """A name that Blender changed would silently exclude, or adopt, nothing."""
    names = {p.__name__ for p in bpy.types.Panel.__subclasses__()}
    assert names >= panels.EXCLUDED | panels.ADOPTED


def test_every_setting_has_one_place():
    counts = Counter(name for cls in ours() for name in cls.names)
    assert set(counts) | render_panels.COMMAND_LINE_ONLY == set(parameters.BY_NAME)
    assert set(counts.values()) == {1}


def test_settings_stand_in_their_group():
    for group, identifier, _, _, names in render_panels.SUBPANELS:
        assert {parameters.BY_NAME[name].group for name in names} == {group}, identifier


def test_no_panel_of_blender_stands_before_ours(bpy):
    """Blender orders panels by bl_order, then by registration: among equals its own come first, as Simplify
    would."""
    first = {
        p.__name__
        for p in bpy.types.Panel.__subclasses__()
        if "NEPHELE" in getattr(p, "COMPAT_ENGINES", ())
        and getattr(p, "bl_context", "") == "render"
        and not hasattr(p, "bl_parent_id")
        and getattr(p, "bl_order", 0) == 0
    }
    assert {name for name in first if not name.startswith("NEPHELE_PT_")} == set()
    assert render_panels.CLASSES[0].__name__ == "NEPHELE_PT_sampling"


def test_conditions_are_of_settings():
    assert set(settings_use.CONDITIONS) <= set(parameters.BY_NAME)


def test_every_ray_visibility_that_the_exporter_reads_has_its_box():
    assert {f"visible_{rays}" for rays in object_panels.RAYS} == set(VISIBILITY)


def test_every_pass_has_a_panel():
    assert {layer_panels.kind(row) for row in passes.PASSES} == {row[0] for row in layer_panels.KINDS}
    assert {row.name for row in passes.PASSES} >= layer_panels.OF_SAMPLING


def test_tooltips_tell_units():
    for parameter in parameters.PARAMETERS:
        assert parameter.tooltip.endswith(f"[{parameter.unit}]") == bool(parameter.unit)
    assert parameters.BY_NAME["time_limit"].tooltip == "Stop after this time; 0 renders all samples [s]"


def test_lenses_have_the_properties_that_are_shown(bpy):
    camera = bpy.data.cameras.new("Camera")
    values = camera if hasattr(camera, "panorama_type") else camera.cycles
    for kind, rows in camera_panels.FIELDS.items():
        values.panorama_type = kind
        assert all(hasattr(values, name) for name, _ in rows), kind
