# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders read of a mesh's shape: pointiness and a random number for each connected part."""

import numpy as np

from .hash import hash_text


def pointiness(positions, normals, edges):
    """Returns (V,) float32: the angle between each vertex's normal and the mean direction of its edges over
    pi, smoothed once over its neighbours; 0.5 where flat. Vertices in the same place count as one.

    positions, normals: (V, 3). edges: (E, 2) vertex numbers."""
    _, first, merged = np.unique(positions, axis=0, return_index=True, return_inverse=True)
    merged = merged.ravel()
    count = len(first)
    normal = _summed(normals, merged, count)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-20)
    pairs = np.unique(np.sort(merged[edges], axis=1), axis=0)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    along = positions[first[pairs[:, 1]]] - positions[first[pairs[:, 0]]]
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-20)
    total = _summed(along, pairs[:, 0], count) - _summed(along, pairs[:, 1], count)
    number = np.bincount(pairs.ravel(), minlength=count)
    mean = total / np.maximum(number, 1)[:, None]
    raw = np.where(number > 0, np.arccos(np.clip((normal * mean).sum(1), -1.0, 1.0)) / np.pi, 0.0)
    smooth = raw.copy()
    np.add.at(smooth, pairs[:, 0], raw[pairs[:, 1]])
    np.add.at(smooth, pairs[:, 1], raw[pairs[:, 0]])
    return (smooth / (number + 1))[merged].astype(np.float32)


def _summed(values, places, count):
    """Returns (count, 3): the sums of `values` at each of `places`."""
    out = np.zeros((count, 3))
    np.add.at(out, places, values)
    return out


def island_random(count, edges):
    """Returns (count,) float32: one number in [0, 1] for each set of vertices that edges connect."""
    root = np.arange(count)
    while True:  # the least number spreads, by pointer jumping
        least = np.minimum(root[edges[:, 0]], root[edges[:, 1]])
        spread = root.copy()
        np.minimum.at(spread, root[edges[:, 0]], least)
        np.minimum.at(spread, root[edges[:, 1]], least)
        spread = spread[spread]
        if np.array_equal(spread, root):
            break
        root = spread
    values = {
        int(island): hash_text(str(int(island))) * 2654435761 % 2**32 / 2**32 for island in np.unique(root)
    }
    return np.array([values[int(island)] for island in root], np.float32)
