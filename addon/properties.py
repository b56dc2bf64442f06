# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's properties: `Scene.nephele` from parameters.PARAMETERS, `ViewLayer.nephele` from
passes.PASSES, `Object.nephele`."""

import bpy

from .export.film import toggle_name
from .parameters import PARAMETERS
from .passes import PASSES

SUBTYPES = {
    "s": "TIME_ABSOLUTE",
    "m": "DISTANCE",
    "px": "PIXEL",
}  # unit of a parameter -> subtype of its property


def make_property(parameter):
    """Returns the Blender property of a Parameter."""
    common = {"name": parameter.label, "description": parameter.tooltip, "default": parameter.default}
    if parameter.kind == "bool":
        return bpy.props.BoolProperty(**common)
    if parameter.kind == "enum":
        items = [(*item, index) for index, item in enumerate(parameter.items)]
        return bpy.props.EnumProperty(items=items, **common)
    common |= {"min": parameter.minimum, "max": parameter.maximum}
    if parameter.soft_maximum is not None:
        common["soft_max"] = parameter.soft_maximum
    if parameter.kind == "int":
        return bpy.props.IntProperty(**common)
    return bpy.props.FloatProperty(subtype=SUBTYPES.get(parameter.unit, "NONE"), **common)


def own_passes():
    """Returns the rows of PASSES that Blender itself has no toggle for."""
    return tuple(row for row in PASSES if not (row.view_layer or row.denoised))


def _passes_changed(self, context):
    context.view_layer.update_render_passes()


def _make_toggle(row):
    text = row.doc if row.unit == "1" else f"{row.doc} [{row.unit}]"
    return bpy.props.BoolProperty(name=row.name, description=text, default=False, update=_passes_changed)


NepheleSceneSettings = type(
    "NepheleSceneSettings",
    (bpy.types.PropertyGroup,),
    {
        "__doc__": "Render settings, one property per row of parameters.PARAMETERS.",
        "__annotations__": {parameter.name: make_property(parameter) for parameter in PARAMETERS},
    },
)


class NepheleLayerSettings(bpy.types.PropertyGroup):
    """Pass toggles of a view layer, one per row of passes.PASSES without a toggle of Blender's."""

    __annotations__ = {toggle_name(row): _make_toggle(row) for row in own_passes()}


class NepheleObjectSettings(bpy.types.PropertyGroup):
    """What Nephele wants to know of an object."""

    dielectric_priority: bpy.props.IntProperty(
        name="Dielectric Priority",
        description=(
            "Where closed objects with a priority overlap, only the one of the highest is there: let water "
            "reach a little into its glass, and give the glass the higher priority. 0: the object takes no "
            "part, and its surface borders on air"
        ),
        default=0,
        min=0,
        max=100,
    )


CLASSES = (NepheleSceneSettings, NepheleLayerSettings, NepheleObjectSettings)


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.nephele = bpy.props.PointerProperty(type=NepheleSceneSettings)
    bpy.types.ViewLayer.nephele = bpy.props.PointerProperty(type=NepheleLayerSettings)
    bpy.types.Object.nephele = bpy.props.PointerProperty(type=NepheleObjectSettings)


def unregister():
    del bpy.types.Object.nephele
    del bpy.types.ViewLayer.nephele
    del bpy.types.Scene.nephele
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
