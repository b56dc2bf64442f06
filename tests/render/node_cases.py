# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of many small tiles, each of which shines with the output of one node: what its materials hold is
known without noise, pixel by pixel. Every tile is a bent, smooth patch with UV maps and attributes under
one camera."""

import itertools
import math

import numpy as np
from nodes_arithmetic import CASES as ARITHMETIC
from nodes_images import CASES as IMAGES
from nodes_inputs import CASES as INPUTS
from nodes_procedural import CASES as PROCEDURAL
from tiles import look_down

PIXELS = 8  # along a tile's side
LIFT = 4.0  # added to every value, so that none is negative


class Tile:
    """One material, while it is built. Attributes give sockets that cases use as inputs."""

    def __init__(self, bpy, name):
        self.bpy = bpy
        self.material = bpy.data.materials.new(name)
        self.tree = self.material.node_tree
        self.tree.nodes.clear()
        self.output = self.tree.nodes.new("ShaderNodeOutputMaterial")
        self.emission = self.node("Emission")
        self.tree.links.new(self.emission.outputs[0], self.output.inputs["Surface"])

    def node(self, kind, inputs=(), **properties):
        """Adds ShaderNode`kind`. inputs: socket name, identifier or number -> constant or output socket."""
        node = self.tree.nodes.new(f"ShaderNode{kind}")
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in dict(inputs).items():
            found = [s for s in node.inputs if s.identifier == name]
            socket = found[0] if found else node.inputs[name]
            if isinstance(value, self.bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = value
        return node

    def out(self, kind, output, inputs=(), **properties):
        """Adds a node and returns its output of that name, identifier or number."""
        node = self.node(kind, inputs, **properties)
        found = [s for s in node.outputs if s.identifier == output]
        return found[0] if found else node.outputs[output]

    def snapped(self, socket):
        """The value of a coordinate that grows by 2 over the tile, at the middle of the pixel: both
        renderers have the same then, to the last bits."""
        step = 2 / PIXELS
        low = self.out("VectorMath", 0, {0: socket, 1: (step,) * 3}, operation="SNAP")
        return self.out("VectorMath", 0, {0: low, 1: (step / 2, step / 2, 0)}, operation="ADD")

    @property
    def lattice(self):
        """The middle of the pixel on the tile, [-1, 1]^2: sixteenths, so that no arithmetic rounds it."""
        flat = {0: self.out("TexCoord", "Object"), 1: (1, 1, 0)}
        return self.snapped(self.out("VectorMath", 0, flat, operation="MULTIPLY"))

    @property
    def point(self):
        """A point that varies in all three coordinates over the tile, about [-1, 1]^3."""
        turned = {"Vector": self.lattice, "Rotation": (0.6, 0.4, 0.9), "Location": (0.13, -0.21, 0.37)}
        return self.out("Mapping", 0, turned)

    @property
    def number(self):
        """A number that varies over the tile, about [-1, 1]."""
        return self.out("SeparateXYZ", 0, {0: self.point})

    @property
    def color(self):
        """A colour that varies over the tile, its channels in [0, 1]."""
        return self.out("TexNoise", "Color", {"Vector": self.point, "Scale": 1.5})

    def finish(self, socket):
        """Links the tile's value, lifted, to what shines."""
        lifted = self.out("VectorMath", 0, {0: socket, 1: (LIFT,) * 3}, operation="ADD")
        self.tree.links.new(lifted, self.emission.inputs["Color"])


def patch(bpy):
    """Returns the mesh of all tiles: 4 x 3 quads over [-1, 1]^2, bent. No pixel's middle lies on an edge."""
    x, y = np.meshgrid(np.linspace(-1, 1, 5), np.linspace(-1, 1, 4))
    z = 0.25 * np.sin(2.1 * x + 0.4) * np.cos(1.7 * y)
    vertices = np.stack((x, y, z), -1).reshape(-1, 3)
    faces = [(i, i + 1, i + 6, i + 5) for r, k in itertools.product(range(3), range(4)) for i in [5 * r + k]]
    mesh = bpy.data.meshes.new("Patch")
    mesh.from_pydata(vertices.tolist(), [], faces)
    mesh.shade_smooth()
    for name, turn in (("UVMap", 0.3), ("Other", 1.9)):
        layer = mesh.uv_layers.new(name=name)
        for loop in mesh.loops:
            u, v = 0.5 + 0.5 * vertices[loop.vertex_index][:2]
            c, s = math.cos(turn), math.sin(turn)
            layer.uv[loop.index].vector = (c * u - s * v + 0.2, s * u + c * v - 0.1)
    x, y, _ = vertices.T
    paint = np.stack((0.5 + 0.5 * x, 0.5 + 0.5 * y, 0 * x + 0.3, 0.5 + 0.4 * x * y), -1).astype(np.float32)
    # One after the other: a new attribute moves those before it.
    mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT").data.foreach_set("color", paint.ravel())
    mesh.attributes.new("weight", "FLOAT", "POINT").data.foreach_set(
        "value", (x - 0.3 * y).astype(np.float32)
    )
    return mesh


def build(bpy, cases):
    """Fills the open, empty file with a tile per case (name -> function (Tile) that returns a socket).
    Returns (columns, rows): tile number k has column k % columns, from the left, and row k // columns, from
    the bottom."""
    columns = math.ceil(math.sqrt(len(cases)))
    rows = math.ceil(len(cases) / columns)
    mesh = patch(bpy)
    scene = bpy.context.scene
    for k, (name, case) in enumerate(cases.items()):
        item = bpy.data.objects.new(name, mesh)
        item["strength"] = 0.3
        item.color = (0.2, 0.4, 0.6, 0.8)
        item.pass_index = 3
        item.location = (2 * (k % columns) - columns + 1, 2 * (k // columns) - rows + 1, 0)
        tile = Tile(bpy, name)
        tile.object = item
        tile.material.pass_index = 2
        tile.finish(case(tile))
        item.material_slots or mesh.materials or mesh.materials.append(None)
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = tile.material
        scene.collection.objects.link(item)
    look_down(bpy, scene, columns)
    scene.world = bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    scene.render.resolution_x, scene.render.resolution_y = columns * PIXELS, rows * PIXELS
    scene.view_layers[0]["tint"] = (0.1, 0.7, 0.4)
    return columns, rows


def tile_of(image, number, columns):
    """Returns (PIXELS, PIXELS, 3): the pixels of one tile. image: (h, w, 3), top row first."""
    column, row = number % columns, number // columns
    upside = image[::-1]
    part = upside[row * PIXELS : (row + 1) * PIXELS, column * PIXELS : (column + 1) * PIXELS]
    return part - LIFT


CASES = PROCEDURAL | ARITHMETIC | INPUTS | IMAGES
