# SPDX-License-Identifier: GPL-3.0-or-later
"""Expression nodes that read the shading point: coordinates, geometry, object, attributes, light path."""

import numpy as np

from ..opcodes import RAY_KINDS
from .nodes_program import ONE, ZERO, constant
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
    if node.from_instancer:
        c.warn(node, "From Instancer is not supported; the object's own coordinates are used")
    if output.identifier == "UV":
        return c.emit("uv", mode=c.uv(""))
    if output.identifier == "Object":
        if node.object is None:
            return c.emit("object_coordinate")
        inverse = np.linalg.inv(matrix4(node.object.evaluated_get(c.context.depsgraph).matrix_world))
        return c.emit("transform", c.emit("position"), parameters=inverse[:3].ravel())
    return c.emit(COORDINATES[output.identifier])


def uv_map(c, node, output, path):
    if node.from_instancer:
        c.warn(node, "From Instancer is not supported; the object's own UV map is used")
    return c.emit("uv", mode=c.uv(node.uv_map))


GEOMETRY = {
    "Position": "position",
    "Normal": "normal",
    "True Normal": "geometric_normal",
    "Incoming": "incoming",
    "Backfacing": "backfacing",
}


def geometry(c, node, output, path):
    if output.identifier not in GEOMETRY:
        c.warn(node, f"output '{output.name}' is not supported; what it feeds falls back")
        return None
    return c.emit(GEOMETRY[output.identifier])


def camera_data(c, node, output, path):
    point = c.emit("camera_coordinate")
    if output.identifier == "View Vector":
        return c.emit("normalize", point)
    return (
        c.emit("channel", point, mode=2) if output.identifier == "View Z Depth" else c.emit("length", point)
    )


def object_info(c, node, output, path):
    operations = {
        "Location": "object_location",
        "Color": "object_color",
        "Object Index": "object_index",
        "Random": "object_random",
    }
    if output.identifier == "Material Index":
        return constant(c.pass_index)
    if output.identifier not in operations:
        c.warn(node, f"output '{output.name}' is not supported; what it feeds falls back")
        return None
    return c.emit(operations[output.identifier])


def attribute(c, node, output, path):
    if node.attribute_type != "GEOMETRY":
        c.warn(
            node,
            f"attributes of type {node.attribute_type.title()} are not supported; "
            f"'{node.attribute_name}' is 0",
        )
        return ZERO
    if c.scope != "material" or not node.attribute_name:
        c.warn(node, f"there is no attribute '{node.attribute_name}' here; it is 0")
        return ZERO
    return _read_attribute(c, node.attribute_name, output)


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


def light_path(c, node, output, path):
    if output.identifier not in LIGHT_PATH:
        c.warn(node, f"output '{output.name}' is not supported; it is 0")
        return ZERO
    return c.emit("ray_is", mode=LIGHT_PATH[output.identifier])


def normal_input(c, node, identifier, path):
    """Returns the Value of a normal input, or None where nothing is linked (the shading normal)."""
    return c.input(node, identifier, path) if c.is_linked(node, identifier, path) else None


def _normal_or_shading(c, node, path):
    normal = normal_input(c, node, "Normal", path)
    return c.emit("normal") if normal is None else normal


def fresnel(c, node, output, path):
    return c.emit("fresnel", c.input(node, "IOR", path), _normal_or_shading(c, node, path))


def layer_weight(c, node, output, path):
    mode = 0 if output.identifier == "Fresnel" else 1
    return c.emit("layer_weight", c.input(node, "Blend", path), _normal_or_shading(c, node, path), mode=mode)


def normal_map(c, node, output, path):
    if node.space != "TANGENT":
        c.warn(
            node, f"normal maps in {node.space.title()} space are not supported; the normal stays as it is"
        )
        return c.emit("normal")
    color, strength = c.input(node, "Color", path), c.input(node, "Strength", path)
    return c.emit("normal_map", color, strength, mode=c.uv(node.uv_map))


def bump(c, node, output, path):
    c.warn(node, "bump mapping is not supported; the normal stays as it is")
    return _normal_or_shading(c, node, path)


def normal(c, node, output, path):
    direction = constant(tuple(node.outputs["Normal"].default_value))
    if output.identifier == "Normal":
        return direction
    return c.emit("dot", c.emit("normalize", direction), c.emit("normalize", c.input(node, "Normal", path)))


def vector_transform(c, node, output, path):
    value = c.input(node, "Vector", path)
    if node.convert_from != node.convert_to:
        c.warn(
            node,
            f"transforms from {node.convert_from.title()} to {node.convert_to.title()} are not "
            "supported; not done",
        )
    return value


def wireframe(c, node, output, path):
    c.warn(node, "wireframe is not supported; it is 0")
    return ZERO


HANDLERS = {
    "TEX_COORD": texture_coordinate,
    "UVMAP": uv_map,
    "NEW_GEOMETRY": geometry,
    "CAMERA": camera_data,
    "OBJECT_INFO": object_info,
    "ATTRIBUTE": attribute,
    "VERTEX_COLOR": color_attribute,
    "LIGHT_PATH": light_path,
    "FRESNEL": fresnel,
    "LAYER_WEIGHT": layer_weight,
    "NORMAL_MAP": normal_map,
    "BUMP": bump,
    "NORMAL": normal,
    "VECT_TRANSFORM": vector_transform,
    "WIREFRAME": wireframe,
    "VALUE": lambda c, node, output, path: constant(float(node.outputs[0].default_value)),
    "RGB": lambda c, node, output, path: constant(tuple(node.outputs[0].default_value)),
    "AMBIENT_OCCLUSION": lambda c, node, output, path: _unoccluded(c, node, output, path),
}


def _unoccluded(c, node, output, path):
    c.warn(node, "ambient occlusion is not supported; nothing counts as occluded")
    return c.input(node, "Color", path) if output.identifier == "Color" else ONE
