# SPDX-License-Identifier: GPL-3.0-or-later
"""Compiles materials', worlds' and lights' node trees: the entry points of the node compiler."""

import dataclasses

import bpy
import numpy as np

from .. import description
from ..opcodes import RAY_KINDS
from . import (
    nodes_color,
    nodes_ies,
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
from .nodes_tree import Compiler, upstream
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
    | nodes_ies.HANDLERS
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


MOST_BOUNCES = 1024  # Cycles' limit, and its value for worlds


def compile_world(world, context):
    """Returns the description.World of Blender's world (None: black); its background only where the view
    layer shows it."""
    if world is None:
        return description.World()
    compiled = dataclasses.replace(_compiled_world(world, context), visibility=_world_visibility(world))
    if getattr(getattr(world, "cycles", None), "max_bounces", MOST_BOUNCES) < MOST_BOUNCES:
        context.warn(
            f"world '{world.name}': its limit of bounces is not read, paths of any length see it; limit "
            "all light by Light Paths"
        )
    return compiled if context.view_layer.use_sky else dataclasses.replace(compiled, background=None)


def _world_visibility(world):
    """Returns the mask of rays that see the world, by settings that Cycles adds to it."""
    settings = getattr(world, "cycles_visibility", None)
    if settings is None:
        return description.ALL_RAYS
    names = {kind: "scatter" if kind == "volume" else kind for kind in RAY_KINDS}
    bits = (1 << n for n, kind in enumerate(RAY_KINDS) if getattr(settings, names[kind], True))
    return sum(bits) | 1 << RAY_KINDS.index("shadow")  # its volume casts shadows whatever is asked for


def _compiled_world(world, context):
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


def compile_light(light, context):
    """Returns (factor, program) of a light's node tree: what it multiplies the power by, (3,), and a
    description.Program whose emission scales the radiance besides, or None where that is the same
    everywhere."""
    if not uses_nodes(light):
        return (1.0, 1.0, 1.0), None
    owner = f"light '{light.name}'"
    output = active_output(light.node_tree)
    if output is None:
        context.warn(f"{owner}: has no active Light Output node; it gives no light")
        return (0.0, 0.0, 0.0), None
    context.block = light
    compiler = Compiler(owner, "light", context, HANDLERS)
    compile_closures(compiler, output.inputs["Surface"], ())
    program = finished(compiler)
    if any(closure.kind != "emission" for closure in program.closures):
        context.warn(f"{owner}: only Emission counts in a light; its other shaders are left out")
        emitting = tuple(closure for closure in program.closures if closure.kind == "emission")
        program = dataclasses.replace(program, closures=emitting)
    if len(program.code) > 0:
        return (1.0, 1.0, 1.0), program
    held = program.registers.astype(float)
    emitted = [held[c.weight] * held[c.inputs[0]] * held[c.inputs[1]] for c in program.closures]
    return tuple(float(v) for v in np.maximum(sum(emitted, np.zeros(3)), 0.0)), None
