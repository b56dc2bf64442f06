# SPDX-License-Identifier: GPL-3.0-or-later
"""Which panels the properties editor shows for Nephele."""

from nephele import object_panels, panels
from nephele.export.objects import VISIBILITY


def test_no_excluded_panel_is_ours(bpy):
    shown = {
        p.__name__ for p in bpy.types.Panel.__subclasses__() if "NEPHELE" in getattr(p, "COMPAT_ENGINES", ())
    }
    assert {"DATA_PT_EEVEE_light", "MATERIAL_PT_preview", "DATA_PT_preview"} <= shown
    assert shown & panels.EXCLUDED == set()


def test_every_ray_visibility_that_the_exporter_reads_has_its_box():
    assert {f"visible_{rays}" for rays in object_panels.RAYS} == set(VISIBILITY)
