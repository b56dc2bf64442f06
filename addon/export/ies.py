# SPDX-License-Identifier: GPL-3.0-or-later
"""IES profiles (IESNA LM-63): how bright a lamp is by direction, measured, as a picture over both angles.

Profiles of types C, B and A are read; what symmetry leaves out is filled in. Knows nothing of Blender."""

import numpy as np

WIDTH, HEIGHT = 361, 181  # a degree of the horizontal and of the vertical angle for each pixel


class BadProfile(ValueError):
    """The text is no IES profile that we read; the message says why."""


def parse(text):
    """Returns (vertical angles (V,), horizontal angles (H,), candela (H, V)), angles in degrees; those of
    type C: vertical from straight down. Raises BadProfile."""
    if not text.lstrip("\ufeff \r\n").startswith("IES"):
        raise BadProfile("it does not begin with 'IES'")
    tilt = text.find("TILT=")
    if tilt < 0:
        raise BadProfile("it has no line TILT=")
    first, _, rest = text[tilt + 5 :].partition("\n")
    numbers = _Numbers(rest)
    if first.strip().upper() == "INCLUDE":
        numbers.take(1)
        pairs = int(numbers.take(1)[0])
        numbers.take(2 * pairs)
    _, _, factor, v_count, h_count, kind, *_ = numbers.take(10)
    ballast, _, _ = numbers.take(3)
    if not (1 <= v_count <= 10000 and 1 <= h_count <= 10000):
        raise BadProfile("its numbers of angles make no sense")
    vertical, horizontal = numbers.take(int(v_count)), numbers.take(int(h_count))
    candela = numbers.take(int(v_count) * int(h_count)).reshape(int(h_count), int(v_count)) * factor * ballast
    if np.any(np.diff(vertical) <= 0) or np.any(np.diff(horizontal) <= 0):
        raise BadProfile("its angles do not grow")
    if int(kind) == 1:
        return vertical, *_whole_circle(horizontal, candela)
    if int(kind) in (2, 3):
        return _from_side(vertical, horizontal, candela, int(kind))
    raise BadProfile(f"its photometric type {int(kind)} is not known")


class _Numbers:
    def __init__(self, text):
        try:
            self._values = np.array(text.replace(",", " ").split(), float)
        except ValueError as fault:
            raise BadProfile("it holds text where numbers belong") from fault
        self._next = 0

    def take(self, count):
        """Returns the next `count` numbers."""
        taken = self._values[self._next : self._next + count]
        if len(taken) < count:
            raise BadProfile("it ends too early")
        self._next += count
        return taken


def _whole_circle(horizontal, candela):
    """Returns (horizontal, candela) all the way round, from what the symmetry of type C leaves."""
    last = horizontal[-1]
    if len(horizontal) == 1:
        return np.array([0.0, 360.0]), np.repeat(candela, 2, axis=0)
    if last == 90.0:
        horizontal = np.concatenate((horizontal, 180 - horizontal[-2::-1]))
        candela = np.concatenate((candela, candela[-2::-1]))
        last = 180.0
    if last == 180.0:
        horizontal = np.concatenate((horizontal, 360 - horizontal[-2::-1]))
        candela = np.concatenate((candela, candela[-2::-1]))
    if horizontal[-1] < 360.0:
        horizontal, candela = np.append(horizontal, 360.0), np.concatenate((candela, candela[:1]))
    return horizontal, candela


def _from_side(vertical, horizontal, candela, kind):
    """Returns as parse(), on a grid of degrees, of a profile of type B (2) or A (3), whose poles lie on a
    horizontal axis."""
    if horizontal[0] == 0.0:
        horizontal = np.concatenate((-horizontal[:0:-1], horizontal))
        candela = np.concatenate((candela[:0:-1], candela))
    v, h = np.arange(0.0, 181.0), np.arange(0.0, 361.0)
    theta, phi = np.radians(v)[None, :], np.radians(h)[:, None]
    x, y, z = np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), -np.cos(theta)
    along, across = (y, x) if kind == 2 else (x, y)  # the axis of the poles, and the other one
    height = np.degrees(np.arcsin(np.clip(along, -1, 1)))
    around = np.degrees(np.arctan2(across, -z))
    return v, h, _at(horizontal, vertical, candela, around, height)


def _at(rows, columns, values, row, column):
    """Returns values, (rows, columns), interpolated linearly at (row, column); 0 outside."""
    inside = (row >= rows[0]) & (row <= rows[-1]) & (column >= columns[0]) & (column <= columns[-1])

    def place(axis, at):
        if len(axis) == 1:
            return np.zeros(at.shape, int), np.zeros(at.shape)
        i = np.clip(np.searchsorted(axis, at, side="right") - 1, 0, len(axis) - 2)
        return i, np.clip((at - axis[i]) / (axis[i + 1] - axis[i]), 0, 1)

    (i, s), (j, t) = place(rows, row), place(columns, column)
    i1, j1 = np.minimum(i + 1, len(rows) - 1), np.minimum(j + 1, len(columns) - 1)
    upper = values[i, j] * (1 - t) + values[i, j1] * t
    lower = values[i1, j] * (1 - t) + values[i1, j1] * t
    return np.where(inside, upper * (1 - s) + lower * s, 0.0)


def picture(text):
    """Returns (HEIGHT, WIDTH) candela: rows from straight down to straight up, columns round the axis;
    between the angles of the profile smooth (Catmull-Rom), as in Cycles. Raises BadProfile."""
    vertical, horizontal, candela = parse(text)
    v, h = np.linspace(0, 180, HEIGHT), np.linspace(0, 360, WIDTH)
    opposite = (np.arange(len(horizontal)) + len(horizontal) // 2) % len(horizontal)
    dark = np.zeros((len(horizontal), 1))
    # Beyond a pole the profile goes on at the other side; beyond an end short of it, it is dark.
    beyond = candela[opposite]
    low = beyond[:, 1:2] if vertical[0] == 0 and len(vertical) > 1 else dark
    high = beyond[:, -2:-1] if vertical[-1] == 180 and len(vertical) > 1 else dark
    columns = _smooth(vertical, np.concatenate((low, candela, high), axis=1).T, v)
    columns[(v < vertical[0]) | (v > vertical[-1])] = 0.0
    rows = np.concatenate((columns[:, -2:-1], columns, columns[:, 1:2]), axis=1).T
    found = _smooth(horizontal, rows, h).T
    return np.maximum(found, 0.0)


def _smooth(angles, values, at):
    """Returns (len(at), c): Catmull-Rom curves, uniform between angles, through `values`, which have one
    more row at either end than there are angles."""
    if len(angles) == 1:
        return np.repeat(values[1:2], len(at), axis=0)
    i = np.clip(np.searchsorted(angles, at, side="right") - 1, 0, len(angles) - 2)
    t = np.clip((at - angles[i]) / (angles[i + 1] - angles[i]), 0, 1)[:, None]
    a, b, c, d = (values[i + n] for n in range(4))
    return b + 0.5 * t * (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a)))
