# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials written down as nested calls: each makes a node and gives the socket of its result."""

import bpy


class ShaderNodes:
    """A new material. Inputs of a node are constants or sockets of others, by the socket's
    name (with _ for spaces) or number."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.end = self.tree.nodes.new("ShaderNodeOutputMaterial")

    def finish(self, volume=None, surface=None):
        """Returns the material, whose volume and surface are these sockets."""
        for name, shader in (("Volume", volume), ("Surface", surface)):
            if shader is not None:
                self.tree.links.new(shader, self.end.inputs[name])
        return self.material

    def node(self, kind, properties=(), numbered=(), output=0, **inputs):
        """Returns the socket `output` (name or number) of a new node. numbered: its first inputs."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for key, value in dict(properties).items():
            setattr(node, key, value)
        for key, value in (*enumerate(numbered), *inputs.items()):
            self.connect(node, key.replace("_", " ") if isinstance(key, str) else key, value)
        return node.outputs[output]

    def connect(self, node, key, value):
        """Gives an input of a node, by name or number, a constant or a socket."""
        socket = node.inputs[key]
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = (*value, 1.0) if socket.type == "RGBA" else value

    def math(self, operation, *values):
        return self.node("Math", {"operation": operation}, values)

    def vector(self, operation, *values, output=0):
        return self.node("VectorMath", {"operation": operation}, values, output)

    def coordinate(self, kind="Object"):
        return self.node("TexCoord", output=kind)

    def noise(self, scale, detail=2.0, output="Fac", kind="Object", **inputs):
        """Returns fractal noise of a coordinate, about 1/2."""
        inputs = {"Scale": scale, "Detail": detail} | inputs
        return self.node("TexNoise", output=output, Vector=self.coordinate(kind), **inputs)

    def axis(self, vector, name):
        return self.node("SeparateXYZ", (), (vector,), name)

    def map_range(self, value, from_min, from_max, to_min, to_max):
        """Returns a number mapped linearly and clamped."""
        limits = {"From_Min": from_min, "From_Max": from_max, "To_Min": to_min, "To_Max": to_max}
        return self.node("MapRange", Value=value, **limits)

    def ramp(self, fac, *stops):
        """Returns the colour of a Color Ramp; stops: (position, (r, g, b)), the first two at least."""
        socket = self.node("ValToRGB", Fac=fac)
        elements = socket.node.color_ramp.elements
        for k, (position, color) in enumerate(stops):
            element = elements[k] if k < 2 else elements.new(position)
            element.position, element.color = position, (*color, 1.0)
        return socket

    def grid(self, name, output="Fac"):
        """Returns a grid of the volume: its Fac (a number), Color or Vector."""
        return self.node("Attribute", {"attribute_name": name}, output=output)

    def add(self, *shaders):
        return self.node("AddShader", (), shaders)

    def mix(self, fac, *shaders):
        return self.node("MixShader", (), (fac, *shaders))
