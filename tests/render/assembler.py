# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes shading programs by hand, for tests whose scenes come from numbers: see addon/opcodes.py."""

import numpy as np
from nephele import description as d
from nephele import opcodes

OP = {name: i for i, name in enumerate(opcodes.OPCODES)}


class Code:
    """Collects a program's registers and instructions. Registers are named by number; register 0 holds 1."""

    def __init__(self):
        self.registers, self.rows, self.parameters = [(1.0, 1.0, 1.0)], [], []

    def constant(self, value):
        """Returns the register of a number or an RGB."""
        self.registers.append(np.broadcast_to(np.asarray(value, float), 3))
        return len(self.registers) - 1

    def run(self, op, *operands, mode=0, parameters=()):
        """Adds an instruction; returns the register of its result. operands: registers a, b, c, d."""
        result = self.constant(0.0)
        operands = (*operands, 0, 0, 0, 0)[:4]
        self.rows.append((OP[op], result, *operands, len(self.parameters), mode))
        self.parameters.extend(parameters)
        return result

    def program(self, *closures, mode=0):
        """Returns the Program; closures: (kind, weight, *inputs) of registers, or None for no normal. mode:
        of all closures."""
        rows = [
            d.Closure(kind, weight, tuple(-1 if i is None else i for i in inputs), mode)
            for kind, weight, *inputs in closures
        ]
        return d.Program(
            np.array(self.registers, np.float32),
            np.array(self.rows, np.int32).reshape(-1, 8),
            np.array(self.parameters, np.float32),
            tuple(rows),
        )


def inside_box(code, low, high):
    """Returns the register that is 1 where the point's world position lies in a box, 0 outside."""
    p = code.run("position")
    above = code.run("greater_than", p, code.constant(low))
    below = code.run("less_than", p, code.constant(high))
    both = code.run("multiply", above, below)
    x, y, z = (code.run("channel", both, mode=k) for k in range(3))
    return code.run("multiply", x, code.run("multiply", y, z))
