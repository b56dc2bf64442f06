# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects and fluid domains: VDB files placed in the world."""

import os
import tempfile
import weakref
from pathlib import Path

import bpy
import numpy as np

from .. import description
from .context import ExportError
from .space import matrix4, scaling, translation
from .volume_grids import domain_grids, volume_grids


def export_volume(context, instance, source, material, visibility):
    """Returns the description.Volume of an instance of a Volume object, or None for one that is empty at this
    frame.

    source: the object that owns the data, or None for data made by Geometry Nodes. material: Blender's.
    Raises ExportError where its file cannot be read.
    """
    name, data = instance.object.name, instance.object.data
    if data.is_sequence and _outside_sequence(data, context.scene.frame_current):
        return None
    changed = source is None or any(m.show_render or m.show_viewport for m in source.modifiers)
    if not data.filepath and not changed:
        context.warn(f"volume '{name}': it has no file; it is left out")
        return None
    if not data.grids.load():
        path = data.grids.frame_filepath or bpy.path.abspath(data.filepath)
        reason = data.grids.error_message or "it holds no grid"
        raise ExportError(f"volume '{name}': {path} cannot be read ({reason}); check its path and the frame")
    temporary = changed or not data.filepath
    path = (
        _saved(name, data) if temporary else str(Path(bpy.path.abspath(data.grids.frame_filepath)).resolve())
    )
    world_from_object = matrix4(instance.matrix_world)
    volume = description.Volume(
        name=name,
        path=path,
        world_from_object=world_from_object,
        material=context.material_number(material, volume_grids(data))[0],
        density_scale=density_scale(data.render.space, world_from_object),
        visibility=visibility,
    )
    if temporary:  # the file lives as long as the description that names it
        weakref.finalize(volume, Path(path).unlink, missing_ok=True)
    return volume


def _absolute(path):
    """Returns Blender's `path` (which may start with //) as an absolute one."""
    return str(Path(bpy.path.abspath(path)).resolve())


def _saved(name, data):
    """Returns the path of a new temporary VDB file with the volume's grids."""
    handle, path = tempfile.mkstemp(prefix="nephele_", suffix=".vdb", dir=bpy.app.tempdir or None)
    os.close(handle)
    if not data.grids.save(filepath=path):
        Path(path).unlink()
        raise ExportError(f"volume '{name}': its grids cannot be saved to {path}; check the space left there")
    return path


def density_scale(space, world_from_object):
    """Returns what density is multiplied by: in object space one over the length of the object's unit
    diagonal in the world, as in Cycles, so that scaling an object leaves its optical thickness."""
    if space != "OBJECT":
        return 1.0
    length = np.linalg.norm(world_from_object[:3, :3] @ np.full(3, 3**-0.5))
    return float(1.0 / length) if length > 0 else 1.0


def _outside_sequence(data, frame):
    """True on frames where a clipped sequence shows nothing."""
    first = data.frame_start
    return data.sequence_mode == "CLIP" and not first <= frame < first + data.frame_duration


def fluid_domain(item):
    """Returns the domain settings of a gas domain object, or None."""
    for modifier in item.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN":
            settings = modifier.domain_settings
            if settings is not None and settings.domain_type == "GAS":
                return settings
    return None


def export_fluid(context, instance, settings, material, visibility):
    """Returns the description.Volume of a gas domain at this frame; None, with a warning, where its cache has
    no file. material: Blender's."""
    item, frame = instance.object, _cache_frame(settings, context.scene.frame_current)
    path = Path(bpy.path.abspath(settings.cache_directory), "data", f"fluid_data_{frame:04d}.vdb")
    if not path.is_file():
        context.warn(
            f"fluid domain '{item.name}': no cache of frame {frame} ('{path}'); it is left out. Bake "
            "the fluid"
        )
        return None
    if settings.use_noise:
        context.warn(
            f"fluid domain '{item.name}': the noise (high resolution) cache is not supported; the "
            "base is used"
        )
    if settings.use_adaptive_domain:
        context.warn(
            f"fluid domain '{item.name}': adaptive domains are not supported; the gas may be out of place"
        )
    return description.Volume(
        name=item.name,
        path=str(path.resolve()),
        world_from_object=matrix4(instance.matrix_world) @ object_from_cache(item, settings.resolution_max),
        material=context.material_number(material, domain_grids(settings))[0],
        visibility=visibility,
    )


def _cache_frame(settings, frame):
    """Returns the frame of the cache files shown at scene frame `frame`."""
    return frame if settings.cache_type == "REPLAY" else frame - settings.cache_frame_offset


def object_from_cache(item, resolution_max):
    """Returns (4, 4), from the cache file's space to the domain object's.

    The file has world-sized voxels (the object's own scale is in them) without place: cell i's value stands
    at i voxels, and its centre is at i + 1/2 voxels from the corner of the domain's bounding box.
    """
    corners = np.array(item.bound_box)
    low, size = corners.min(axis=0), np.ptp(corners, axis=0)
    scale = np.maximum(np.abs(np.array(item.scale)), 1e-12)
    voxel = np.max(size * scale) / resolution_max
    return translation(low) @ scaling(1 / scale) @ translation(np.full(3, voxel / 2))
