# SPDX-License-Identifier: GPL-3.0-or-later
"""Closure nodes of surfaces, the world and lights: shader trees become weighted closures of the program."""

from ..opcodes import CLOSURES, DISTRIBUTIONS, SUBSURFACE_METHODS
from .nodes_math import clamp01
from .nodes_normal import normal_input, radial_tangent
from .nodes_program import ONE
from .nodes_tree import relay, upstream

SOCKETS = {  # names of closure inputs -> identifiers of sockets, where they are not the words with capitals
    "ior": "IOR",
    "specular_ior_level": "Specular IOR Level",
    "coat_ior": "Coat IOR",
    "subsurface_ior": "Subsurface IOR",
    "thin_film_ior": "Thin Film IOR",
}
NORMALS = {"normal", "coat_normal"}
MISSING = {"thin_film_ior": 1.33}  # of Blenders whose node has no such socket; 0 elsewhere

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
    "BSDF_METALLIC": "metal",
    "BSDF_SHEEN": "sheen",
    "BSDF_TOON": "toon_diffuse",
    "SUBSURFACE_SCATTERING": "subsurface",
    "HOLDOUT": "holdout",
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
        _black(c, node)


def _emit_color(c, socket, path, weight):
    """A colour linked to a shader input shines with it, as in Blender."""
    output = upstream(socket)
    handler_value = c.value(socket, path)
    c.warn(output.node, f"'{output.name}' is no shader; it is taken as emission")
    c.builder.closure("emission", weight, (handler_value, ONE))


def _simple(c, node, path, weight):
    kind = closure_kind(c, node, path)
    inputs = [_closure_input(c, node, name, path) for name in CLOSURES[kind]]
    if kind == "emission" and (inputs[0].is_zero or inputs[1].is_zero):
        return
    c.builder.closure(kind, weight, inputs, closure_mode(c, node, path))


def closure_kind(c, node, path):
    """Returns the closure that a node becomes: the plainest that has all it uses."""

    def uses(identifier):
        return not c.input(node, identifier, path).is_zero

    kind = SIMPLE[node.type]
    if node.type == "BSDF_GLOSSY" and uses("Anisotropy"):
        return "brushed"
    if node.type == "BSDF_GLASS" and uses("Thin Film Thickness"):
        return "filmed_glass"
    if node.type == "BSDF_METALLIC" and node.fresnel_type == "PHYSICAL_CONDUCTOR":
        return "conductor"
    if node.type == "BSDF_SHEEN" and node.distribution == "ASHIKHMIN":
        return "velvet"
    if node.type == "BSDF_TOON" and node.component == "GLOSSY":
        return "toon_glossy"
    return kind


def _closure_input(c, node, name, path):
    """Returns the Value of a closure's input; None for a normal that is not connected and for a tangent that
    nothing asks for."""
    if name in NORMALS:
        return normal_input(c, node, socket_name(name), path)
    if name == "tangent":
        brushed = "Anisotropic" if node.type == "BSDF_PRINCIPLED" else "Anisotropy"
        if c.input(node, brushed, path).is_zero:
            return None
        linked = c.is_linked(node, "Tangent", path)
        return c.input(node, "Tangent", path) if linked else radial_tangent(c, 2)
    return c.input(node, socket_name(name), path, missing=MISSING.get(name, 0.0))


def closure_mode(c, node, path):
    """Returns the mode of a node's closure: its distribution, its subsurface method, or both."""
    if node.type == "SUBSURFACE_SCATTERING":
        return subsurface_method(node.falloff)
    if node.type == "BSDF_SHEEN":
        return 0
    mode = distribution(c, node)
    if node.type == "BSDF_PRINCIPLED" and not c.input(node, "Subsurface Weight", path).is_zero:
        mode += len(DISTRIBUTIONS) * subsurface_method(node.subsurface_method)
    return mode


def subsurface_method(name):
    """Returns the index in SUBSURFACE_METHODS of a Blender name."""
    return SUBSURFACE_METHODS.index(name.lower())


def distribution(c, node):
    """Returns the index in DISTRIBUTIONS of a node's microfacets; 0 for nodes without."""
    name = getattr(node, "distribution", "GGX").lower()
    if name not in DISTRIBUTIONS:
        c.warn(node, f"distribution {node.distribution.title()} is not supported; GGX is used")
        return 0
    return DISTRIBUTIONS.index(name)


WHY_BLACK = {  # node type -> why it has no closure, and the remedy
    "BSDF_HAIR": "hair is not rendered; use another BSDF on surfaces",
    "BSDF_HAIR_PRINCIPLED": "hair is not rendered; use another BSDF on surfaces",
    "BSDF_RAY_PORTAL": "rays do not jump to another place; use a Transparent BSDF or a mirror",
    "SHADERTORGB": "Shader to RGB is EEVEE's alone; link the shader itself",
    "EEVEE_SPECULAR": "it is EEVEE's alone; use a Principled BSDF",
}


def _black(c, node):
    """Warns about a node without a closure."""
    text = f"this shader ({node.bl_label}) is not supported; it is black"
    why = WHY_BLACK.get(node.type)
    c.warn(node, f"{text}: {why}" if why else text)
