# SPDX-License-Identifier: GPL-3.0-or-later
"""Walks Blender's node trees upstream and compiles the value of a socket.

Groups, reroutes and muted nodes only pass values on: `relay` says which input socket stands behind such an
output. A socket inside a group belongs to a path, the tuple of group nodes around it, outermost first,
because one group tree may be used many times with different inputs.
"""

from ..opcodes import SHIFT, SHIFTABLE
from .nodes_program import ProgramBuilder, constant

NUMBERS = {"VALUE", "INT", "BOOLEAN"}  # socket types that hold one number
VECTORS = {"RGBA", "VECTOR"}  # socket types that hold three


def upstream(socket):
    """Returns the output socket linked to input `socket`, or None."""
    if not socket.is_linked:  # Blender searches all links of the tree for those of a socket
        return None
    for link in socket.links:
        if link.is_valid and not link.is_muted:
            return link.from_socket
    return None


def relay(output, path):
    """Returns (input socket or None, its path) where the node of `output` only passes a value on; else
    None."""
    node = output.node
    if node.type == "REROUTE":
        return node.inputs[0], path
    if node.mute:
        behind = [link.from_socket for link in node.internal_links if link.to_socket == output]
        return (behind[0] if behind else None), path
    if node.type == "GROUP_INPUT":
        return (by_identifier(path[-1].inputs, output.identifier), path[:-1]) if path else (None, path)
    if node.type == "GROUP":
        return by_identifier(_group_inputs(node), output.identifier), (*path, node)
    return None


def _group_inputs(group):
    """Returns the sockets of the group's active output node; () where it has none."""
    if group.node_tree is None:
        return ()
    ends = [n for n in group.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output]
    return ends[0].inputs if ends else ()


def by_identifier(sockets, identifier):
    """Returns the socket with this identifier, or None."""
    return next((socket for socket in sockets if socket.identifier == identifier), None)


def origin(socket, path):
    """Follows links and relays from input `socket` to (output, path) of a node that computes, or None."""
    output = upstream(socket)
    while output is not None:
        passed = relay(output, path)
        if passed is None:
            return output, path
        behind, path = passed
        output = upstream(behind) if behind is not None else None
    return None


def place(socket, path):
    """Identifies a socket in its place: one of a group's sockets is a different one in each use of the
    group."""
    return (socket.as_pointer(), *(group.as_pointer() for group in path))


def inputs_first(socket, path, feeds):
    """Returns every (input socket, path) that `socket` depends on and then itself, each after all it depends
    on.

    feeds: function (node) -> input sockets to follow. Without recursion: trees may be long.
    """
    order, seen, stack = [], set(), [(socket, path, False)]
    while stack:
        at, at_path, done = stack.pop()
        if done:
            order.append((at, at_path))
            continue
        if place(at, at_path) in seen:
            continue
        seen.add(place(at, at_path))
        stack.append((at, at_path, True))
        output = upstream(at)
        if output is None:
            continue
        passed = relay(output, at_path)
        if passed is None:
            stack.extend((s, at_path, False) for s in feeds(output.node) if s.is_linked)
        elif passed[0] is not None:
            stack.append((*passed, False))
    return order


class Compiler:
    """Compiles one node tree. owner: text for warnings, as "material 'Smoke'". scope: "material", "world" or
    "light".

    context: export Context (images, numbering of UV maps and attributes, warnings). handlers: node type ->
    function(compiler, node, output, path) that returns a Value, or None when it cannot (having warned why).
    """

    def __init__(self, owner, scope, context, handlers, pass_index=0):
        self.owner = owner
        self.scope = scope
        self.context = context
        self.pass_index = pass_index
        self.builder = ProgramBuilder()
        self.plain_sky = None  # the Sky Texture whose sun is a lamp (nodes_sky.py)
        self.default_normal = None  # Value of normals where nothing is linked; None: as they are
        self.shift, self._step = 0, 0.0  # see `shifted`
        self.uvs = {}  # UV map name -> number, of those read
        self.attributes = {}  # attribute name -> number, of those read
        self._handlers = handlers
        self._known = {}

    def warn(self, node, text):
        """Adds a warning that names owner and node."""
        self.context.warn(f"{self.owner}, node '{node.name}': {text}")

    def emit(self, op, *operands, parameters=(), mode=0):
        """Returns the Value of an operation: ProgramBuilder.emit, beside the point where `shifted` says
        so."""
        if self.shift and op in SHIFTABLE:
            parameters, mode = (self._step,), mode + self.shift * SHIFT
        return self.builder.emit(op, *operands, parameters=parameters, mode=mode)

    def shifted(self, axis, step, compile_value):
        """Returns the Value that `compile_value` compiles, read `step` pixels beside the point along axis 1
        or 2 of the tangent plane; 0: at the point."""
        before = self.shift, self._step
        self.shift, self._step = axis, step
        try:
            return compile_value()
        finally:
            self.shift, self._step = before

    def property(self, key):
        """Returns the number of an object's property (properties.py)."""
        return self.context.property_number(key)

    def uv(self, name):
        """Returns the number of UV map `name` ("": the active one)."""
        return self.uvs.setdefault(name, self.context.uv_number(name))

    def attribute(self, name):
        """Returns the number of mesh attribute `name` ("": the active colour)."""
        return self.attributes.setdefault(name, self.context.attribute_number(name))

    def socket(self, node, identifier):
        """Returns the input socket of `node`, or None where this Blender's node has no such socket."""
        return by_identifier(node.inputs, identifier)

    def input(self, node, identifier, path, missing=0.0):
        """Returns the Value of an input; `missing` where this Blender's node has no such socket."""
        socket = self.socket(node, identifier)
        return constant(missing) if socket is None else self.value(socket, path)

    def is_linked(self, node, identifier, path):
        """True when a node computes the input."""
        socket = self.socket(node, identifier)
        return socket is not None and origin(socket, path) is not None

    def value(self, socket, path):
        """Returns the Value of an input socket, converted to the socket's type."""
        key = (place(socket, path), self.shift, self._step)
        if key not in self._known:  # inputs first, so that long chains of nodes do not recurse
            for behind, behind_path in inputs_first(socket, path, self._feeds):
                known = (place(behind, behind_path), self.shift, self._step)
                if known not in self._known:
                    self._known[known] = self._value(behind, behind_path)
        return self._known[key]

    def _feeds(self, node):
        """Returns the input sockets that the value of `node` may depend on."""
        return [s for s in node.inputs if s.enabled] if node.type in self._handlers else []

    def _value(self, socket, path):
        output = upstream(socket)
        if output is None:
            return default_value(socket)
        passed = relay(output, path)
        if passed is None:
            handler = self._handlers.get(output.node.type)
            if handler is None:
                self.warn(
                    output.node,
                    f"this node ({output.node.bl_label}) is not supported; '{socket.name}' falls back",
                )
                return default_value(socket)
            value = handler(self, output.node, output, path)
            return default_value(socket) if value is None else self.convert(value, output, socket)
        behind, behind_path = passed
        if behind is None:
            return default_value(socket)
        value = self.convert(self.value(behind, behind_path), behind, output)
        return self.convert(value, output, socket)

    def convert(self, value, source, target):
        """Blender's implicit conversion between the types of two sockets."""
        if target.type in NUMBERS and source.type == "RGBA":
            return self.emit("luminance", value)
        if target.type in NUMBERS and source.type == "VECTOR":
            return self.emit("average", value)
        return value


def default_value(socket):
    """Returns the constant Value that an unlinked socket holds (0 where it holds none)."""
    held = getattr(socket, "default_value", 0.0)
    if isinstance(held, bool | int | float):
        return constant(float(held))
    return constant(tuple(held)) if socket.type in VECTORS else constant(0.0)
