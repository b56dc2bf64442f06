# SPDX-License-Identifier: GPL-3.0-or-later
"""Shapes of the suite's scenes: turned bodies, true spheres, leaves, and many copies of a mesh."""

import bpy
import common
import numpy as np
from mathutils import Matrix, Vector

SHARP_DEGREES = 40.0  # edges bent by more are not smoothed over


def polygon_mesh(name, vertices, faces, smooth=True):
    """Mesh of faces with any number of corners, smooth but for sharp edges."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, float).tolist(), [], [tuple(map(int, face)) for face in faces])
    if smooth:
        mesh.shade_smooth()
        mesh.set_sharp_from_angle(angle=np.radians(SHARP_DEGREES))
    return mesh


def lathe_mesh(name, profile, segments=32):
    """Body turned about z from (radius, height) pairs, upwards; radius 0 at an end closes it there, and the
    first pair again at the end makes a ring."""
    ring = profile[0] == profile[-1]
    profile = profile[:-1] if ring else profile
    phi = 2 * np.pi * np.arange(segments) / segments
    vertices, rows = [], []
    for radius, height in profile:
        count = segments if radius > 0 else 1
        rows.append(len(vertices) + np.arange(segments) % count)
        vertices += [(radius * np.cos(a), radius * np.sin(a), height) for a in phi[:count]]
    faces = []
    for low, high in zip(rows, rows[1:] + rows[:1] if ring else rows[1:], strict=False):
        for i in range(segments):
            j = (i + 1) % segments
            corners = dict.fromkeys((low[i], low[j], high[j], high[i]))  # a pole counts once
            if len(corners) > 2:
                faces.append(tuple(corners))
    return polygon_mesh(name, vertices, faces)


def shared(name, mesh, location, material):
    """Object of a mesh that others have too, each with its own material."""
    if not mesh.materials:
        mesh.materials.append(material)
    ob = common.link(name, mesh, location)
    ob.material_slots[0].link = "OBJECT"
    ob.material_slots[0].material = material
    return ob


def rod(name, start, end, radius, material, taper=1.0):
    """A closed rod between two points; its radius at the end is `taper` times that at the start."""
    kind = f"Rod to {taper:.2f}"
    mesh = bpy.data.meshes.get(kind) or lathe_mesh(kind, [(0, 0), (1, 0), (taper, 1), (0, 1)], 12)
    axis = Vector(end) - Vector(start)
    ob = shared(name, mesh, start, material)
    ob.rotation_euler = axis.to_track_quat("Z", "Y").to_euler()
    ob.scale = (radius, radius, axis.length)
    return ob


def sphere(name, radius, location, material, levels=6):
    """A ball of 6 * 4^levels quads, which modifiers make of a cube: it takes no room in the file."""
    ob = common.link(name, common.box_mesh(name, (-1,) * 3, (1,) * 3), location, material)
    ob.data.shade_smooth()
    subdivide(ob, levels)
    cast = ob.modifiers.new("Cast", "CAST")
    cast.cast_type, cast.factor, cast.size = "SPHERE", 1.0, radius
    cast.use_radius_as_size = False
    return ob


def subdivide(ob, levels, smooth=False):
    """Splits each face into 4^levels, without moving anything unless `smooth`."""
    modifier = ob.modifiers.new("Subdivide", "SUBSURF")
    modifier.subdivision_type = "CATMULL_CLARK" if smooth else "SIMPLE"
    modifier.levels = modifier.render_levels = levels
    return ob


def blades(widths, transforms):
    """Vertices and quads of leaves folded along their middle. widths: half-widths along the leaf, which lies
    on +x from 0 to 1; transforms: arrays (N, 3) -> (N, 3), one per leaf."""
    along = np.linspace(0, 1, len(widths))
    vertices, quads = [], []
    for transform in transforms:
        first = sum(map(len, vertices))
        rows = [
            (x, side * w, 0.35 * w * abs(side))
            for x, w in zip(along, widths, strict=True)
            for side in (-1, 0, 1)
        ]
        vertices.append(transform(np.array(rows)))
        for row in range(len(widths) - 1):
            for column in (0, 1):
                a = first + 3 * row + column
                quads.append((a, a + 3, a + 4, a + 1))
    return np.concatenate(vertices), quads


def arching(length, lift, droop, yaw, root=(0, 0, 0)):
    """A transform for `blades`: rises at `lift` radians, bends down by `droop`, turned by `yaw`."""

    def transform(p):
        angle = lift - droop * p[:, 0]
        # The middle line is the integral of its direction, in closed form where it does bend.
        bend = droop if abs(droop) > 1e-6 else 1e-6
        x = length * (np.sin(lift) - np.sin(angle)) / bend - length * p[:, 2] * np.sin(angle)
        z = length * (np.cos(angle) - np.cos(lift)) / bend + length * p[:, 2] * np.cos(angle)
        y = length * p[:, 1]
        turned = np.stack([x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw), z], axis=1)
        return turned + np.asarray(root)

    return transform


def scatter(name, child, places, normals, yaws, scales):
    """Instances of the object `child`: one on each face of a parent that is not rendered itself. places,
    normals: (N, 3); yaws about the normal in radians; scales of the child."""
    phi = 2 * np.pi * np.arange(3) / 3
    corners = np.stack([np.cos(phi), np.sin(phi), 0 * phi], axis=1) * (4 / np.sqrt(27)) ** 0.5  # of area 1
    vertices = []
    for place, normal, yaw, scale in zip(places, normals, yaws, scales, strict=True):
        turn = Vector(normal).to_track_quat("Z", "Y").to_matrix() @ Matrix.Rotation(yaw, 3, "Z")
        vertices.append(np.asarray(place) + scale * corners @ np.array(turn).T)
    faces = np.arange(3 * len(places)).reshape(-1, 3)
    rounded = np.round(np.concatenate(vertices) * 512) / 512  # fewer bits pack into smaller files
    parent = common.link(name, common.mesh_from_arrays(name, rounded, faces))
    parent.instance_type, parent.use_instance_faces_scale = "FACES", True
    parent.show_instancer_for_render = parent.show_instancer_for_viewport = False
    child.parent = parent
    return parent
