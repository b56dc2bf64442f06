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
