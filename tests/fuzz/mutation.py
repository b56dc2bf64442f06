# SPDX-License-Identifier: GPL-3.0-or-later
"""Mutations of a scene description, chosen by a fuzzer's bytes: every value may become any other."""

import dataclasses
import math
import struct

import numpy as np
from nephele import description, opcodes, parameters, passes

WHOLE = (0, 1, -1, 2, 3, 5, 64, 129, 255, 256, 2**15, 2**16, 2**31 - 1, 2**31, -(2**31), 2**32, 2**63, 10**30)
REAL = (
    *(0.0, -0.0, 1.0, -1.0, 0.5, 1e-45, 1e-38, 1e-12, 1e-6, 1e3, 5000.0, 1e6, 1e12, 1e20, 3e38, -3e38),
    *(1e39, 1e300, math.inf, -math.inf, math.nan, math.pi, 1 + 1e-7),
)
TEXT = (
    *("", "density", "velocity", "flame", "nothing[1]", "\0", "ä" * 300, "/dev/null", "/dev/zero"),
    *("point", "sun", "spot", "area", "ellipse", "perspective", "orthographic", "half", "full", "linear"),
    *opcodes.CLOSURES,
    *opcodes.PHASES,
    *(row.name for row in passes.PASSES),
    *(parameter.name for parameter in parameters.PARAMETERS),
    *(item[0] for parameter in parameters.PARAMETERS for item in parameter.items),
)
TYPES = (np.float32, np.float64, np.int32, np.int64, np.uint8, np.bool_, np.complex64)


class Bytes:
    """Reads a fuzzer's bytes as numbers; after their end come zeros."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def __bool__(self):
        return self.at < len(self.data)

    def take(self, count):
        piece = self.data[self.at : self.at + count]
        self.at += count
        return piece.ljust(count, b"\0")

    def below(self, n):
        """Returns a number in [0, n)."""
        return int.from_bytes(self.take(1 if n <= 256 else 4), "little") % n

    def one_of(self, items):
        return items[self.below(len(items))]

    def whole(self):
        return self.one_of(WHOLE) if self.below(2) else self.below(16) - 4

    def real(self):
        kind = self.below(3)
        if kind == 0:
            return self.one_of(REAL)
        if kind == 1:
            return (self.below(256) - 128) / 16
        return struct.unpack("<f", self.take(4))[0]


def mutated(value, take):
    """Returns `value`, a part of a description, with one thing in it changed. take: Bytes."""
    if take.below(24) == 23:
        return strange(take)
    if dataclasses.is_dataclass(value):
        name = take.one_of([field.name for field in dataclasses.fields(value)])
        return dataclasses.replace(value, **{name: mutated(getattr(value, name), take)})
    if isinstance(value, dict):
        return mutated_settings(value, take)
    if isinstance(value, tuple):
        return mutated_tuple(value, take)
    if isinstance(value, np.ndarray):
        return mutated_array(value, take)
    if isinstance(value, bool):
        return not value
    if isinstance(value, int):
        return take.whole()
    if isinstance(value, float):
        return take.real()
    if isinstance(value, str):
        return take.one_of(TEXT)
    return strange(take)


def strange(take):
    """Returns a value of any type."""
    return take.one_of(
        (
            *(None, True, 7, -1, 0.5, math.nan, "text", "", (), (1, 2, 3), ((1,), None), {}, {"a": 1}),
            *(np.zeros(3, np.float32), np.zeros((4, 4)), np.zeros(0, np.int32), np.float32(2)),
            *(description.Phase(), description.Program(), description.Closure("medium", 0, (0,) * 5)),
            *(description.VolumeClosure((1.0, 1.0, 1.0)), description.World()),
        )
    )


def mutated_settings(settings, take):
    parameter = take.one_of(parameters.PARAMETERS)
    kind = take.below(8)
    if kind == 0:
        value = strange(take)
    elif parameter.kind == "enum":
        value = take.one_of(parameter.items)[0]
    elif parameter.kind == "bool":
        value = bool(take.below(2))
    else:
        low, high = parameter.minimum, parameter.maximum
        value = take.one_of((low, high, low + 1, low + (high - low) * 1e-6, take.real(), take.whole()))
        value = int(value) if parameter.kind == "int" and math.isfinite(value) else value
    return {**settings, parameter.name if kind != 1 else take.one_of(TEXT): value}


def mutated_tuple(items, take):
    kind = take.below(12)
    if not items or kind == 0:
        return (*items, strange(take))
    place = take.below(len(items))
    if kind == 1:
        return items[:place] + items[place + 1 :]
    if kind == 2:
        return (*items, items[place])
    return (*items[:place], mutated(items[place], take), *items[place + 1 :])


def mutated_array(array, take):
    kind = take.below(16)
    with np.errstate(all="ignore"):
        if kind == 0:
            return array.astype(take.one_of(TYPES))
        if kind == 1:
            return array[: take.below(len(array) + 1)] if array.ndim else array
        if kind == 2:
            return take.one_of((array.T, array.reshape(-1), array[..., :0], array[..., ::-1], array[None]))
        if kind == 3:
            return np.concatenate([array, array]) if array.ndim else array
        array = np.array(array)
        if kind == 4:
            array[...] = np.array(take.real()).astype(array.dtype)
        elif array.size:
            number = take.real() if array.dtype.kind == "f" else take.whole()
            bits = np.iinfo(array.dtype) if array.dtype.kind in "iu" else None
            number = min(max(number, bits.min), bits.max) if bits else number
            array.reshape(-1)[take.below(array.size)] = number
    return array
