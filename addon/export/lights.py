# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights: Blender's light objects to description.Light."""

import math

from .. import description
from .hash import random_number
from .nodes import compile_light
from .space import matrix4

MOST_BOUNCES = 1024


def export_light(context, instance, visibility, linking):
    """Returns the description.Light of a depsgraph instance whose object is a light; None of a portal.
    linking: its receivers and blockers."""
    item, light = instance.object, instance.object.data
    cycles = getattr(light, "cycles", None)  # settings that Cycles adds
    if light.type == "AREA" and getattr(cycles, "is_portal", False):
        context.warn(
            f"light '{item.name}': it is a portal, which gives no light; it is left out, and the world is "
            "sampled without it"
        )
        return None
    factor, program = compile_light(light, context)
    return description.Light(
        name=item.name,
        kind=light.type.lower(),
        world_from_light=matrix4(instance.matrix_world),
        power=_power(light, factor),
        normalize=getattr(light, "normalize", True),
        visibility=visibility,
        cast_shadow=light.use_shadow,
        max_bounces=int(getattr(cycles, "max_bounces", MOST_BOUNCES)),
        program=program,
        random=random_number(instance),
        **linking,
        **SHAPES[light.type](light),
    )


def _power(light, factor):
    """Returns (3,) W (W/m^2 for the sun): energy, exposure, colour, temperature and the light's nodes
    together. factor: of the nodes."""
    strength = light.energy * 2.0 ** getattr(light, "exposure", 0.0)
    tint = light.temperature_color if getattr(light, "use_temperature", False) else (1.0, 1.0, 1.0)
    return tuple(strength * c * t * n for c, t, n in zip(light.color, tint, factor, strict=True))


def _point(light):
    return {"radius": light.shadow_soft_size, "soft_falloff": getattr(light, "use_soft_falloff", False)}


def _spot(light):
    return _point(light) | {"spot_size": light.spot_size, "spot_blend": light.spot_blend}


def _sun(light):
    return {"angle": light.angle}


def _area(light):
    size_y = light.size_y if light.shape in ("RECTANGLE", "ELLIPSE") else light.size
    return {
        "shape": "ellipse" if light.shape in ("DISK", "ELLIPSE") else "rectangle",
        "size": (light.size, size_y),
        "spread": getattr(light, "spread", math.pi),
    }


SHAPES = {"POINT": _point, "SPOT": _spot, "SUN": _sun, "AREA": _area}
