# SPDX-License-Identifier: GPL-3.0-or-later
"""Expression nodes that read the shading point: coordinates, geometry, object, attributes, light path."""

import numpy as np

from ..opcodes import RAY_HISTORY, RAY_KINDS, SPACES
from .nodes_normal import normal_or_shading, radial_tangent
from .nodes_program import ONE, ZERO, constant
from .properties import INSTANCER, ISLAND_RANDOM, POINTINESS, STRAND, particle_property
from .space import matrix4


def ray_bits(*kinds):
    """Returns the mask of opcodes.RAY_KINDS with these kinds."""
    return sum(1 << RAY_KINDS.index(kind) for kind in kinds)


COORDINATES = {
    "Generated": "generated",
    "Normal": "normal_object",
    "Camera": "camera_coordinate",
    "Window": "window_coordinate",
    "Reflection": "reflection",
}


def texture_coordinate(c, node, output, path):
    if output.identifier in INSTANCER and node.from_instancer and c.scope == "material":
        return c.emit("object_attribute", mode=c.property(INSTANCER[output.identifier]))
    if output.identifier == "UV":
        return c.emit("parametric") if c.scope == "light" else c.emit("uv", mode=c.uv(""))
    if output.identifier == "Object":
        if node.object is None:
            return c.emit("object_coordinate")
        inverse = np.linalg.inv(matrix4(node.object.evaluated_get(c.context.depsgraph).matrix_world))
        return c.emit("transform", c.emit("position"), parameters=inverse[:3].ravel())
    return c.emit(COORDINATES[output.identifier])


def uv_map(c, node, output, path):
    if node.from_instancer and c.scope == "material":
        return c.emit("object_attribute", mode=c.property(INSTANCER["UV"]))
    return c.emit("parametric") if c.scope == "light" else c.emit("uv", mode=c.uv(node.uv_map))


GEOMETRY = {
    "Position": "position",
    "Normal": "normal",
    "True Normal": "geometric_normal",
    "Incoming": "incoming",
    "Parametric": "parametric",
    "Backfacing": "backfacing",
}
DERIVED = {
    "Pointiness": POINTINESS,
    "Random Per Island": ISLAND_RANDOM,
}  # attributes that the exporter computes


def geometry(c, node, output, path):
    if output.identifier == "Tangent":
        return radial_tangent(c, 2)
    if output.identifier in DERIVED:
        return (
            c.emit("attribute", mode=c.attribute(DERIVED[output.identifier]))
            if c.scope == "material"
            else ZERO
        )
    return c.emit(GEOMETRY[output.identifier])


def camera_data(c, node, output, path):
    point = c.emit("camera_coordinate")
    if output.identifier == "View Vector":
        return c.emit("normalize", point)
    return (
        c.emit("channel", point, mode=2) if output.identifier == "View Z Depth" else c.emit("length", point)
    )


OBJECT_INFO = {
    "Location": "object_location",
    "Color": "object_color",
    "Alpha": "object_alpha",
    "Object Index": "object_index",
    "Random": "object_random",
}


def object_info(c, node, output, path):
    if output.identifier == "Material Index":
        return constant(c.pass_index)
    return c.emit(OBJECT_INFO[output.identifier])


def particle_info(c, node, output, path):
    return c.emit("object_attribute", mode=c.property(particle_property(output.identifier)))


def strand_info(c, node, output, path):
    """Curves Info and Point Info: 0 on what is neither."""
    name = f"\0strand {output.name}"
    if c.scope != "material":
        return ZERO
    if name not in STRAND:
        c.warn(node, f"output '{output.name}' is not supported; it is the normal")
        return c.emit("normal")
    value = c.emit("attribute", mode=c.attribute(name))
    return c.emit("convert_space", value, mode=SPACES.index("object")) if output.name == "Position" else value


def attribute(c, node, output, path):
    kind, name = node.attribute_type, node.attribute_name
    if kind == "VIEW_LAYER":
        return _selected(output, lambda: constant(c.context.view_layer_value(name)), c)
    if c.scope not in ("material", "volume") or not name:
        c.warn(node, f"there is no attribute '{name}' here; it is 0")
        return ZERO
    if kind == "GEOMETRY":
        return _read_attribute(c, name, output)
    number = c.property((kind, name))
    if output.identifier == "Alpha":
        return c.emit("object_attribute_alpha", mode=number)
    return _selected(output, lambda: c.emit("object_attribute", mode=number), c)


def _selected(output, read, c):
    """Returns what an output of Attribute makes of the colour that `read` gives; its alpha is 1."""
    if output.identifier == "Alpha":
        return ONE
    return c.emit("average", read()) if output.identifier == "Fac" else read()


def color_attribute(c, node, output, path):
    return _read_attribute(c, node.layer_name, output)


def _read_attribute(c, name, output):
    number = c.attribute(name)
    if output.identifier == "Alpha":
        return c.emit("attribute_alpha", mode=number)
    value = c.emit("attribute", mode=number)
    return c.emit("average", value) if output.identifier == "Fac" else value


LIGHT_PATH = {
    "Is Camera Ray": ray_bits("camera"),
    "Is Shadow Ray": ray_bits("shadow"),
    "Is Diffuse Ray": ray_bits("diffuse"),
    "Is Glossy Ray": ray_bits("glossy"),
    "Is Reflection Ray": ray_bits("diffuse", "glossy"),
    "Is Transmission Ray": ray_bits("transmission"),
    "Is Volume Scatter Ray": ray_bits("volume"),
}


HISTORY = {
    "Is Singular Ray": "singular",
    "Ray Length": "length",
    "Ray Depth": "depth",
    "Diffuse Depth": "diffuse",
    "Glossy Depth": "glossy",
    "Transparent Depth": "transparent",
    "Transmission Depth": "transmission",
}


def light_path(c, node, output, path):
    if output.identifier in LIGHT_PATH:
        return c.emit("ray_is", mode=LIGHT_PATH[output.identifier])
    if output.identifier == "Portal Depth":
        return ZERO  # there are no portals
    if c.scope == "volume":
        c.warn(node, f"output '{output.name}' is not supported in volumes; it is 0")
        return ZERO
    return c.emit("ray_history", mode=RAY_HISTORY.index(HISTORY[output.identifier]))


def light_falloff(c, node, output, path):
    """Strength times the power of the distance that makes the light fall off so: none, once or twice."""
    strength, smooth = c.input(node, "Strength", path), c.input(node, "Smooth", path)
    if c.scope not in ("material", "light"):
        if output.identifier != "Quadratic" or not smooth.is_zero:
            c.warn(
                node, f"output '{output.name}' is supported on surfaces only; the light falls off as usual"
            )
        return strength
    distance = c.emit("ray_history", mode=RAY_HISTORY.index("length"))
    square = c.emit("multiply", distance, distance)
    powers = {"Quadratic": ONE, "Linear": distance, "Constant": square}
    softened = c.emit("divide", square, c.emit("add", smooth, square)) if not smooth.is_zero else ONE
    return c.emit("multiply", c.emit("multiply", strength, powers[output.identifier]), softened)


def fresnel(c, node, output, path):
    return c.emit("fresnel", c.input(node, "IOR", path), normal_or_shading(c, node, path))


def layer_weight(c, node, output, path):
    mode = 0 if output.identifier == "Fresnel" else 1
    return c.emit("layer_weight", c.input(node, "Blend", path), normal_or_shading(c, node, path), mode=mode)


def wireframe(c, node, output, path):
    return c.emit("wireframe", c.input(node, "Size", path), mode=int(node.use_pixel_size))


HANDLERS = {
    "TEX_COORD": texture_coordinate,
    "UVMAP": uv_map,
    "NEW_GEOMETRY": geometry,
    "CAMERA": camera_data,
    "OBJECT_INFO": object_info,
    "ATTRIBUTE": attribute,
    "VERTEX_COLOR": color_attribute,
    "LIGHT_PATH": light_path,
    "LIGHT_FALLOFF": light_falloff,
    "PARTICLE_INFO": particle_info,
    "HAIR_INFO": strand_info,
    "POINT_INFO": strand_info,
    "FRESNEL": fresnel,
    "LAYER_WEIGHT": layer_weight,
    "WIREFRAME": wireframe,
    "VALUE": lambda c, node, output, path: constant(float(node.outputs[0].default_value)),
    "RGB": lambda c, node, output, path: constant(tuple(node.outputs[0].default_value)),
    "AMBIENT_OCCLUSION": lambda c, node, output, path: _unoccluded(c, node, output, path),
}


def _unoccluded(c, node, output, path):
    c.warn(node, "ambient occlusion is not supported; nothing counts as occluded")
    return c.input(node, "Color", path) if output.identifier == "Color" else ONE
