# SPDX-License-Identifier: GPL-3.0-or-later
"""The VSP View: a map of the last render (see maps.py) in false colour, as the image "VSP View" with its
legend bar along the bottom."""

import bpy
import numpy as np

from . import engine, maps
from .passes import BY_NAME

IMAGE = "VSP View"
LEGEND = "nephele_legend"  # the image's custom property: what the legend bar stands for
BAR_SHARE = 20  # the bar is this part of the image's height


def with_legend(shown):
    """Returns a maps.Map over its legend bar, (h, w, 3) of 8-bit sRGB, bottom row first."""
    height, width = shown.values.shape
    bar = shown.scale.colours(shown.scale.value(np.linspace(0, 1, width)))
    bar_height = max(4, height // BAR_SHARE)
    gap = np.zeros((max(1, bar_height // 4), width, 3), np.uint8)
    return np.concatenate([np.repeat(bar[np.newaxis], bar_height, axis=0), gap, shown.colours])


def write_image(pixels, legend):
    """Puts (h, w, 3) pixels of 8-bit sRGB, bottom row first, into the image "VSP View" and returns it."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(IMAGE)
    if image is None:
        image = bpy.data.images.new(IMAGE, width, height, alpha=False)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    opaque = np.concatenate([pixels / np.float32(255), np.ones((height, width, 1), np.float32)], axis=-1)
    image.pixels.foreach_set(opaque.astype(np.float32).reshape(-1))
    image[LEGEND] = legend
    image.update()
    return image


def show(context, image):
    """Shows `image` in every image editor that is open. Returns whether there is one."""
    areas = [area for window in context.window_manager.windows for area in window.screen.areas]
    editors = [area.spaces.active for area in areas if area.type == "IMAGE_EDITOR"]
    for editor in editors:
        editor.image = image
    return bool(editors)


class NEPHELE_OT_vsp_view(bpy.types.Operator):
    """Show a map of the last render in false colour, as the image "VSP View" """

    bl_idname = "nephele.vsp_view"
    bl_label = "VSP View"

    map: bpy.props.EnumProperty(
        name="Map",
        description="What to show",
        items=[(name, name, maps.doc(name)) for name in maps.FALSE_COLOURED],
        default=maps.TARGET,
    )

    def execute(self, context):
        record = engine.last_render
        if record is None:
            self.report({"ERROR"}, "nothing has been rendered by Nephele yet; render first (F12)")
            return {"CANCELLED"}
        images = {name: (BY_NAME[name].channels, pixels) for name, pixels in record.images.items()}
        found = [shown for shown in maps.maps_of(images) if shown.name == self.map]
        if not found:
            wanted = " and ".join(maps.needs(self.map))
            self.report(
                {"ERROR"},
                f"the last render (view layer '{record.view_layer}') does not hold {wanted}; enable the pass "
                "in the view layer's properties and render again",
            )
            return {"CANCELLED"}
        image = write_image(with_legend(found[0]), f"{self.map}: {found[0].scale.text()}")
        if not show(context, image):
            self.report({"INFO"}, f"choose the image '{IMAGE}' in an image editor")
        return {"FINISHED"}


class NEPHELE_PT_vsp_view(bpy.types.Panel):
    """The button of the VSP View and what its colours stand for; shown when its parent is."""

    bl_label = "VSP View"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    bl_parent_id = "NEPHELE_PT_guiding"

    def draw(self, context):
        self.layout.operator_menu_enum(NEPHELE_OT_vsp_view.bl_idname, "map", text="Show in False Colour")
        image = bpy.data.images.get(IMAGE)
        if image is not None and LEGEND in image:
            self.layout.label(text=image[LEGEND])


CLASSES = (NEPHELE_OT_vsp_view, NEPHELE_PT_vsp_view)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
