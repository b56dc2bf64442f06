# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera's tab: what Blender shows of panoramic lenses for Cycles alone."""

import bpy

from .panels import OurPanel

# Panorama type -> rows of (property, label).
FIELDS = {
    "EQUIRECTANGULAR": (
        ("latitude_min", "Latitude Min"),
        ("latitude_max", "Max"),
        ("longitude_min", "Longitude Min"),
        ("longitude_max", "Max"),
    ),
    "FISHEYE_EQUIDISTANT": (("fisheye_fov", "Field of View"),),
    "FISHEYE_EQUISOLID": (("fisheye_lens", "Lens"), ("fisheye_fov", "Field of View")),
    "FISHEYE_LENS_POLYNOMIAL": (
        ("fisheye_fov", "Field of View"),
        *((f"fisheye_polynomial_k{power}", f"K{power}") for power in range(5)),
    ),
    "CENTRAL_CYLINDRICAL": (
        ("central_cylindrical_range_v_min", "Height Min"),
        ("central_cylindrical_range_v_max", "Max"),
        ("central_cylindrical_range_u_min", "Longitude Min"),
        ("central_cylindrical_range_u_max", "Max"),
        ("central_cylindrical_radius", "Cylinder Radius"),
    ),
}


class NEPHELE_PT_panorama(OurPanel, bpy.types.Panel):
    """The lens of a panoramic camera. Its values are the camera's own from Blender 4.3 on, and before that
    with what Cycles adds to cameras."""

    bl_label = "Panorama"
    bl_context = "data"
    bl_parent_id = "DATA_PT_lens"

    @classmethod
    def poll(cls, context):
        return context.camera is not None and context.camera.type == "PANO" and super().poll(context)

    def draw(self, context):
        camera, layout = context.camera, self.layout
        values = camera if hasattr(camera, "panorama_type") else getattr(camera, "cycles", None)
        if values is None:
            layout.label(text="Enable the add-on Cycles, whose settings these are", icon="INFO")
            return
        layout.use_property_split = True
        layout.prop(values, "panorama_type", text="Type")
        column = layout.column(align=True)
        for name, label in FIELDS.get(values.panorama_type, ()):
            column.prop(values, name, text=label)


CLASSES = (NEPHELE_PT_panorama,)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
