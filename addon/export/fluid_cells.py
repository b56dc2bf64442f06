# SPDX-License-Identifier: GPL-3.0-or-later
"""Which cells of a fluid domain its cache holds at a frame.

An adaptive domain keeps those around the gas alone. Its VDB files do not say where they are, and their
voxels are scaled as if the part were the whole: the longest side of the domain is divided by the most cells
of the part. Mantaflow's state beside each frame tells (config/config_0001.uni: numbers, little-endian,
gzipped).
"""

import gzip
import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .context import ExportError

# Grids in use; cells of the part; cell's edge, time step; the domain's box in the object's space: low, high,
# low at the start; shift in cells and its rest; object's matrix; cells of the whole; first cell of the part
# and the one after its last; colour; time; version.
STATE = struct.Struct("<i 3i 2f 3f 3f 3f 3i 3f 16f 3i 3i 3i 3f f 4s")


@dataclass(frozen=True)
class Cells:
    """low, size: (3,) box of the domain in its object's space. whole: cells of the domain along each axis.
    first, count: (3,) those of the cache."""

    low: np.ndarray
    size: np.ndarray
    whole: np.ndarray
    first: np.ndarray
    count: np.ndarray

    def voxel(self, scale):
        """Returns the edge of a cell, m; scale: (3,) of the object."""
        return float(np.max(self.size * scale) / self.whole.max())

    def file_voxel(self, scale):
        """Returns what the cache's files call the edge of a cell."""
        return float(np.max(self.size * scale) / self.count.max())


def whole_domain(item, resolution_max):
    """Returns the Cells of a domain object whose cache holds all."""
    box = np.array(item.bound_box)
    longest = np.full(3, resolution_max)  # of the shorter sides nothing is asked
    return Cells(box.min(axis=0), np.ptp(box, axis=0), longest, np.zeros(3), longest)


def adapted_cells(path, name):
    """Returns the Cells that an adaptive domain's state file tells. Raises ExportError, naming the domain
    `name`, where it cannot be read."""
    try:
        state = STATE.unpack(gzip.decompress(Path(path).read_bytes()))
        low, high = np.array(state[6:9]), np.array(state[9:12])
        whole, first, end = (np.array(state[k : k + 3]) for k in (37, 40, 43))
        count = end - first
        if (count < 1).any() or (count != state[1:4]).any() or (first < 0).any() or (end > whole).any():
            raise ValueError("its cells are no part of the domain's")
    except (OSError, EOFError, ValueError, struct.error, zlib.error) as error:
        raise ExportError(
            f"fluid domain '{name}': {path} does not tell which cells of the adaptive domain the frame holds "
            f"({error}); bake the fluid again, or bake it without Adaptive Domain"
        ) from error
    return Cells(low, high - low, whole, first, count)
