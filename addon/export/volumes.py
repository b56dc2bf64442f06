# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects: VDB files placed in the world."""

from pathlib import Path

import bpy
import numpy as np

from .. import description
from .context import ExportError
from .hash import random_number
from .motion import is_blurred, velocity_grids, velocity_scale
from .space import matrix4
from .temporary import temporary_vdb
from .volume_grids import volume_grids

PRECISIONS = {"FULL": "full", "HALF": "half", "VARIABLE": "file"}


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
    saved = changed or not data.filepath
    if saved:
        item = source or instance.object
        path = context.cache.file(item, own=source is not None, make=lambda: _saved(name, data))
    else:
        path = str(Path(bpy.path.abspath(data.grids.frame_filepath)).resolve())
    world_from_object = matrix4(instance.matrix_world)
    low, high = bounds(instance.object)
    velocity = velocity_grids(data) if is_blurred(context, instance) else ()
    return description.Volume(
        name=name,
        path=path,
        world_from_object=world_from_object,
        material=context.material_number(material, volume_grids(data))[0],
        density_scale=density_scale(data.render.space, world_from_object),
        visibility=visibility,
        clipping=data.render.clipping,
        precision=PRECISIONS[data.render.precision],
        velocity_grids=velocity,
        velocity_scale=velocity_scale(data, context.scene.render) if velocity else 0.0,
        generated_min=tuple(low.tolist()),
        generated_size=tuple(np.maximum(high - low, 1e-12).tolist()),
        random=random_number(instance),
        color=tuple(instance.object.color),
        pass_index=instance.object.pass_index,
    )


def bounds(item):
    """Returns (low, high), (3,) each: the box of an object's volume in its own space, out to the
    leaves of 8^3 voxels, as Blender measures it."""
    corners = np.array(item.bound_box)
    return corners.min(axis=0), corners.max(axis=0)


def _saved(name, data):
    """Returns the path of a new temporary VDB file with the volume's grids."""
    path = temporary_vdb()
    if not data.grids.save(filepath=path):
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
