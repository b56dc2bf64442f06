# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds volume materials, and evaluates what they compile to at a point, programs or not."""

import numpy as np
from nephele.export.context import Context
from nephele.export.nodes import compile_material
from nephele.export.volume_grids import Grids
from programs import closure_inputs, with_nodes

NAMES = ("density", "smoke", "heat", "flame", "temperature")
GRIDS = Grids((*((name, 1) for name in NAMES), ("color", 3), ("velocity", 3)))
POINT = np.array((0.3, -0.7, 1.9))


class VolumeTree:
    """A material with a Volume socket to fill."""

    def __init__(self, bpy):
        self.bpy = bpy
        self.material = with_nodes(bpy.data.materials.new("Fog"))
        self.tree = self.material.node_tree
        self.tree.links.clear()
        self.target = self.tree.nodes["Material Output"].inputs["Volume"]

    def node(self, kind, properties=(), **inputs):
        """Adds a node; inputs: socket names with _ for blanks -> constant or output socket."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in dict(properties).items():
            setattr(node, name, value)
        for name, value in inputs.items():
            self.set(node, name.replace("_", " "), value)
        return node

    def set(self, node, name, value):
        if isinstance(value, self.bpy.types.NodeSocket):
            self.tree.links.new(value, node.inputs[name])
        else:
            node.inputs[name].default_value = value

    def attribute(self, name, output="Fac"):
        node = self.node("Attribute", {"attribute_name": name})
        return next(s for s in node.outputs if s.identifier == output)

    def math(self, operation, *values):
        node = self.node("Math", {"operation": operation})
        for k, value in enumerate(values):
            self.set(node, k, value)
        return node.outputs[0]

    def position(self):
        return self.node("NewGeometry").outputs["Position"]

    def mix(self, fac, *shaders):
        """Returns a Mix Shader (an Add Shader where `fac` is None) of two nodes, None for an empty socket."""
        node = self.tree.nodes.new("ShaderNodeAddShader" if fac is None else "ShaderNodeMixShader")
        if fac is not None:
            self.set(node, 0, fac)
        for socket, shader in zip(node.inputs[-2:], shaders, strict=True):
            if shader is not None:
                self.tree.links.new(shader.outputs[0], socket)
        return node

    def compile(self, node, grids=GRIDS):
        self.tree.links.new(node.outputs[0], self.target)
        self.context = Context(self.bpy.context.evaluated_depsgraph_get())
        return compile_material(self.material, self.context, grids)[0].volume

    @property
    def warnings(self):
        return self.context.warnings


def evaluate(closure, fields=(), **inputs):
    """Returns dict(sigma_s, sigma_a, emission, phase_a, phase_b, each (3,)) of a closure at POINT.

    fields: grid name -> value there, or function (point) -> value. inputs: operation -> value (see
    programs.run).
    """
    fields = dict(fields)
    if closure.program is None:
        scale = np.array(
            [fields.get(n, 0.0) if n else 1.0 for n in (closure.density_grid, closure.emission_grid)]
        )
        return {
            "sigma_s": np.array(closure.sigma_s) * scale[0],
            "sigma_a": np.array(closure.sigma_a) * scale[0],
            "emission": np.array(closure.emission) * scale[1],
            "phase_a": np.full(3, closure.phase.a),
            "phase_b": np.full(3, closure.phase.b),
        }

    def grid(operands, parameters, mode):
        value = fields.get(closure.grids[mode], 0.0)
        return np.broadcast_to(value(operands[0]) if callable(value) else value, 3)

    (row,) = closure.program.closures
    row, weight, values = closure_inputs(closure.program, {"position": POINT, "grid": grid} | inputs)
    assert row.kind == "medium"
    assert np.array_equal(weight, np.ones(3))
    return values


def total(closures, name, fields=(), **inputs):
    """Returns (3,), the sum over closures of one coefficient at POINT."""
    return sum((evaluate(c, fields, **inputs)[name] for c in closures), np.zeros(3))
