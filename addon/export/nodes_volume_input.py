# SPDX-License-Identifier: GPL-3.0-or-later
"""Expression nodes that read the grids of a volume, and the compiler of volume trees that numbers them."""

from . import nodes_input
from .nodes_program import ONE, ZERO, constant
from .nodes_tree import Compiler

LEAST_FLAME = 0.01  # a fluid domain's gas is cold below


class VolumeCompiler(Compiler):
    """Compiles one volume tree. grids: volume_grids.Grids of the data that it shades, or None for meshes and
    the world, which have none."""

    def __init__(self, owner, context, handlers, grids, pass_index=0):
        super().__init__(owner, "volume", context, handlers, pass_index)
        self.grids = grids
        self.grid_names = []  # by number of the "grid" operations

    def has_grid(self, name):
        """True where shaders find a grid of this name."""
        if self.grids is None:
            return False
        domain = self.grids.fire is not None
        return self.grids.count(name) is not None or (domain and name == "heat")

    def read_grid(self, name):
        """Returns the Value of grid `name` at the point, which the data need not have (it is 0 then)."""
        if self.grids is not None and self.grids.fire is not None and name in DOMAIN:
            return DOMAIN[name](self)
        return self.stored_grid(name)

    def read_number(self, name):
        """Returns the Value of grid `name` as one number: the mean of a vector's components."""
        value = self.read_grid(name)
        return self.emit("average", value) if self.grids and self.grids.count(name) == 3 else value

    def stored_grid(self, name):
        """Returns the Value of a grid as the file has it."""
        if name not in self.grid_names:
            self.grid_names.append(name)
        return self.emit("grid", self.emit("position"), mode=self.grid_names.index(name))


def _domain_temperature(c):
    """In thousands of kelvin, from the flame, as Blender hands it to renderers."""
    fire, flame = c.grids.fire, c.stored_grid("flame")
    burning = c.emit("greater_than", flame, constant(LEAST_FLAME))
    rise = constant(fire.hottest - fire.ignition)
    return c.emit("multiply", burning, c.emit("multiply_add", flame, rise, constant(fire.ignition)))


# Grids of a fluid domain that shaders see otherwise than its cache stores them.
DOMAIN = {
    "temperature": _domain_temperature,
    "heat": lambda c: c.emit("multiply", c.stored_grid("temperature"), constant(0.5)),
}


def _read(c, node, output, name):
    """Returns the Value of an output that gives grid `name`; 0, with a warning, where there is none."""
    if not name or not c.has_grid(name):
        c.warn(node, f"there is no grid '{name}' here; it is 0")
        return ZERO
    if output.identifier == "Alpha":
        return ONE
    return c.read_number(name) if output.type == "VALUE" else c.read_grid(name)


def attribute(c, node, output, path):
    if c.grids is not None and node.attribute_type in ("OBJECT", "INSTANCER"):
        kind = node.attribute_type.title()
        c.warn(node, f"attributes of type {kind} are not supported in grids; '{node.attribute_name}' is 0")
        return ZERO
    if node.attribute_type != "GEOMETRY":
        return nodes_input.attribute(c, node, output, path)
    return _read(c, node, output, node.attribute_name)


HANDLERS = {
    "ATTRIBUTE": attribute,
    "VERTEX_COLOR": lambda c, node, output, path: _read(c, node, output, node.layer_name),
    "VOLUME_INFO": lambda c, node, output, path: _read(c, node, output, output.identifier.lower()),
}
