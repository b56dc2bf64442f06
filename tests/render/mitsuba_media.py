# SPDX-License-Identifier: GPL-3.0-or-later
"""Media of Mitsuba's grid volumes as VDB files. Its voxels have their centres at (i + 0.5) / resolution of
the grid's box, its filter is trilinear, clamped at the border, and its medium ends at its box and at the mesh
around it."""

import numpy as np
import scipy.ndimage
from assembler import Code, inside_box
from nephele import description as d


def written(openvdb, path, values, origin, voxel):
    """Writes a grid "sigma_t" of `values` (x, y, z) or (x, y, z, 3), cubic voxels, the first one's centre at
    `origin`, world space."""
    grid = openvdb.FloatGrid() if values.ndim == 3 else openvdb.Vec3SGrid()
    grid.name = "sigma_t"
    grid.copyFromArray(np.ascontiguousarray(values))
    matrix = np.diag([voxel, voxel, voxel, 1.0])
    matrix[3, :3] = origin  # OpenVDB's vectors are rows
    grid.transform = openvdb.createLinearTransform(matrix.tolist())
    openvdb.write(str(path), [grid])


def sampled(grid, index):
    """Returns the clamped trilinear values of a grid (x, y, z, channels) at voxel coordinates index[axis]."""
    points = np.meshgrid(*index, indexing="ij")
    channels = [
        scipy.ndimage.map_coordinates(c, points, order=1, mode="nearest") for c in np.moveaxis(grid, 3, 0)
    ]
    return np.stack(channels, -1).astype(np.float32)


def scaled_density(openvdb, path, refinement=9):
    """Returns a grid_medium for grids of numbers: constants times the density of a grid of smaller voxels
    that ends with the medium. The filter spreads that end over one of them; the voxels are small for that,
    and odd many to one of the file's, so that its values stay where they are."""

    def medium(grid, scale, albedo):
        voxel = grid.size / grid.values.shape[0] / refinement
        begin, end = (np.rint((corner - grid.origin) / voxel).astype(int) for corner in (grid.low, grid.high))
        index = [(np.arange(b, e) + 0.5) / refinement - 0.5 for b, e in zip(begin, end, strict=True)]
        values = sampled(grid.values, index)[..., 0]
        written(openvdb, path, values, grid.origin + (begin + 0.5) * voxel, voxel)
        sigma_s, sigma_a = (tuple(scale * a) for a in (albedo, 1 - albedo))
        return path, d.VolumeClosure(sigma_s, sigma_a, density_grid="sigma_t")

    return medium


def colored(openvdb, path, pad=2):
    """Returns a grid_medium for all grids: a program that reads the grid and cuts it off where the medium
    ends."""

    def medium(grid, scale, albedo):
        voxel = grid.size / grid.values.shape[0]
        values = sampled(grid.values, [np.arange(-pad, n + pad) for n in grid.values.shape[:3]])
        values = values if values.shape[-1] == 3 else values[..., 0]
        written(openvdb, path, values, grid.origin + (0.5 - pad) * voxel, voxel)
        code = Code()
        sigma_t = code.run("grid", code.run("position"), mode=0)
        sigma_t = code.run("multiply", sigma_t, inside_box(code, grid.low, grid.high))
        sigma_s = code.run("multiply", sigma_t, code.constant(scale * albedo))
        sigma_a = code.run("multiply", sigma_t, code.constant(scale * (1 - albedo)))
        none = code.constant(0)
        program = code.program(("medium", 0, sigma_s, sigma_a, none, none, none))
        return path, d.VolumeClosure(program=program, grids=("sigma_t",))

    return medium
