# SPDX-License-Identifier: GPL-3.0-or-later
"""What one export hands to the next: arrays of meshes and images, and files, as long as they are in use.

What did not change is the same object in both descriptions, which is how the native module knows it again.
"""

from .history import History, uid
from .unnoticed import evaluate_unnoticed


class Kept:
    """Values by key: those that the last complete export used."""

    def __init__(self):
        self._before, self._now = {}, {}

    def begin(self):
        self._now = {}

    def get(self, key):
        return self._now.get(key, self._before.get(key))

    def put(self, key, value):
        """Uses `value` in this export. Returns it."""
        self._now[key] = value
        return value

    def end(self):
        self._before, self._now = self._now, {}


class ExportCache:
    """Of one scene, whose exports follow one another. meshes: MeshArrays by key of the evaluated data.
    images: see images.py. materials: see materials.py. files: TemporaryPaths by what they hold. values: see
    unnoticed.py."""

    def __init__(self):
        self.history = History()
        self.meshes, self.images, self.materials, self.files, self.values = (Kept() for _ in range(5))
        self._kept = (self.meshes, self.images, self.materials, self.files, self.values)
        self._by_name = {}  # (uid of an object, name of its mesh) -> MeshArrays, of the last export

    def begin(self, depsgraph, engine, final):
        """An export begins. One that fails before `end` leaves all as it was, but for the trust in updates.
        engine: None where the updates of `depsgraph` may not be all since the last export of it. final: it is
        not of a viewport."""
        for kept in self._kept:
            kept.begin()
        if engine is not None and final:
            evaluate_unnoticed(engine, depsgraph, self.values)
        self.history.begin(depsgraph, trusted=engine is not None)

    def mesh_before(self, key, name):
        """Returns the MeshArrays that may hold what a mesh holds now, or None. name: see end()."""
        return self._by_name.get(name, self.meshes.get(key))

    def end(self, depsgraph, by_name):
        """The export is complete. by_name: (uid of an object, name of its mesh) -> MeshArrays."""
        self._by_name = by_name
        for kept in self._kept:
            kept.end()
        self.history.end(depsgraph)

    def file(self, item, *, own, make):
        """Returns make(), the TemporaryPath of a file that holds an object's data, or that of the last export
        where these are the same."""
        same = self.history.same_data(item, own=own)
        key = (uid(item), item.data.as_pointer())
        path = self.files.get(key) if same else None
        return self.files.put(key, make() if path is None else path)
