# SPDX-License-Identifier: GPL-3.0-or-later
"""Matrices between Blender and numpy, and small helpers on them."""

import numpy as np


def matrix4(matrix):
    """Returns a Blender 4x4 matrix as (4, 4) float64."""
    return np.array(matrix, np.float64)


def translation(offset):
    """Returns the (4, 4) matrix that moves by `offset` (3,)."""
    result = np.eye(4)
    result[:3, 3] = offset
    return result


def scaling(factors):
    """Returns the (4, 4) matrix that scales by `factors` (3,)."""
    return np.diag((*factors, 1.0))


def without_scale(matrix):
    """Returns `matrix` with its three axes normalised, as Blender does for cameras."""
    result = np.array(matrix, np.float64)
    result[:3, :3] /= np.maximum(np.linalg.norm(result[:3, :3], axis=0), 1e-30)
    return result


def viewplane(projection, perspective):
    """Returns (left, right, bottom, top) that a projection matrix of Blender's shows: at distance 1, or in
    metres where it is orthographic."""
    projection = matrix4(projection)
    scale = np.array((projection[0, 0], projection[1, 1]))
    offset = projection[:2, 2] if perspective else -projection[:2, 3]
    low, high = (offset - 1) / scale, (offset + 1) / scale
    return (float(low[0]), float(high[0]), float(low[1]), float(high[1]))
