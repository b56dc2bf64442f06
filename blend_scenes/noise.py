# SPDX-License-Identifier: GPL-3.0-or-later
"""Procedural noise on point sets, in numpy alone: the stuff of which the bundled clouds are made.

Gradient noise after K. Perlin, "An Image Synthesizer", SIGGRAPH 1985, with the fifth-degree fade of
"Improving Noise", SIGGRAPH 2002; cellular noise after S. Worley, "A Cellular Texture Basis Function",
SIGGRAPH 1996. Lattice values come from an integer hash and not from a table, so that a seed alone
fixes the field and no generator state is involved.

Every function takes `points`, float array (N, 3) in lattice units, and returns float32 (N,).
"""

import itertools

import numpy as np

_UNIT = np.float32(1.0 / 2**32)


def _mix(x):
    """Avalanche the bits of a uint32 array: every input bit reaches every output bit."""
    x = x ^ (x >> np.uint32(16))
    x = x * np.uint32(0x7FEB352D)
    x = x ^ (x >> np.uint32(15))
    x = x * np.uint32(0x846CA68B)
    return x ^ (x >> np.uint32(16))


def _hash(cells, seed):
    """uint32 (N,) from integer cells (N, 3) and a seed."""
    i, j, k = (cells[:, axis].astype(np.int64).astype(np.uint32) for axis in range(3))
    h = _mix(i + np.uint32((0x9E3779B9 * (seed + 1)) & 0xFFFFFFFF))
    h = _mix(h ^ (j * np.uint32(0x85EBCA6B)))
    return _mix(h ^ (k * np.uint32(0xC2B2AE35)))


def _unit_vectors(h):
    """Uniform directions (N, 3) from hashes (N,)."""
    z = h.astype(np.float32) * (2 * _UNIT) - 1
    phi = _mix(h ^ np.uint32(0x68BC21EB)).astype(np.float32) * (2 * np.pi * _UNIT)
    r = np.sqrt(np.maximum(0, 1 - z * z))
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def gradient_noise(points, seed):
    """Smooth noise of mean 0, about within [-1, 1], one feature per lattice unit."""
    points = np.asarray(points, np.float32)
    cells = np.floor(points)
    offsets = points - cells
    fade = offsets**3 * (offsets * (offsets * 6 - 15) + 10)
    total = np.zeros(len(points), np.float32)
    for corner in itertools.product((0, 1), repeat=3):
        c = np.array(corner, np.float32)
        gradients = _unit_vectors(_hash(cells + c, seed))
        weight = np.prod(np.where(c > 0, fade, 1 - fade), axis=1)
        total += weight * np.einsum("ij,ij->i", gradients, offsets - c)
    return total * np.float32(1.5)


def cellular_noise(points, seed):
    """Distance to the nearest of one random feature point per lattice cell: 0 to about 1.2."""
    points = np.asarray(points, np.float32)
    cells = np.floor(points)
    offsets = points - cells
    nearest = np.full(len(points), np.inf, np.float32)
    for neighbour in itertools.product((-1, 0, 1), repeat=3):
        n = np.array(neighbour, np.float32)
        h = _hash(cells + n, seed)
        feature = (
            np.stack([_mix(h ^ np.uint32(salt)) for salt in (1, 2, 3)], axis=1).astype(np.float32) * _UNIT
        )
        delta = n + feature - offsets
        nearest = np.minimum(nearest, np.einsum("ij,ij->i", delta, delta))
    return np.sqrt(nearest)


def fractal(noise, points, seed, octaves, gain=0.5, lacunarity=2.03):
    """Sum `octaves` of `noise`, each `lacunarity` finer and `gain` weaker, divided by the weights' sum."""
    points = np.asarray(points, np.float32)
    total, weights, weight = np.zeros(len(points), np.float32), 0.0, 1.0
    for octave in range(octaves):
        total += np.float32(weight) * noise(points * np.float32(lacunarity**octave), seed + 101 * octave)
        weights += weight
        weight *= gain
    return total / np.float32(weights)


def smoothstep(low, high, x):
    """0 below `low`, 1 above `high`, a cubic with flat ends between (low > high turns it round)."""
    t = np.clip((x - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)
