# SPDX-License-Identifier: GPL-3.0-or-later
"""What is as it was at the last export, as far as Blender's dependency graph tells.

A dependency graph names what it evaluated anew since its updates were cleared, which is after each render of
an engine and after each view_update. That says all only of the graph that the last export saw, only to that
engine, and only if that export came to its end; otherwise everything counts as changed.
"""

import bpy

SHAPELESS = (
    bpy.types.Scene, bpy.types.Collection, bpy.types.Material, bpy.types.ShaderNodeTree, bpy.types.Image,
    bpy.types.World, bpy.types.Light, bpy.types.Camera, bpy.types.Action,
)  # fmt: skip
SHAPELESS_OBJECTS = {"LIGHT", "CAMERA", "SPEAKER", "LIGHT_PROBE"}


def uid(block):
    """Returns what tells a data-block from all others of this session, or None in a Blender that does not
    say."""
    return getattr(block.original, "session_uid", None)


class History:
    """Follows one dependency graph from export to export. begin() and end() enclose each."""

    def __init__(self):
        self._graph = None  # address of the graph that the last complete export saw
        self._seen, self._now = {}, {}  # uid of an object -> addresses of its evaluated data
        self._doubted = set()  # what changed since that export saw it, before the updates were cleared
        self._touched = self._reshaped = None  # uids; None: not known, all may be

    def begin(self, depsgraph, *, trusted):
        """Reads the updates of `depsgraph`. trusted: none was missed, see above."""
        touched, reshaped = _updates(depsgraph)
        if not trusted or self._graph != depsgraph.as_pointer() or None in touched:
            self._touched = self._reshaped = None
        else:
            self._touched, self._reshaped = touched | self._doubted, reshaped | self._doubted
        self._graph, self._now, self._doubted = None, {}, set()

    def forget(self):
        """Says that something may have changed unseen: the next export believes no updates."""
        self._graph = None

    def doubt(self, depsgraph):
        """Says that `depsgraph` evaluated other moments, and the frame again, after begin()."""
        self._doubted = _updates(depsgraph)[0]

    def end(self, depsgraph):
        """The export is complete."""
        self._graph, self._seen = depsgraph.as_pointer(), self._now

    def untouched(self, *blocks):
        """Tells whether nothing at all of the data-blocks was evaluated anew."""
        return self._touched is not None and not any(uid(block) in self._touched for block in blocks)

    def any_touched(self, uids):
        """Tells whether one of these data-blocks was evaluated anew, or may have been."""
        return self._touched is None or not self._touched.isdisjoint(uids)

    def see(self, item):
        """Takes note of the data of an evaluated object."""
        self._now.setdefault(uid(item), set()).add(item.data.as_pointer())

    def same_data(self, item, *, own):
        """Tells whether the data of an evaluated object are those that the last export saw. own: they are the
        object's, and not of an instance that Geometry Nodes or the like made."""
        number, data = uid(item), item.data
        self.see(item)
        if self._reshaped is None or data.as_pointer() not in self._seen.get(number, ()):
            return False
        if not own:  # which object they depend on is not known
            return not self._reshaped
        return number not in self._reshaped and uid(data) not in self._reshaped


def _updates(depsgraph):
    """Returns the uids of all that was evaluated anew, and of those whose shape may have changed: a mere flag
    without a kind may stand for anything."""
    touched, reshaped = set(), set()
    for update in depsgraph.updates:
        number = uid(update.id)
        touched.add(number)
        sure = update.is_updated_transform or update.is_updated_shading
        if (update.is_updated_geometry or not sure) and _has_shape(update.id):
            reshaped.add(number)
    return touched, reshaped


def _has_shape(block):
    """Tells whether meshes or volumes may depend on what a data-block holds, other than by way of an object
    that is named as well."""
    if isinstance(block, bpy.types.Object):
        return block.type not in SHAPELESS_OBJECTS
    return not isinstance(block, SHAPELESS)
