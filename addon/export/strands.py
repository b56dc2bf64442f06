# SPDX-License-Identifier: GPL-3.0-or-later
"""Strands of hair and points as triangles: tubes around Catmull-Rom curves through the keys, and balls.

Their normals are those of the round shapes, and their radii are such that they cover, from all sides on
average, what the round shapes do: by Cauchy's formula a convex body covers a quarter of its surface, and a
prism its perimeter over pi times its length. Knows nothing of Blender."""

from dataclasses import dataclass

import numpy as np

SIDES = 6  # of a tube
MANY_BALLS = 20000  # more of them are made of fewer faces


@dataclass(frozen=True)
class Tessellation:
    """positions: (N, 3). triangles: (T, 3). normals: (N, 3). key, fraction: (N,), the point of the source
    that each vertex lies at, or so far on the way from it to the next. part: (N,), number of the strand or
    ball."""

    positions: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    key: np.ndarray
    fraction: np.ndarray
    part: np.ndarray

    def at_points(self, values):
        """Returns (N, c): what has `values`, (points, c), at the source's points."""
        following = np.minimum(self.key + 1, len(values) - 1)
        share = self.fraction[:, None]
        return values[self.key] * (1 - share) + values[following] * share

    def at_parts(self, values):
        """Returns (N, c): what has `values`, (parts, c), on each strand or ball."""
        return values[self.part]


def tubes(positions, radii, offsets, steps):
    """Returns the Tessellation of strands.

    positions: (K, 3) keys, radii: (K,), offsets: (strands + 1,) of the first key of each, and the end. steps:
    pieces between two keys. Strands of a single key, or none, give nothing."""
    counts = np.diff(offsets)
    pieces = []
    for count in np.unique(counts[counts >= 2]):
        numbers = np.flatnonzero(counts == count)
        keys = offsets[numbers][:, None] + np.arange(count)
        pieces.append(_tubes_of(positions[keys], radii[keys], keys, numbers, steps))
    return _joined(pieces)


def _tubes_of(points, radii, keys, numbers, steps):
    """Strands of equally many keys: points (S, K, 3), radii and keys (S, K)."""
    four = np.concatenate((points, radii[..., None]), axis=2).astype(np.float64)
    curve, place = _catmull_rom(four, steps)
    center, radius = curve[..., :3], np.maximum(curve[..., 3], 0.0)
    tangent = _unit(np.gradient(center, axis=1))
    side = _transported(tangent)
    other = np.cross(tangent, side)
    angle = 2 * np.pi * np.arange(SIDES) / SIDES
    normal = np.cos(angle)[:, None] * side[:, :, None] + np.sin(angle)[:, None] * other[:, :, None]
    wider = np.pi / (SIDES * np.sin(np.pi / SIDES))
    ring = center[:, :, None] + normal * (radius * wider)[:, :, None, None]
    strands, rings = radius.shape
    at = np.broadcast_to(np.minimum(place.astype(int), keys.shape[1] - 2), (strands, rings))
    key = np.take_along_axis(keys, at, axis=1)
    return Tessellation(
        ring.reshape(-1, 3),
        _tube_faces(strands, rings),
        normal.reshape(-1, 3),
        np.repeat(key.ravel(), SIDES),
        np.repeat((place - at).ravel(), SIDES),
        np.repeat(numbers, rings * SIDES),
    )


def _catmull_rom(keys, steps):
    """Returns (curve (S, R, c), place (R,)): uniform Catmull-Rom curves through keys (S, K, c), whose ends
    count twice as in Cycles, and where each of the R points is among the keys."""
    padded = np.concatenate((keys[:, :1], keys, keys[:, -1:]), axis=1)
    count = keys.shape[1]
    place = np.linspace(0.0, count - 1, (count - 1) * steps + 1)
    first = np.minimum(place.astype(int), count - 2)
    t = (place - first)[None, :, None]
    p0, p1, p2, p3 = (padded[:, first + n] for n in range(4))
    curve = p1 + 0.5 * t * (p2 - p0 + t * (2 * p0 - 5 * p1 + 4 * p2 - p3 + t * (3 * (p1 - p2) + p3 - p0)))
    return curve, place


def _transported(tangent):
    """Returns (S, R, 3): unit vectors across the tangents, which turn no more than those do."""
    first = tangent[:, 0]
    helper = np.where(np.abs(first[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    side = np.empty_like(tangent)
    side[:, 0] = _unit(np.cross(first, helper))
    for step in range(1, tangent.shape[1]):
        t = tangent[:, step]
        kept = side[:, step - 1] - t * (side[:, step - 1] * t).sum(1, keepdims=True)
        lost = np.linalg.norm(kept, axis=1, keepdims=True) < 1e-6  # a turn of a right angle
        helper = np.where(np.abs(t[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
        side[:, step] = _unit(np.where(lost, np.cross(t, helper), kept))
    return side


def _tube_faces(strands, rings):
    ring = np.arange(rings - 1)[:, None] * SIDES
    a, b = ring + np.arange(SIDES), ring + (np.arange(SIDES) + 1) % SIDES
    c, d = b + SIDES, a + SIDES
    one = np.stack((a, b, c, a, c, d), axis=-1).reshape(-1, 3)
    return (np.arange(strands)[:, None, None] * rings * SIDES + one).reshape(-1, 3)


def balls(positions, radii):
    """Returns the Tessellation of balls at positions (P, 3) of radii (P,)."""
    count = len(positions)
    directions, faces, covered = _round(1 if count > MANY_BALLS else 2)
    wider = covered**-0.5
    vertices = positions[:, None] + directions * (np.maximum(radii, 0.0) * wider)[:, None, None]
    corners = np.arange(count)[:, None, None] * len(directions) + faces
    number = np.repeat(np.arange(count), len(directions))
    return Tessellation(
        vertices.reshape(-1, 3),
        corners.reshape(-1, 3),
        np.tile(directions, (count, 1)),
        number,
        np.zeros(len(number)),
        number,
    )


def _round(subdivisions):
    """Returns (directions (V, 3), faces (F, 3), its surface over that of the ball) of an icosphere."""
    golden = (1 + 5**0.5) / 2
    points = [(s, t * golden, 0) for s in (-1, 1) for t in (-1, 1)]
    corners = _unit(np.array([np.roll(p, shift) for shift in range(3) for p in points], float))
    apart = np.linalg.norm(corners[:, None] - corners, axis=2)
    near = (apart > 0) & (apart < 1.1)
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i)
        for k in range(j)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    triangles = corners[np.array(faces)]
    for _ in range(subdivisions):
        a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
        ab, bc, ca = _unit(a + b), _unit(b + c), _unit(c + a)
        quarters = ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))
        triangles = np.concatenate([np.stack(q, axis=1) for q in quarters])
    directions, number = np.unique(triangles.reshape(-1, 3).round(9), axis=0, return_inverse=True)
    faces = number.reshape(-1, 3)
    a, b, c = (directions[faces[:, corner]] for corner in range(3))
    inwards = (np.cross(b - a, c - a) * a).sum(1) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    surface = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    return directions, faces, surface / (4 * np.pi)


def _joined(pieces):
    """Returns one Tessellation of several."""
    if not pieces:
        nothing, none = np.zeros((0, 3)), np.zeros(0, int)
        return Tessellation(nothing, np.zeros((0, 3), int), nothing, none, np.zeros(0), none)
    starts = np.cumsum([0, *(len(piece.positions) for piece in pieces[:-1])])
    faces = [piece.triangles + start for piece, start in zip(pieces, starts, strict=True)]
    names = ("positions", "normals", "key", "fraction", "part")
    joined = {name: np.concatenate([getattr(piece, name) for piece in pieces]) for name in names}
    return Tessellation(triangles=np.concatenate(faces), **joined)


def _unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)
