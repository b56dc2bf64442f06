# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scripts of the bundled scenes share: an empty scene, its objects and lights, VDB files.

Run a scene's `make.py` with a Python that has the bpy module (5.0 or newer), e.g.

    .venv/bin/python blend_scenes/cloud/make.py

Lengths are metres, z is up. A scene is saved for Cycles, so that any Blender shows the same picture
without this project; the command line and F12 choose the engine themselves.
"""

import hashlib
import sys
import uuid
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

_PYTHON = f"python{sys.version_info.major}.{sys.version_info.minor}"
sys.path.append(str(Path(bpy.utils.resource_path("LOCAL"), "python", "lib", _PYTHON, "site-packages")))
import openvdb  # noqa: E402  Blender's own copy, found only through the path above

# ---------------------------------------------------------------------------------------- scene and files


def new_scene(resolution, samples, bounces=16, pixel_filter="BOX", view_transform="Standard"):
    """Empty everything and return a scene whose path tracing settings cut no corners.

    `resolution` is (width, height) in pixels. Clamping, light thresholds, adaptive sampling, filtered
    caustics and denoising are off, so that a converged picture is the transport equation's solution up
    to `bounces` scattering events of any kind.
    """
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = resolution
    render.resolution_percentage = 100
    render.image_settings.file_format = "PNG"
    scene.display_settings.display_device = "sRGB"
    scene.view_settings.view_transform = view_transform

    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = samples
    cycles.seed = 0
    for name in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, f"{name}_bounces", bounces)
    cycles.transparent_max_bounces = max(bounces, 64)  # a volume's boundary counts as transparent there
    cycles.volume_biased = False
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.use_light_tree = False
    cycles.use_auto_tile = False
    cycles.light_sampling_threshold = 0.0
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.caustics_reflective = True
    cycles.caustics_refractive = True
    cycles.blur_glossy = 0.0
    cycles.film_exposure = 1.0
    cycles.pixel_filter_type = pixel_filter
    cycles.filter_width = 1.5
    return scene


def save(folder, name=None):
    """Write FOLDER/NAME.blend, small (NAME: the folder's own, by default); paths inside it stay relative."""
    path = folder / f"{name or folder.name}.blend"
    bpy.context.preferences.filepaths.save_version = 0
    bpy.ops.wm.save_as_mainfile(filepath=str(path), compress=True, relative_remap=False)
    return path


def write_vdb(path, arrays, voxel_size, origin, tolerance=0.0):
    """Write float arrays {name: (X, Y, Z) or (X, Y, Z, 3)} as sparse fog volumes, stored as half floats.

    `voxel_size` in metres; `origin` (3,) is the centre of voxel (0, 0, 0) in object space. Values within
    `tolerance` of 0 become inactive background.
    """
    grids = []
    for name, array in arrays.items():
        vectors = array.ndim == 4
        grid = openvdb.Vec3SGrid(background=(0.0,) * 3) if vectors else openvdb.FloatGrid(background=0.0)
        least = (tolerance,) * 3 if vectors else tolerance
        grid.copyFromArray(np.ascontiguousarray(array, np.float32), tolerance=least)
        grid.name = name
        grid.gridClass = openvdb.GridClass.FOG_VOLUME
        grid.saveFloatAsHalf = True
        grid.transform = openvdb.createLinearTransform(voxelSize=voxel_size)
        grid.transform.postTranslate(tuple(float(c) for c in origin))
        grids.append(grid)
    openvdb.write(str(path), grids=grids)
    _fix_identity(path)


def _fix_identity(path):
    """Replace the random UUID in a VDB file's header by one made from its contents: same data, same bytes.

    The header is magic (8 bytes), file version, library version (4 + 8), a flag (1), then the UUID as text.
    """
    with path.open("r+b") as file:
        file.seek(21 + 36)
        digest = hashlib.sha256(file.read()).digest()
        file.seek(21)
        file.write(str(uuid.UUID(bytes=digest[:16], version=4)).encode("ascii"))


def quantise(array, levels):
    """Round to multiples of 1/levels: fewer distinct half floats pack into smaller files."""
    return np.round(np.asarray(array, np.float32) * levels) / np.float32(levels)


# ------------------------------------------------------------------------------------- objects and lights


def link(name, data, location=(0, 0, 0), material=None):
    """Put a datablock into the scene as an object, optionally with one material."""
    ob = bpy.data.objects.new(name, data)
    ob.location = location
    bpy.context.scene.collection.objects.link(ob)
    if material is not None:
        data.materials.append(material)
    return ob


def aim(ob, target):
    """Turn a camera or light (which look along -z) at a point."""
    direction = Vector(target) - ob.location
    ob.rotation_euler = direction.to_track_quat("-Z", "Y").to_euler()
    return ob


def add_camera(location, target, lens_mm):
    """Perspective camera, 36 mm sensor, made the scene's own."""
    data = bpy.data.cameras.new("Camera")
    data.lens = lens_mm
    camera = aim(link("Camera", data, location), target)
    bpy.context.scene.camera = camera
    return camera


def add_light(kind, name, location, energy, colour=(1, 1, 1), target=None, **settings):
    """A lamp; `energy` in watts (W/m^2 for a sun); `settings` are attributes of the light datablock."""
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    data.color = colour
    if hasattr(data, "use_soft_falloff"):
        data.use_soft_falloff = False
    for key, value in settings.items():
        setattr(data, key, value)
    ob = link(name, data, location)
    return ob if target is None else aim(ob, target)


def mesh_from_arrays(name, vertices, quads, smooth=False):
    """Mesh from float vertices (V, 3) and integer quads (Q, 4), or triangles."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(np.asarray(vertices, float).tolist(), [], np.asarray(quads, int).tolist())
    if smooth:
        mesh.shade_smooth()
    return mesh


def box_mesh(name, low, high):
    """Axis-aligned box with outward faces between two corners."""
    corners = [[(low, high)[(i >> axis) & 1][axis] for axis in range(3)] for i in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mesh_from_arrays(name, corners, quads)


def sphere_mesh(name, radius, segments=48, rings=24):
    """Smooth latitude-longitude sphere, outward faces, with a UV map (u along longitude, v up)."""
    theta = np.pi * np.arange(rings + 1) / rings  # from the south pole upwards
    phi = 2 * np.pi * np.arange(segments) / segments
    ring = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    belts = [np.column_stack([ring * np.sin(t), np.full(segments, -np.cos(t))]) for t in theta[1:-1]]
    south, north = (rings - 1) * segments, (rings - 1) * segments + 1
    vertices = radius * np.concatenate([*belts, [(0, 0, -1)], [(0, 0, 1)]])

    faces, uvs = [], []
    for row in range(rings):
        v0, v1 = row / rings, (row + 1) / rings
        for i in range(segments):
            j = (i + 1) % segments
            u0, u1 = i / segments, (i + 1) / segments
            low, high = (row - 1) * segments, row * segments
            if row == 0:
                faces.append((south, high + j, high + i))
                uvs += [((u0 + u1) / 2, v0), (u1, v1), (u0, v1)]
            elif row == rings - 1:
                faces.append((low + i, low + j, north))
                uvs += [(u0, v0), (u1, v0), ((u0 + u1) / 2, v1)]
            else:
                faces.append((low + i, low + j, high + j, high + i))
                uvs += [(u0, v0), (u1, v0), (u1, v1), (u0, v1)]

    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices.tolist(), [], faces)
    layer = mesh.uv_layers.new(name="UVMap")
    layer.data.foreach_set("uv", np.asarray(uvs, np.float32).ravel())
    mesh.shade_smooth()
    return mesh


def heightfield_mesh(name, xs, ys, height):
    """Smooth grid of vertices (x, y, height(x, y)) facing up; `height` maps flat arrays to a flat array."""
    x, y = np.meshgrid(xs, ys)
    vertices = np.stack([x.ravel(), y.ravel(), height(x.ravel(), y.ravel())], axis=1)
    index = np.arange(x.size).reshape(x.shape)
    quads = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], axis=-1).reshape(-1, 4)
    return mesh_from_arrays(name, vertices, quads, smooth=True)


def add_volume(name, filepath, material, location=(0, 0, 0)):
    """Volume object on a VDB file given relative to the .blend ('//x.vdb'), at full precision."""
    data = bpy.data.volumes.new(name)
    data.filepath = filepath
    data.render.precision = "FULL"
    data.render.space = "OBJECT"
    data.render.step_size = 0.0
    data.render.clipping = 0.0
    return link(name, data, location, material)
