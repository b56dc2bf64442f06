# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair curves, particle hair and point clouds: Blender's data to the description.Mesh of their tubes and
balls.

A record of them has the interface of MeshRecord, so that materials, attributes and motion are as of meshes.
What Curves Info and Point Info tell are attributes that are computed here."""

import numpy as np

from .hash import hash_pair
from .mesh import ATTRIBUTE_READERS, MeshArrays, MeshRecord, read
from .properties import STRAND
from .strands import balls, tubes

DEFAULT_HAIR_RADIUS, DEFAULT_POINT_RADIUS = 0.005, 0.01  # m, as in Blender, where no attribute says otherwise
STRAIGHT = "THICK_LINEAR"


class Source:
    """What is drawn as round shapes. shape: strands.Tessellation. points: (n, 3). radius: (n,) m. ends:
    offsets of the strands' first points and the end, None for points. uvs: name -> (parts, 2). attributes:
    name -> ((k, 4), whether they are of points)."""

    def __init__(self, shape, points, radius, ends=None, uvs=None, attributes=None):
        self.shape, self.points, self.radius, self.ends = shape, points, radius, ends
        self.uvs, self.attributes = uvs or {}, attributes or {}


def steps_of(scene):
    """Returns the pieces that strands have between two keys: a setting that Cycles adds to scenes."""
    settings = getattr(scene, "cycles_curves", None)
    if getattr(settings, "shape", "") == STRAIGHT:
        return 1
    return 2 ** min(max(int(getattr(settings, "subdivisions", 2)), 1), 4)


def curves_source(data, scene):
    """Returns the Source of Blender's hair curves, evaluated."""
    if len(data.curves) == 0:
        return Source(
            tubes(np.zeros((0, 3)), np.zeros(0), np.zeros(1, int), 1), np.zeros((0, 3)), np.zeros(0)
        )
    ends = read(data.curve_offset_data, "value", 1, np.int32)
    positions = read(data.attributes["position"].data, "vector", 3)
    radius = _radius(data, len(positions), DEFAULT_HAIR_RADIUS)
    attributes = _attributes(data)
    uvs = {}
    for attribute in data.attributes:
        if attribute.data_type == "FLOAT2" and attribute.domain == "CURVE":
            uvs[attribute.name] = read(attribute.data, "vector", 2)
    surface = uvs.get(data.surface_uv_map) if data.surface_uv_map else None
    first = surface if surface is not None else next(iter(uvs.values()), None)
    if first is not None:
        uvs[""] = first
    return Source(tubes(positions, radius, ends, steps_of(scene)), positions, radius, ends, uvs, attributes)


def points_source(data, scene):
    """Returns the Source of Blender's point cloud, evaluated."""
    positions = read(data.attributes["position"].data, "vector", 3)
    radius = _radius(data, len(positions), DEFAULT_POINT_RADIUS)
    return Source(balls(positions, radius), positions, radius, attributes=_attributes(data))


def particle_hair_source(item, system, modifier, depsgraph, scene):
    """Returns the Source of a hair particle system of an evaluated object, in the object's space."""
    settings = system.settings
    final = depsgraph.mode == "RENDER"
    steps = (1 << (settings.render_step if final else settings.display_step)) + 1
    if settings.kink == "SPIRAL":
        steps += settings.kink_extra_steps
    parents, children = len(system.particles), len(system.child_particles)
    without_parents = children > 0 and settings.child_type != "NONE" and not settings.use_parent_particles
    numbers = range(parents if without_parents else 0, parents + children)
    world = np.array([_strand(item, system, number, steps) for number in numbers]).reshape(-1, steps, 3)
    object_from_world = np.linalg.inv(np.array(item.matrix_world, np.float64))
    keys = world @ object_from_world[:3, :3].T + object_from_world[:3, 3]
    radius = _hair_radius(settings, keys)
    ends = np.arange(len(keys) + 1) * steps
    uvs = {}
    layer = item.data.uv_layers.active_index if len(item.data.uv_layers) else -1
    if layer >= 0:
        uvs[""] = np.array([_uv(system, modifier, number, parents, layer) for number in numbers]).reshape(
            -1, 2
        )
        uvs[item.data.uv_layers[layer].name] = uvs[""]
    points, radius = keys.reshape(-1, 3), radius.ravel()
    return Source(tubes(points, radius, ends, steps_of(scene)), points, radius, ends, uvs)


def _strand(item, system, number, steps):
    return [tuple(system.co_hair(item, particle_no=number, step=step)) for step in range(steps)]


def _uv(system, modifier, number, parents, layer):
    particle = system.particles[number] if number < parents else system.particles[0]
    return tuple(system.uv_on_emitter(modifier, particle=particle, particle_no=number, uv_no=layer))


def _hair_radius(settings, keys):
    """Returns (strands, keys) radii: from that of the root to that of the tip, by the settings' shape."""
    along = np.linalg.norm(np.diff(keys, axis=1), axis=2).cumsum(axis=1)
    place = np.concatenate((np.zeros((len(keys), 1)), along), axis=1)
    left = 1 - place / np.maximum(place[:, -1:], 1e-20)
    shape = settings.shape
    left = left ** ((1 + shape) if shape < 0 else 1 / max(1 - shape, 1e-6))
    scale = 0.5 * settings.radius_scale
    radius = scale * (settings.tip_radius + (settings.root_radius - settings.tip_radius) * left)
    if settings.use_close_tip:
        radius[:, -1] = 0.0
    return radius


def _radius(data, count, default):
    attribute = data.attributes.get("radius")
    if attribute is None or attribute.domain != "POINT" or attribute.data_type != "FLOAT":
        return np.full(count, default, np.float32)
    return read(attribute.data, "value", 1)


def _attributes(data):
    """Returns the attributes of curves or points as (n, 4), and whether they are of points."""
    found = {}
    for attribute in data.attributes:
        if attribute.data_type not in ATTRIBUTE_READERS or attribute.name.startswith("."):
            continue
        name, components, dtype = ATTRIBUTE_READERS[attribute.data_type]
        values = read(attribute.data, name, components, dtype).astype(np.float32).reshape(-1, components)
        found[attribute.name] = padded(values), attribute.domain == "POINT"
    return found


def padded(values):
    """Returns (n, 4): numbers repeated over RGB, vectors padded with 0, alpha 1 where absent."""
    out = np.zeros((len(values), 4), np.float32)
    out[:, 3] = 1.0
    out[:, : 3 if values.shape[1] == 1 else values.shape[1]] = values
    return out


class RoundRecord(MeshRecord):
    """A MeshRecord of a Source. again: function of the evaluated data that returns their Source at another
    time, or None where they keep their shape."""

    def __init__(self, name, source, before=None, again=None):
        self._source, self._again = source, again
        super().__init__(name, None, None, before)

    def _read(self, before):
        arrays, shape = MeshArrays(), self._source.shape
        arrays.take("positions", shape.positions.astype(np.float32), before)
        arrays.take("triangles", shape.triangles.astype(np.int32), before)
        arrays.corner_count = 3 * len(shape.triangles)
        return arrays

    @property
    def corners(self):
        return None

    def _require_normals(self):
        self._has_surface = True
        if not self.arrays.has_normals:
            normals = self._source.shape.normals.astype(np.float32)[self.arrays.triangles]
            self.arrays.take("corner_normals", normals, self._before)
            self.arrays.has_normals = True

    def shape_of(self, data):
        if self._again is None:
            return None
        shape = self._again(data).shape
        if len(shape.positions) != len(self.arrays.positions):
            return None
        normals = shape.normals.astype(np.float32)[self.arrays.triangles]
        return shape.positions.astype(np.float32), normals if self.arrays.corner_normals is not None else None

    def _require_uv(self, name):
        if name not in self._source.uvs:
            return None
        values = self._source.shape.at_parts(self._source.uvs[name]).astype(np.float32)
        return self._layer("uvs", name, lambda: values[self.arrays.triangles])

    def _require_attribute(self, name):
        values = self._info(name) if name in STRAND else self._attribute(name)
        if values is None:
            return None
        return self._layer("attributes", name, lambda: values.astype(np.float32)[self.arrays.triangles])

    def _attribute(self, name):
        found = self._source.attributes.get(name)
        if found is None:
            return None
        values, of_points = found
        return self._source.shape.at_points(values) if of_points else self._source.shape.at_parts(values)

    def _info(self, name):
        """Returns (N, 4) of an output of Curves Info or Point Info."""
        source, shape = self._source, self._source.shape
        what, strands = STRAND[name], source.ends is not None
        if what == "Is Strand":
            return padded(np.full((len(shape.part), 1), float(strands)))
        if what == "Thickness":
            return padded(shape.at_points(2 * source.radius[:, None]))
        if what == "Radius":
            return padded(shape.at_points(source.radius[:, None]))
        parts = int(shape.part.max(initial=-1)) + 1
        if what == "Random":
            numbers = np.array([hash_pair(part, 0) / 0xFFFFFFFF for part in range(parts)])
            return padded(shape.at_parts(numbers[:, None]))
        if what == "Position":
            return padded(shape.at_points(source.points))
        if not strands:
            return None
        if what == "Length":
            return padded(shape.at_parts(self._lengths()[:, None]))
        first = source.ends[shape.part]
        count = source.ends[shape.part + 1] - first
        return padded((((shape.key - first) + shape.fraction) / np.maximum(count - 1, 1))[:, None])

    def _lengths(self):
        ends = self._source.ends
        steps = np.linalg.norm(np.diff(self._source.points, axis=0), axis=1)
        far = np.concatenate(([0.0], np.cumsum(steps)))
        return far[np.maximum(ends[1:] - 1, ends[:-1])] - far[ends[:-1]]

    def used_slots(self, count):
        return {0}

    def _box(self):
        """Returns (min, size) of the box of generated coordinates."""
        positions = self.arrays.positions
        if len(positions) == 0:
            return (0.0,) * 3, (1.0,) * 3
        low, high = positions.min(axis=0), positions.max(axis=0)
        return tuple(map(float, low)), tuple(map(float, np.maximum(high - low, 1e-6)))
