# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles materials', worlds' and lights' node trees: the entry points of the node compiler."""

import bpy

from .. import description
from . import (
    nodes_color,
    nodes_input,
    nodes_math,
    nodes_normal,
    nodes_procedural,
    nodes_sky,
    nodes_texture,
    nodes_volume_input,
)
from .needs import layers_read
from .nodes_closure import compile_closures
from .nodes_normal import displaced_normal
from .nodes_program import ONE, ProgramTooLarge, constant
from .nodes_tree import Compiler, relay, upstream
from .nodes_volume import compile_volume
from .nodes_volume_input import VolumeCompiler

HANDLERS = (
    nodes_input.HANDLERS
    | nodes_normal.HANDLERS
    | nodes_math.HANDLERS
    | nodes_color.HANDLERS
    | nodes_procedural.HANDLERS
    | nodes_texture.HANDLERS
    | nodes_sky.HANDLERS
)
VOLUME_HANDLERS = HANDLERS | nodes_volume_input.HANDLERS


def active_output(tree):
    """Returns the output node that Cycles would use, or None."""
    return tree.get_output_node("CYCLES") if tree is not None else None


def uses_nodes(block):
    """True when a material, world or light is shaded by its node tree; from Blender 5.0 on only lights may
    not be."""
    always = bpy.app.version >= (5, 0, 0) and not isinstance(block, bpy.types.Light)
    return block.node_tree is not None and (always or block.use_nodes)


def finished(compiler):
    """Returns the compiler's program; an empty (black) one, with a warning, where it grew too large."""
    try:
        return compiler.builder.finish()
    except ProgramTooLarge as fault:
        compiler.context.warn(f"{compiler.owner}: the node tree {fault}; it is rendered black. Simplify it")
        return description.Program()


def compile_material(material, context, grids=None):
    """Returns (description.Material, UV map names -> number, attribute names -> number).

    material: Blender's, with or without nodes. grids: volume_grids.Grids of the volume that it is for, where
    only its volume shader counts; None for meshes.
    """
    context.block, owner = material, f"material '{material.name}'"
    compiler = Compiler(owner, "material", context, HANDLERS, material.pass_index)
    if not uses_nodes(material):
        compiler.builder.closure(
            "diffuse", ONE, (constant(tuple(material.diffuse_color)), constant(0.0), None)
        )
        surface = compiler.builder.finish()
        return description.Material(material.name, surface, pass_index=material.pass_index), {}, {}
    output = active_output(material.node_tree)
    if output is None:
        context.warn(f"{owner}: has no active Material Output node; it is rendered black")
        black = description.Program()
        return description.Material(material.name, black, pass_index=material.pass_index), {}, {}
    if upstream(output.inputs["Displacement"]) is not None and grids is None:
        if material.displacement_method != "BUMP":
            compiler.warn(output, "true displacement is not supported; it is rendered as bump")
        compiler.default_normal = displaced_normal(compiler, output.inputs["Displacement"])
    volume = compile_volume(
        VolumeCompiler(owner, context, VOLUME_HANDLERS, grids, material.pass_index), output.inputs["Volume"]
    )
    has_surface = upstream(output.inputs["Surface"]) is not None
    has_volume = upstream(output.inputs["Volume"]) is not None
    surface = None
    if grids is None and (has_surface or not has_volume):
        compile_closures(compiler, output.inputs["Surface"], ())
        surface = finished(compiler)
    layers = ({}, {}) if surface is None else layers_read(surface, compiler.uvs, compiler.attributes)
    return description.Material(material.name, surface, volume, material.pass_index), *layers


def compile_world(world, context):
    """Returns the description.World of Blender's world (None: black)."""
    if world is None:
        return description.World()
    context.block, owner = world, f"world '{world.name}'"
    compiler = Compiler(owner, "world", context, HANDLERS)
    if not uses_nodes(world):
        compiler.builder.closure("emission", ONE, (constant(tuple(world.color)), ONE))
        return description.World(background=compiler.builder.finish())
    output = active_output(world.node_tree)
    if output is None:
        context.warn(f"{owner}: has no active World Output node; it is black")
        return description.World()
    volume = compile_volume(VolumeCompiler(owner, context, VOLUME_HANDLERS, None), output.inputs["Volume"])
    compiler.plain_sky, _ = nodes_sky.plain_sky(output)
    compile_closures(compiler, output.inputs["Surface"], ())
    sun = nodes_sky.sun_lamp(output)
    context.sky_lights += [] if sun is None else [sun]
    program = finished(compiler)
    return description.World(background=program if program.closures else None, volume=volume)


def light_factor(light, context):
    """Returns the (3,) tuple that a light's node tree multiplies its power by: colour times strength of its
    Emission."""
    if not uses_nodes(light):
        return (1.0, 1.0, 1.0)
    owner = f"light '{light.name}'"
    output = active_output(light.node_tree)
    if output is None:
        context.warn(f"{owner}: has no active Light Output node; it gives no light")
        return (0.0, 0.0, 0.0)
    compiler = Compiler(owner, "light", context, HANDLERS)
    found, path = upstream(output.inputs["Surface"]), ()
    while found is not None and (passed := relay(found, path)) is not None:
        behind, path = passed
        found = upstream(behind) if behind is not None else None
    if found is None:
        return (0.0, 0.0, 0.0)
    node = found.node
    if node.type != "EMISSION":
        compiler.warn(node, "only an Emission node is supported in a light; its nodes are left out")
        return (1.0, 1.0, 1.0)
    color, strength = compiler.input(node, "Color", path), compiler.input(node, "Strength", path)
    if color.constant is None or strength.constant is None:
        compiler.warn(
            node, "inputs that are not constant are not supported in a light; its nodes are left out"
        )
        return (1.0, 1.0, 1.0)
    return tuple(a * b for a, b in zip(color.constant, strength.constant, strict=True))
