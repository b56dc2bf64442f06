# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds a shading program (opcodes.py): folds constants, shares equal instructions, allots registers.

While compiling, a value is a constant of three floats or a virtual register that one instruction writes.
`finish` drops what no closure reads and gives the virtual registers places among the program's 256, each free
again after its last use. Knows neither bpy nor the native module.
"""

from dataclasses import dataclass

import numpy as np

from .. import description, opcodes
from .nodes_fold import FOLD

OP_INDEX = {name: index for index, name in enumerate(opcodes.OPCODES)}
MAX_REGISTERS = 256


class ProgramTooLarge(Exception):
    """The node tree needs more registers at once than a program has."""


@dataclass(frozen=True)
class Value:
    """constant: three floats, or None where instruction number `register` computes it."""

    constant: tuple | None = None
    register: int = -1

    @property
    def is_zero(self):
        return self.constant == (0.0, 0.0, 0.0)

    @property
    def is_one(self):
        return self.constant == (1.0, 1.0, 1.0)


def constant(value):
    """Returns the Value of a number (all three channels) or of three or more numbers (the first three)."""
    if isinstance(value, int | float):
        return Value((float(value),) * 3)
    return Value(tuple(float(v) for v in value[:3]))


ZERO, ONE = constant(0.0), constant(1.0)


def _neutral_product(a, b):
    if a.is_zero or b.is_zero:
        return ZERO
    return b if a.is_one else a if b.is_one else None


# operation -> function of its operands that returns the Value it leaves as it is, or None. A product with 0
# is 0 even where the other factor is no finite number.
NEUTRAL = {
    "multiply": _neutral_product,
    "divide": lambda a, b: a if b.is_one or a.is_zero else None,
    "add": lambda a, b: b if a.is_zero else a if b.is_zero else None,
    "subtract": lambda a, b: a if b.is_zero else None,
    "mix": lambda a, b, fac: a if fac.is_zero else b if fac.is_one else None,
}


class ProgramBuilder:
    """Collects instructions and closures of one program."""

    def __init__(self):
        self.instructions = []  # (op, operands, parameters, mode), the one that writes Value.register
        self._known = {}  # instruction -> its Value
        self._closures = []  # (kind, weight, inputs, mode), Values in place of registers

    def emit(self, op, *operands, parameters=(), mode=0):
        """Returns the Value of `op` on `operands` (Values, at most four); computes it now where all are
        constant."""
        if op in FOLD and all(value.constant is not None for value in operands):
            arrays = [np.array(value.constant) for value in operands]
            with np.errstate(all="ignore"):
                folded = np.broadcast_to(FOLD[op](*arrays, parameters=parameters, mode=mode), 3)
            return constant(tuple(folded.astype(np.float32)))
        if op in NEUTRAL and (same := NEUTRAL[op](*operands)) is not None:
            return same
        key = (op, operands, tuple(float(p) for p in parameters), mode)
        if key not in self._known:
            self._known[key] = Value(register=len(self.instructions))
            self.instructions.append(key)
        return self._known[key]

    def closure(self, kind, weight, inputs, mode=0):
        """Adds a closure; `inputs`: Values in the order of opcodes.CLOSURES, None for a normal not
        connected."""
        if len(inputs) != len(opcodes.CLOSURES[kind]):
            raise ValueError(f"closure {kind} takes {len(opcodes.CLOSURES[kind])} inputs, not {len(inputs)}")
        if not weight.is_zero:
            self._closures.append((kind, weight, tuple(inputs), mode))

    def finish(self, closures=None):
        """Returns the description.Program of the closures added, or of `closures` (kind, weight, inputs,
        mode) in their place; raises ProgramTooLarge."""
        closures = self._closures if closures is None else closures
        last_use = self._last_uses(closures)
        registers, tables = _Registers(), _Tables()
        for value in self._used_values(last_use, closures):
            if value.constant is not None:
                registers.hold_constant(value)
        code = []
        for index, (op, operands, parameters, mode) in enumerate(self.instructions):
            if index not in last_use:
                continue
            places = [registers.of(value) for value in operands] + [0] * (4 - len(operands))
            registers.release(
                value.register
                for value in dict.fromkeys(operands)  # a set has another order in every process
                if value.constant is None and last_use[value.register] == index
            )
            code.append((OP_INDEX[op], registers.allot(index), *places, tables.offset(parameters), mode))
        rows = tuple(
            description.Closure(
                kind, registers.of(weight), tuple(-1 if v is None else registers.of(v) for v in inputs), mode
            )
            for kind, weight, inputs, mode in closures
        )
        return description.Program(
            registers=registers.initial(),
            code=np.array(code, np.int32).reshape(-1, 8),
            parameters=np.array(tables.parameters, np.float32),
            closures=rows,
        )

    def _last_uses(self, closures):
        """Returns instruction -> number of the last instruction that reads it, for those that a closure
        needs."""
        end = len(self.instructions)
        last_use = {value.register: end for value in _closure_values(closures) if value.constant is None}
        for index in range(end - 1, -1, -1):
            if index in last_use:
                for value in self.instructions[index][1]:
                    if value.constant is None:
                        last_use.setdefault(value.register, index)
        return last_use

    def _used_values(self, needed, closures):
        for index in sorted(needed):
            yield from self.instructions[index][1]
        yield from _closure_values(closures)


def _closure_values(closures):
    for _, weight, inputs, _ in closures:
        yield weight
        yield from (value for value in inputs if value is not None)


class _Tables:
    """The program's parameters: the table of each instruction, equal ones once."""

    def __init__(self):
        self.parameters = []
        self._offsets = {(): 0}

    def offset(self, table):
        if table not in self._offsets:
            self._offsets[table] = len(self.parameters)
            self.parameters.extend(table)
        return self._offsets[table]


class _Registers:
    """Places of values among the program's registers: constants first, then what instructions write."""

    def __init__(self):
        self._constants = {}
        self._places = {}
        self._free = []
        self._count = 0

    def hold_constant(self, value):
        if value not in self._constants:
            self._constants[value] = self._new()

    def of(self, value):
        return self._constants[value] if value.constant is not None else self._places[value.register]

    def allot(self, index):
        self._places[index] = self._free.pop() if self._free else self._new()
        return self._places[index]

    def release(self, indices):
        self._free.extend(self._places[index] for index in indices)

    def initial(self):
        values = np.zeros((max(1, self._count), 3), np.float32)
        for value, place in self._constants.items():
            values[place] = value.constant
        return values

    def _new(self):
        if self._count == MAX_REGISTERS:
            raise ProgramTooLarge(f"needs more than {MAX_REGISTERS} registers")
        self._count += 1
        return self._count - 1
