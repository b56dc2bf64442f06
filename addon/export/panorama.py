# SPDX-License-Identifier: GPL-3.0-or-later
"""Panoramic lenses: what description.Camera says of them. Blender 5.0 keeps their values with the camera,
older ones with what Cycles adds to it."""

from .context import ExportError

LENSES = {  # Blender's panorama types -> (our name, function of (values, sensor) that returns lens_values)
    "EQUIRECTANGULAR": (
        "equirectangular",
        lambda v, sensor: (v.longitude_min, v.longitude_max, v.latitude_min, v.latitude_max),
    ),
    "FISHEYE_EQUIDISTANT": ("fisheye_equidistant", lambda v, sensor: (v.fisheye_fov,)),
    "FISHEYE_EQUISOLID": ("fisheye_equisolid", lambda v, sensor: (v.fisheye_fov, v.fisheye_lens, *sensor)),
    "FISHEYE_LENS_POLYNOMIAL": (
        "fisheye_polynomial",
        lambda v, sensor: (
            v.fisheye_fov,
            *sensor,
            *(getattr(v, f"fisheye_polynomial_k{power}") for power in range(5)),
        ),
    ),
    "MIRRORBALL": ("mirror_ball", lambda v, sensor: ()),
    "EQUIANGULAR_CUBEMAP_FACE": ("equiangular_cubemap", lambda v, sensor: ()),
    "CENTRAL_CYLINDRICAL": (
        "central_cylindrical",
        lambda v, sensor: (
            v.central_cylindrical_range_u_min,
            v.central_cylindrical_range_u_max,
            v.central_cylindrical_range_v_min,
            v.central_cylindrical_range_v_max,
            v.central_cylindrical_radius,
        ),
    ),
}


def panorama(camera, width, height, render):
    """Returns the fields `lens` and `lens_values` of the description.Camera of a panoramic camera. width,
    height: of the frame, pixels. Raises ExportError for a lens that we do not have."""
    data = camera.data
    values = data if hasattr(data, "panorama_type") else getattr(data, "cycles", None)
    kind = getattr(values, "panorama_type", "EQUIRECTANGULAR")
    if values is None or kind not in LENSES:
        raise ExportError(
            f"unsupported camera: '{camera.name}' is a panorama of type {kind.title()}; use "
            "Equirectangular or a fisheye"
        )
    name, read = LENSES[kind]
    return {
        "lens": name,
        "lens_values": tuple(float(v) for v in read(values, _sensor(data, width, height, render))),
    }


def _sensor(data, width, height, render):
    """Returns (width, height) of the part of the sensor that the frame shows, mm."""
    wide, high = width * render.pixel_aspect_x, height * render.pixel_aspect_y
    horizontal = data.sensor_fit == "HORIZONTAL" or (data.sensor_fit == "AUTO" and wide >= high)
    if data.sensor_fit == "VERTICAL":
        return data.sensor_height * wide / high, data.sensor_height
    side = data.sensor_width
    return (side, side * high / wide) if horizontal else (side * wide / high, side)
