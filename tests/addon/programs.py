# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds materials, and runs their shading programs in numpy: the compiler is tested without the native
module."""

import numpy as np
from nephele import opcodes
from nephele.export.context import Context
from nephele.export.nodes import compile_material
from nephele.export.nodes_fold import FOLD

NAMES = list(opcodes.OPCODES)


def with_nodes(block):
    """Returns a material or world, shaded by nodes (always so from Blender 5.0 on)."""
    import bpy

    if bpy.app.version < (5, 0, 0):
        block.use_nodes = True
    return block


def run(program, inputs):
    """Returns the final (R, 3) registers. inputs: operation -> value (3,) of those that read the shading
    point, or a function (operands, parameters, mode)."""
    registers = program.registers.astype(np.float64)
    for op, destination, a, b, c, d, offset, mode in program.code.tolist():
        name = NAMES[op]
        operands = [registers[i].copy() for i in (a, b, c, d)]
        parameters = program.parameters[offset:].astype(np.float64)
        if name in inputs:
            value = inputs[name]
            registers[destination] = value(operands, parameters, mode) if callable(value) else value
        else:
            counts = {"ramp": 3 * (mode + 1), "ramp_alpha": mode + 1, "transform": 12}
            function = FOLD[name]
            used = operands[: arity(name)]
            registers[destination] = function(*used, parameters=parameters[: counts.get(name, 0)], mode=mode)
    return registers


def arity(name):
    """Returns how many operands an operation of FOLD takes."""
    special = {"ramp": 1, "ramp_alpha": 1, "transform": 1, "channel": 1, "map_range": 3, "blend": 3}
    if name in special:
        return special[name]
    for count in (1, 2, 3):
        try:
            FOLD[name](*[np.full(3, 0.5)] * count, parameters=(), mode=0)
        except (TypeError, ValueError):
            continue
        return count
    raise ValueError(name)


def closure_inputs(program, inputs, index=0):
    """Returns (closure, its weight (3,), dict of its inputs' values by name, without normals left
    unconnected)."""
    closure = program.closures[index]
    registers = run(program, inputs)
    names = opcodes.CLOSURES[closure.kind]
    values = {name: registers[k] for name, k in zip(names, closure.inputs, strict=True) if k >= 0}
    return closure, registers[closure.weight], values


POINT = {
    "position": np.array((0.3, -0.7, 1.9)),
    "uv": np.array((0.25, 0.75, 0.0)),
    "object_random": np.full(3, 0.4),
}


class Tree:
    """A material whose Emission node is fed by what a test builds. `color(...)` compiles and returns its
    Color."""

    def __init__(self, bpy):
        self.bpy = bpy
        self.material = with_nodes(bpy.data.materials.new("Material"))
        self.tree = self.material.node_tree
        self.tree.nodes.remove(self.tree.nodes["Principled BSDF"])
        self.output = self.tree.nodes["Material Output"]
        self.emission = self.node("ShaderNodeEmission")
        self.link(self.emission.outputs[0], self.output.inputs["Surface"])

    def node(self, kind, inputs=(), **properties):
        """Adds a node; inputs: socket name or number -> constant or output socket."""
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in dict(inputs).items():
            socket = node.inputs[name]
            if isinstance(value, self.bpy.types.NodeSocket):
                self.link(value, socket)
            else:
                socket.default_value = value
        return node

    def link(self, source, target):
        self.tree.links.new(source, target)

    def compile(self):
        self.context = Context(self.bpy.context.evaluated_depsgraph_get())
        return compile_material(self.material, self.context)[0]

    def color(self, output, inputs=POINT):
        """Returns (3,) that `output` gives at a point."""
        self.link(output, self.emission.inputs["Color"])
        program = self.compile().surface
        # an emission that is black while compiling has no closure
        return closure_inputs(program, inputs)[2]["color"] if program.closures else np.zeros(3)

    @property
    def warnings(self):
        return self.context.warnings
