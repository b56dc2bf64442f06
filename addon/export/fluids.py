# SPDX-License-Identifier: GPL-3.0-or-later
"""Gas domains of Blender's fluid simulation: the VDB files of their cache placed in the world.

A cache file has world-sized voxels (the object's own scale is in them) without place: cell i's value stands
at i voxels, and its centre is at i + 1/2 voxels from the corner of the domain's bounding box. Velocities are
in cells per unit of Mantaflow's time, 0.1 of which pass in 1/25 s. Caches of adaptive domains hold a part
of the cells, which changes from frame to frame (fluid_cells.py).
"""

from pathlib import Path

import bpy
import numpy as np

from .. import description, vdb_info
from ..errors import InputError
from .context import ExportError
from .fluid_cells import adapted_cells, whole_domain
from .hash import random_number
from .motion import frames_per_second, is_blurred
from .space import matrix4, scaling, translation
from .temporary import temporary_vdb
from .volume_grids import domain_grids

MANTA_TIME_PER_SECOND = 2.5
NOISE_SUFFIX = "_noise"  # of the names of the high-resolution grids


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
    no file. Raises ExportError where its high-resolution grids cannot be brought together with the others, or
    it is not known which cells an adaptive domain's cache holds."""
    item, frame = instance.object, _cache_frame(settings, context.scene.frame_current)
    path = _cache_file(settings, "data", frame, "vdb")
    if not path.is_file():
        context.warn(
            f"fluid domain '{item.name}': no cache of frame {frame} ('{path}'); it is left out. Bake "
            "the fluid"
        )
        return None
    if settings.use_adaptive_domain:
        cells = adapted_cells(_cache_file(settings, "config", frame, "uni"), item.name)
    else:
        cells = whole_domain(item, settings.resolution_max)
    voxel, file_voxel = cells.voxel(_scale(item)), cells.file_voxel(_scale(item))
    noise = _cache_file(settings, "noise", frame, "vdb") if settings.use_noise else None
    if noise is not None and not noise.is_file():
        context.warn(
            f"fluid domain '{item.name}': no noise cache of frame {frame} ('{noise}'); the base is used. "
            "Bake the noise"
        )
        noise = None
    file = (
        str(path.resolve())
        if noise is None
        else _with_noise(context.cache, item, path, noise, file_voxel, settings.noise_scale)
    )
    size = cells.size * _scale(item) / voxel * file_voxel
    return description.Volume(
        name=item.name,
        path=file,
        world_from_object=matrix4(instance.matrix_world) @ object_from_cache(cells, _scale(item)),
        material=context.material_number(material, domain_grids(settings))[0],
        visibility=visibility,
        clipping=settings.clipping,
        velocity_grids=("velocity",) if is_blurred(context, instance) else (),
        velocity_scale=_velocity_scale(settings, file_voxel, context.scene.render),
        generated_min=tuple((-(cells.first + 0.5) * file_voxel).tolist()),
        generated_size=tuple(np.maximum(size, 1e-12).tolist()),
        random=random_number(instance),
        color=tuple(item.color),
        pass_index=item.pass_index,
    )


def _cache_file(settings, kind, frame, suffix):
    """Returns the path of the cache's file of that kind ("data", "noise" or "config")."""
    prefix = "" if kind == "config" else "fluid_"
    return Path(bpy.path.abspath(settings.cache_directory), kind, f"{prefix}{kind}_{frame:04d}.{suffix}")


def _cache_frame(settings, frame):
    """Returns the frame of the cache files shown at scene frame `frame`."""
    return frame if settings.cache_type == "REPLAY" else frame - settings.cache_frame_offset


def _velocity_scale(settings, voxel, render):
    """Returns voxels of the file's size, in m per frame, of one cell per unit of Mantaflow's time."""
    time_per_frame = MANTA_TIME_PER_SECOND * settings.time_scale / frames_per_second(render)
    return float(settings.velocity_scale * voxel * time_per_frame)


def _scale(item):
    return np.maximum(np.abs(np.array(item.scale)), 1e-12)


def object_from_cache(cells, scale):
    """Returns (4, 4), from the cache file's space to the domain object's. scale: (3,) of the object."""
    voxel = cells.voxel(scale)
    in_cells = scaling(np.full(3, voxel / cells.file_voxel(scale)))
    return translation(cells.low) @ scaling(1 / scale) @ translation((cells.first + 0.5) * voxel) @ in_cells


def _with_noise(cache, item, base, noise, voxel, noise_scale):
    """Returns the path of a temporary VDB file: the grids of file `noise` under the names that shaders know,
    and those of file `base` (velocity, temperature, ...) that the noise does not refine. It is that of the
    last export while both files are the same."""
    try:
        openvdb = vdb_info.module()
    except InputError as error:
        raise ExportError(
            f"fluid domain '{item.name}': its noise cannot be brought together with the base: "
            f"{error}, or disable the domain's noise"
        ) from error
    key = (*(state for file in (base, noise) for state in _state(file)), voxel, noise_scale)
    if (known := cache.files.get(key)) is not None:
        return cache.files.put(key, known)
    path = temporary_vdb()
    try:
        fine, _ = openvdb.readAll(str(noise))
        coarse, _ = openvdb.readAll(str(base))
        fine = [grid for grid in fine if grid.name.endswith(NOISE_SUFFIX)]
        for grid in fine:
            grid.name = grid.name.removesuffix(NOISE_SUFFIX)
            # A cell's centre is half a voxel of its own from the corner, not half of the base's.
            grid.transform.postTranslate((voxel / noise_scale / 2 - voxel / 2,) * 3)
        names = {grid.name for grid in fine}
        openvdb.write(path, grids=fine + [grid for grid in coarse if grid.name not in names])
    except (OSError, RuntimeError, LookupError, TypeError) as error:
        raise ExportError(
            f"fluid domain '{item.name}': {base} and {noise} cannot be brought together "
            f"({' '.join(str(error).split())}); bake the fluid again, or disable its noise"
        ) from error
    return cache.files.put(key, path)


def _state(file):
    """Returns what changes with the content of a file."""
    state = file.stat()
    return str(file), state.st_mtime_ns, state.st_size, state.st_ino
