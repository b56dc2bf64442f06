# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: Blender's evaluated meshes to description.Mesh, by bulk reads only.

A mesh shared by many instances is read once. Its UV maps and attributes are read when the first material that
uses them appears, and numbered for the whole scene (programs are shared between meshes). What did not change
since the last export is not read again, or found to be the same and then the same arrays.
"""

import numpy as np

from .. import description
from .mesh_shape import island_random, pointiness
from .properties import ISLAND_RANDOM, POINTINESS

# (data type of an attribute, RNA property, components)
ATTRIBUTE_READERS = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int32),
    "BOOLEAN": ("value", 1, np.bool_),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
}


def read(collection, name, components, dtype=np.float32):
    """Returns (n, components), or (n,) for one component, of property `name` of every item, in one call."""
    result = np.empty(len(collection) * components, dtype)
    collection.foreach_get(name, result)
    return result.reshape(-1, components) if components > 1 else result


class MeshArrays:
    """What was read of a mesh; knows nothing of Blender, and is kept from one export to the next. Arrays as
    in description.Mesh, but UV maps and attributes by name."""

    def __init__(self):
        self.positions = self.triangles = self.corner_normals = self.material_index = None
        self.corner_count = 0
        self.has_normals = False  # whether they were read; corner_normals of a flat mesh are None
        self.uvs, self.attributes = {}, {}
        self.motion = self.motion_normals = None
        self._blank = {}

    def take(self, name, values, before):
        """Sets array `name`: to that of `before` (MeshArrays or None) where it holds the same."""
        setattr(self, name, same_or(values, getattr(before, name, None)))

    def shapes(self):
        """Returns (motion, motion_normals)."""
        return self.motion, self.motion_normals

    def blank(self, components):
        """Returns zeros, (T, 3, components): a layer that the mesh lacks."""
        if components not in self._blank:
            self._blank[components] = frozen(np.zeros((*self.triangles.shape, components), np.float32))
        return self._blank[components]


def frozen(array):
    """Returns `array` made read-only: what is built of it counts on that."""
    if array is not None:
        array.flags.writeable = False
    return array


def same_or(new, old):
    """Returns `old` where it is bit for bit the same as `new`, else `new`, read-only."""
    if new is None or old is None or new.shape != old.shape or new.dtype != old.dtype:
        return frozen(new)
    equal = np.array_equal(*(np.ascontiguousarray(a).reshape(-1).view(np.uint8) for a in (new, old)))
    return old if equal else frozen(new)


class MeshRecord:
    """One mesh while it is exported. mesh: Blender's, evaluated; it must stay alive until `finish`.

    known: MeshArrays that hold what is in it now; None: they are read. before: MeshArrays of the last export,
    whose arrays are taken over where they hold the same."""

    def __init__(self, name, mesh, known=None, before=None):
        self.name = name
        self._mesh = mesh
        self._uvs = {}  # number -> layer's name, None where the mesh has none
        self._attributes = {}
        self._corner_list = self._polygons = None
        self._has_surface = False
        self._before = known or before
        self._motion_before = (None, None) if self._before is None else self._before.shapes()
        self.arrays = known or self._read(before)

    def _read(self, before):
        mesh, arrays = self._mesh, MeshArrays()
        arrays.take("positions", read(mesh.attributes["position"].data, "vector", 3), before)
        arrays.corner_count = len(mesh.loops)
        corner_vertices = read(mesh.attributes[".corner_vert"].data, "value", 1, np.int32)
        triangles = corner_vertices[self.corners]
        arrays.take("triangles", triangles, before)
        arrays.take("material_index", self._face_values("material_index"), before)
        return arrays

    @property
    def corners(self):
        """(T, 3) corners of each triangle; read only where something needs them."""
        if self._corner_list is None:
            self._mesh.calc_loop_triangles()
            self._corner_list = read(self._mesh.loop_triangles, "loops", 3, np.int32)
        return self._corner_list

    @property
    def _polygon_index(self):
        """(T,) polygon of each triangle; read only where something needs it."""
        if self._polygons is None:
            self._mesh.calc_loop_triangles()
            self._polygons = read(self._mesh.loop_triangles, "polygon_index", 1, np.int32)
        return self._polygons

    def _normals(self, mesh, triangles):
        """Returns (T, 3, 3) corner normals of `mesh`, or None where it is flat."""
        domain = mesh.normals_domain
        if domain == "FACE":
            return None
        if domain == "POINT":
            return read(mesh.vertex_normals, "vector", 3)[triangles]
        return read(mesh.corner_normals, "vector", 3)[self.corners]

    def shape_of(self, mesh):
        """Returns (positions, corner normals or None) of `mesh`, this one's at another time; None where it
        has another number of vertices or corners. `corners` must have been asked for before."""
        arrays = self.arrays
        if len(mesh.vertices) != len(arrays.positions) or len(mesh.loops) != arrays.corner_count:
            return None
        normals = self._normals(mesh, arrays.triangles) if arrays.corner_normals is not None else None
        return read(mesh.attributes["position"].data, "vector", 3), normals

    def _face_values(self, name):
        """Returns (T,) int32 of an integer attribute on faces, or None where it is absent or 0 everywhere."""
        attribute = self._mesh.attributes.get(name)
        if attribute is None or attribute.domain != "FACE":
            return None
        values = read(attribute.data, "value", 1, np.int32)
        return values[self._polygon_index] if values.any() else None

    def used_slots(self, count):
        """Returns the material slots, of `count`, that a face uses; slots beyond the last count as it."""
        index = self.arrays.material_index
        if index is None:
            return {0}
        return set(np.flatnonzero(np.bincount(np.clip(index, 0, count - 1))).tolist())

    def require(self, uvs, attributes, surface):
        """Reads the UV maps and attributes (name -> number) that a material uses and the mesh has, and the
        normals where the material is a surface's."""
        if surface:
            self._require_normals()
        for name, number in uvs.items():
            if number not in self._uvs:
                self._uvs[number] = self._require_uv(name)
        for name, number in attributes.items():
            if number not in self._attributes:
                self._attributes[number] = self._require_attribute(name)

    def _require_normals(self):
        self._has_surface = True
        if not self.arrays.has_normals:
            normals = self._normals(self._mesh, self.arrays.triangles)
            self.arrays.take("corner_normals", normals, self._before)
            self.arrays.has_normals = True

    def _require_uv(self, name):
        layer = self._mesh.uv_layers.get(name) if name else self._active_uv()
        return self._layer_of("uvs", layer, self._read_uv)

    def _require_attribute(self, name):
        if name in (POINTINESS, ISLAND_RANDOM):
            return self._layer("attributes", name, lambda: self._read_shape(name))
        layer = self._mesh.attributes.get(name) if name else self._active_color()
        return self._layer_of("attributes", layer, self._read_attribute)

    def _layer_of(self, kind, layer, read_layer):
        """Returns the name of a layer of Blender's, once it is among the arrays; None of None."""
        return None if layer is None else self._layer(kind, layer.name, lambda: read_layer(layer))

    def _layer(self, kind, name, read_layer):
        """Returns `name`, once the layer called so is among the arrays."""
        layers = getattr(self.arrays, kind)
        if name not in layers:
            before = getattr(self._before, kind).get(name) if self._before else None
            layers[name] = same_or(read_layer(), before)
        return name

    def _active_uv(self):
        """Returns the UV map marked for rendering, or None."""
        return next((layer for layer in self._mesh.uv_layers if layer.active_render), None)

    def _active_color(self):
        """Returns the colour attribute marked for rendering, or None."""
        colors = self._mesh.color_attributes
        index = colors.render_color_index
        return colors[index] if 0 <= index < len(colors) else None

    def _read_uv(self, layer):
        return read(layer.uv, "vector", 2)[self.corners]

    def _read_shape(self, name):
        """Returns (T, 3, 4) of an attribute that follows from the mesh's shape."""
        arrays, edges = self.arrays, read(self._mesh.edges, "vertices", 2, np.int32)
        if name == POINTINESS:
            values = pointiness(arrays.positions, read(self._mesh.vertex_normals, "vector", 3), edges)
        else:
            values = island_random(len(arrays.positions), edges)
        rgba = np.ones((len(values), 4), np.float32)
        rgba[:, :3] = values[:, None]
        return rgba[arrays.triangles]

    def _read_attribute(self, attribute):
        """Returns (T, 3, 4) float32: numbers repeated over RGB, vectors padded with 0, alpha 1 where
        absent."""
        shape = self.arrays.triangles.shape
        if attribute.data_type not in ATTRIBUTE_READERS:
            return np.zeros((*shape, 4), np.float32)
        name, components, dtype = ATTRIBUTE_READERS[attribute.data_type]
        values = read(attribute.data, name, components, dtype).astype(np.float32).reshape(-1, components)
        padded = np.zeros((len(values), 4), np.float32)
        padded[:, 3] = 1.0
        padded[:, : 3 if components == 1 else components] = values
        if attribute.domain == "POINT":
            return padded[self.arrays.triangles]
        if attribute.domain == "CORNER":
            return padded[self.corners]
        if attribute.domain == "FACE":
            return np.repeat(padded[self._polygon_index][:, None], 3, axis=1)
        return np.zeros((*shape, 4), np.float32)

    def finish(self):
        """Returns the description.Mesh; its arrays are what `arrays` holds from now on."""
        arrays = self.arrays
        for layers, used in ((arrays.uvs, self._uvs), (arrays.attributes, self._attributes)):
            for name in layers.keys() - set(used.values()):
                del layers[name]
        if not self._has_surface:
            arrays.corner_normals, arrays.has_normals = None, False
        arrays.motion = arrays.motion_normals = None
        low, size = self._box()
        return description.Mesh(
            name=self.name,
            positions=arrays.positions,
            triangles=arrays.triangles,
            corner_normals=arrays.corner_normals,
            uvs=self._numbered(self._uvs, arrays.uvs, 2),
            attributes=self._numbered(self._attributes, arrays.attributes, 4),
            material_index=arrays.material_index,
            generated_min=low,
            generated_size=size,
        )

    def _box(self):
        return _generated_box(self._mesh)

    def moving(self, *shapes):
        """Returns the arrays of motion, given anew, as they are kept. After `finish`."""
        kept = [same_or(new, old) for new, old in zip(shapes, self._motion_before, strict=True)]
        self.arrays.motion, self.arrays.motion_normals = kept
        return kept

    def _numbered(self, names, layers, components):
        """Returns layers as a tuple by number, up to the last that the mesh has; zeros where it lacks one."""
        found = {number: layers[name] for number, name in names.items() if name is not None}
        if not found:
            return ()
        return tuple(
            found[number] if number in found else self.arrays.blank(components)
            for number in range(max(found) + 1)
        )


def _generated_box(mesh):
    """Returns (min, size) of the texture space, which generated coordinates map to [0, 1]^3."""
    center, half = np.array(mesh.texspace_location), np.array(mesh.texspace_size)
    return tuple(float(v) for v in center - half), tuple(float(v) for v in 2 * half)
