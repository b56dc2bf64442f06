# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: Blender's evaluated meshes to description.Mesh, by bulk reads only.

A mesh shared by many instances is read once. Its UV maps and attributes are read when the first material that
uses them appears, and numbered for the whole scene (programs are shared between meshes).
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


class MeshRecord:
    """One mesh while it is exported. mesh: Blender's, evaluated; it must stay alive until the last
    `require`."""

    def __init__(self, name, mesh):
        self.name = name
        self._mesh = mesh
        self._uvs = {}  # number -> (T, 3, 2)
        self._attributes = {}  # number -> (T, 3, 4)
        mesh.calc_loop_triangles()
        self._corners = read(mesh.loop_triangles, "loops", 3, np.int32)
        self._polygons = None
        self.positions = read(mesh.attributes["position"].data, "vector", 3)
        self._corner_count = len(mesh.loops)
        corner_vertices = read(mesh.attributes[".corner_vert"].data, "value", 1, np.int32)
        self.triangles = corner_vertices[self._corners]
        self.corner_normals = self._normals(mesh)
        self.material_index = self._face_values("material_index")

    @property
    def _polygon_index(self):
        """(T,) polygon of each triangle; read only where something needs it."""
        if self._polygons is None:
            self._polygons = read(self._mesh.loop_triangles, "polygon_index", 1, np.int32)
        return self._polygons

    def _normals(self, mesh):
        """Returns (T, 3, 3) corner normals of `mesh`, or None where it is flat."""
        domain = mesh.normals_domain
        if domain == "FACE":
            return None
        if domain == "POINT":
            return read(mesh.vertex_normals, "vector", 3)[self.triangles]
        return read(mesh.corner_normals, "vector", 3)[self._corners]

    def shape_of(self, mesh):
        """Returns (positions, corner normals or None) of `mesh`, this one's at another time; None where it
        has another number of vertices or corners."""
        if len(mesh.vertices) != len(self.positions) or len(mesh.loops) != self._corner_count:
            return None
        normals = self._normals(mesh) if self.corner_normals is not None else None
        return read(mesh.attributes["position"].data, "vector", 3), normals

    def _face_values(self, name):
        """Returns (T,) int32 of an integer attribute on faces, or None where it is absent or 0 everywhere."""
        attribute = self._mesh.attributes.get(name)
        if attribute is None or attribute.domain != "FACE":
            return None
        values = read(attribute.data, "value", 1, np.int32)
        return values[self._polygon_index] if values.any() else None

    def require(self, uvs, attributes):
        """Reads the UV maps and attributes (name -> number) that a material uses and the mesh has."""
        for name, number in uvs.items():
            if number not in self._uvs:
                layer = self._mesh.uv_layers.get(name) if name else self._active_uv()
                if layer is not None:
                    self._uvs[number] = read(layer.uv, "vector", 2)[self._corners]
        for name, number in attributes.items():
            if number not in self._attributes:
                if name in (POINTINESS, ISLAND_RANDOM):
                    self._attributes[number] = self._read_shape(name)
                    continue
                attribute = self._mesh.attributes.get(name) if name else self._active_color()
                if attribute is not None:
                    self._attributes[number] = self._read_attribute(attribute)

    def _active_uv(self):
        """Returns the UV map marked for rendering, or None."""
        return next((layer for layer in self._mesh.uv_layers if layer.active_render), None)

    def _active_color(self):
        """Returns the colour attribute marked for rendering, or None."""
        colors = self._mesh.color_attributes
        index = colors.render_color_index
        return colors[index] if 0 <= index < len(colors) else None

    def _read_shape(self, name):
        """Returns (T, 3, 4) of an attribute that follows from the mesh's shape."""
        edges = read(self._mesh.edges, "vertices", 2, np.int32)
        if name == POINTINESS:
            values = pointiness(self.positions, read(self._mesh.vertex_normals, "vector", 3), edges)
        else:
            values = island_random(len(self.positions), edges)
        rgba = np.ones((len(values), 4), np.float32)
        rgba[:, :3] = values[:, None]
        return rgba[self.triangles]

    def _read_attribute(self, attribute):
        """Returns (T, 3, 4) float32: numbers repeated over RGB, vectors padded with 0, alpha 1 where
        absent."""
        if attribute.data_type not in ATTRIBUTE_READERS:
            return np.zeros((*self.triangles.shape, 4), np.float32)
        name, components, dtype = ATTRIBUTE_READERS[attribute.data_type]
        values = read(attribute.data, name, components, dtype).astype(np.float32).reshape(-1, components)
        padded = np.zeros((len(values), 4), np.float32)
        padded[:, 3] = 1.0
        padded[:, : 3 if components == 1 else components] = values
        places = {"POINT": self.triangles, "CORNER": self._corners, "FACE": None}.get(attribute.domain)
        if places is None:
            if attribute.domain != "FACE":
                return np.zeros((*self.triangles.shape, 4), np.float32)
            return np.repeat(padded[self._polygon_index][:, None], 3, axis=1)
        return padded[places]

    def finish(self):
        """Returns the description.Mesh."""
        low, size = _generated_box(self._mesh)
        return description.Mesh(
            name=self.name,
            positions=self.positions,
            triangles=self.triangles,
            corner_normals=self.corner_normals,
            uvs=_numbered(self._uvs, (*self.triangles.shape, 2)),
            attributes=_numbered(self._attributes, (*self.triangles.shape, 4)),
            material_index=self.material_index,
            generated_min=low,
            generated_size=size,
        )


def _numbered(layers, shape):
    """Returns the layers as a tuple by number; zeros where the mesh lacks one."""
    if not layers:
        return ()
    absent = np.zeros(shape, np.float32) if len(layers) <= max(layers) else None
    return tuple(layers.get(number, absent) for number in range(max(layers) + 1))


def _generated_box(mesh):
    """Returns (min, size) of the texture space, which generated coordinates map to [0, 1]^3."""
    center, half = np.array(mesh.texspace_location), np.array(mesh.texspace_size)
    return tuple(float(v) for v in center - half), tuple(float(v) for v in 2 * half)
