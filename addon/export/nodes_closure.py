# SPDX-License-Identifier: GPL-3.0-or-later
"""Closure nodes of surfaces, the world and lights: shader trees become weighted closures of the program."""

from ..opcodes import CLOSURES, DISTRIBUTIONS
from .nodes_math import clamp01
from .nodes_normal import normal_input
from .nodes_program import ONE, ZERO, constant
from .nodes_tree import relay, upstream

SOCKETS = {  # names of closure inputs -> identifiers of sockets, where they are not the words with capitals
    "ior": "IOR",
    "specular_ior_level": "Specular IOR Level",
    "coat_ior": "Coat IOR",
}
NORMALS = {"normal", "coat_normal"}

SIMPLE = {  # node type -> closure
    "BSDF_DIFFUSE": "diffuse",
    "BSDF_GLOSSY": "glossy",
    "BSDF_GLASS": "glass",
    "BSDF_REFRACTION": "refraction",
    "BSDF_TRANSLUCENT": "translucent",
    "BSDF_TRANSPARENT": "transparent",
    "EMISSION": "emission",
    "BACKGROUND": "emission",
    "BSDF_PRINCIPLED": "principled",
}

# Sockets that we do not honour: identifier -> what the picture lacks. They matter where linked or not zero.
UNSUPPORTED = {
    "Subsurface Weight": "subsurface scattering is not supported; the diffuse colour is used",
    "Anisotropic": "anisotropic reflection is not supported; it is isotropic",
    "Anisotropy": "anisotropic reflection is not supported; it is isotropic",
    "Thin Film Thickness": "thin films are not supported; there is none",
}


def socket_name(closure_input):
    """Returns the identifier of the socket that feeds a closure input."""
    return SOCKETS.get(closure_input, closure_input.replace("_", " ").title())


def compile_closures(c, socket, path, weight=ONE):
    """Adds the closures behind shader input `socket`, scaled by the Value `weight`, to the compiler's
    program."""
    output = upstream(socket)
    if output is None or weight.is_zero:
        return
    passed = relay(output, path)
    if passed is not None:
        behind, behind_path = passed
        if behind is not None:
            compile_closures(c, behind, behind_path, weight)
        return
    node = output.node
    if output.type != "SHADER":
        _emit_color(c, socket, path, weight)
    elif node.type == "MIX_SHADER":
        fac = clamp01(c, c.input(node, "Fac", path))
        compile_closures(c, node.inputs[1], path, c.emit("multiply", weight, c.emit("subtract", ONE, fac)))
        compile_closures(c, node.inputs[2], path, c.emit("multiply", weight, fac))
    elif node.type == "ADD_SHADER":
        compile_closures(c, node.inputs[0], path, weight)
        compile_closures(c, node.inputs[1], path, weight)
    elif node.type in SIMPLE:
        _simple(c, node, path, weight)
    else:
        _substitute(c, node, path, weight)


def _emit_color(c, socket, path, weight):
    """A colour linked to a shader input shines with it, as in Blender."""
    output = upstream(socket)
    handler_value = c.value(socket, path)
    c.warn(output.node, f"'{output.name}' is no shader; it is taken as emission")
    c.builder.closure("emission", weight, (handler_value, ONE))


def _simple(c, node, path, weight):
    kind = SIMPLE[node.type]
    warn_unsupported(c, node, path)
    inputs = []
    for name in CLOSURES[kind]:
        identifier = socket_name(name)
        inputs.append(
            normal_input(c, node, identifier, path) if name in NORMALS else c.input(node, identifier, path)
        )
    if kind == "emission" and (inputs[0].is_zero or inputs[1].is_zero):
        return
    c.builder.closure(kind, weight, inputs, distribution(c, node))


def warn_unsupported(c, node, path):
    """Warns about sockets in use that have no counterpart in the closures."""
    for identifier, text in UNSUPPORTED.items():
        socket = c.socket(node, identifier)
        if socket is not None and not c.value(socket, path).is_zero:
            c.warn(node, text)
    if node.type == "BSDF_PRINCIPLED":
        roughness = c.input(node, "Diffuse Roughness", path)
        if not roughness.is_zero:
            c.warn(node, "diffuse roughness is not supported; the diffuse part is Lambertian")


def distribution(c, node):
    """Returns the index in DISTRIBUTIONS of a node's microfacets; 0 for nodes without."""
    name = getattr(node, "distribution", "GGX").lower()
    if name not in DISTRIBUTIONS:
        c.warn(node, f"distribution {node.distribution.title()} is not supported; GGX is used")
        return 0
    return DISTRIBUTIONS.index(name)


def _substitute(c, node, path, weight):
    """Nodes without a closure of their own: the nearest one with a warning, or nothing."""
    if node.type == "BSDF_METALLIC":
        _metallic(c, node, path, weight)
    elif node.type == "SUBSURFACE_SCATTERING":
        c.warn(node, UNSUPPORTED["Subsurface Weight"])
        inputs = (c.input(node, "Color", path), ZERO, normal_input(c, node, "Normal", path))
        c.builder.closure("diffuse", weight, inputs)
    elif node.type == "HOLDOUT":
        c.warn(node, "holdout is not supported; the surface is black")
    else:
        c.warn(node, f"this shader ({node.bl_label}) is not supported; it is black")


def _metallic(c, node, path, weight):
    """A conductor as the Principled BSDF's metallic part: reflectance at normal incidence and edge tint
    (F82)."""
    warn_unsupported(c, node, path)
    if node.fresnel_type == "F82":
        color, tint = c.input(node, "Base Color", path), c.input(node, "Edge Tint", path)
    else:
        c.warn(node, "the physical conductor is approximated by its reflectance at normal incidence")
        color, tint = _conductor_f0(c, c.input(node, "IOR", path), c.input(node, "Extinction", path)), ONE
    inputs = dict.fromkeys(CLOSURES["principled"], ZERO) | {
        "base_color": color,
        "metallic": ONE,
        "roughness": c.input(node, "Roughness", path),
        "ior": constant(1.5),
        "alpha": ONE,
        "normal": normal_input(c, node, "Normal", path),
        "specular_ior_level": constant(0.5),
        "specular_tint": tint,
        "coat_ior": constant(1.5),
        "coat_tint": ONE,
        "coat_normal": None,
        "sheen_roughness": constant(0.5),
        "sheen_tint": ONE,
    }
    c.builder.closure("principled", weight, tuple(inputs.values()), distribution(c, node))


def _conductor_f0(c, n, k):
    """((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)."""
    k_squared = c.emit("multiply", k, k)
    below, above = c.emit("subtract", n, ONE), c.emit("add", n, ONE)
    return c.emit(
        "divide",
        c.emit("multiply_add", below, below, k_squared),
        c.emit("multiply_add", above, above, k_squared),
    )
