# SPDX-License-Identifier: GPL-3.0-or-later
"""What a VDB file holds, read from its headers alone by the OpenVDB module in bpy (Blender 4.4 and later)."""

import sys
from pathlib import Path

from .errors import InputError


def grids(path):
    """Returns a list of dict(name, type, active_voxels, resolution (3,)) of the file's grids; None where a
    header does not tell. Raises InputError naming the file."""
    if not Path(path).is_file():
        raise InputError(f"{path}: no such VDB file")
    openvdb = module()
    try:
        found = openvdb.readAllGridMetadata(str(path))
    except (OSError, RuntimeError, LookupError, TypeError) as error:
        raise InputError(f"{path}: not a VDB file, or damaged ({' '.join(str(error).split())})") from error
    return [described(grid) for grid in found]


def module():
    """Returns Blender's openvdb module; raises InputError where this Blender has none."""
    import bpy  # its libraries must be loaded first

    version = ".".join(map(str, sys.version_info[:2]))
    folder = Path(bpy.utils.resource_path("LOCAL")) / f"python/lib/python{version}/site-packages"
    if str(folder) not in sys.path:
        sys.path.append(str(folder))
    try:
        import openvdb
    except ImportError as error:
        raise InputError(
            f"this Blender ({bpy.app.version_string}) brings no OpenVDB for Python; use "
            "blender.org's Blender 4.4 or later"
        ) from error
    return openvdb


def described(grid):
    """Returns the entry of one grid; OpenVDB stores the counts in the file as metadata."""
    metadata = grid.metadata
    low, high = metadata.get("file_bbox_min"), metadata.get("file_bbox_max")
    return {
        "name": grid.name,
        "type": grid.valueTypeName,
        "active_voxels": metadata.get("file_voxel_count"),
        "resolution": [h - l + 1 for l, h in zip(low, high, strict=True)] if low and high else None,
    }
