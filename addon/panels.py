# SPDX-License-Identifier: GPL-3.0-or-later
"""Which panels of Blender's serve Nephele too, and what our own have in common."""

import bpy

ENGINE = "NEPHELE"

# Panels for every engine that would promise what we do not have, or that ours replace.
EXCLUDED = {
    "DATA_PT_light",
    "DATA_PT_lightprobe",
    "DATA_PT_lightprobe_display",
    "DATA_PT_lightprobe_parallax",
    "DATA_PT_lightprobe_visibility",
    "RENDER_PT_simplify",  # it would stand before ours: render_panels.py has it in its place
    "RENDER_PT_simplify_greasepencil",
    "RENDER_PT_simplify_render",
    "RENDER_PT_simplify_viewport",
    "RENDER_PT_stereoscopy",
    "VIEWLAYER_PT_filter",
}
# Panels that Blender gives to its own engines only, and that serve us as they are.
ADOPTED = {
    "DATA_PT_EEVEE_light",
    "DATA_PT_camera_dof",
    "DATA_PT_camera_dof_aperture",
    "EEVEE_MATERIAL_PT_context_material",
    "MATERIAL_PT_preview",
    "VIEWLAYER_PT_layer_passes",
    "VIEWLAYER_PT_layer_passes_cryptomatte",
}


class OurPanel:
    """Mixin: a panel of the properties editor, shown when Nephele renders. needs: what the context must have
    for it, "world" for one, or "" for nothing."""

    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    COMPAT_ENGINES = frozenset({ENGINE})
    needs = ""

    @classmethod
    def poll(cls, context):
        there = not cls.needs or getattr(context, cls.needs, None) is not None
        return there and context.engine in cls.COMPAT_ENGINES


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


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        if not issubclass(panel, OurPanel) and hasattr(panel, "COMPAT_ENGINES"):
            panel.COMPAT_ENGINES.discard(ENGINE)
