# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs shading programs in numpy, so that the compiler is tested without the native module."""

import numpy as np
from nephele import opcodes
from nephele.export.nodes_fold import FOLD

NAMES = list(opcodes.OPCODES)


def run(program, inputs):
    """Returns the final (R, 3) registers. inputs: operation -> value (3,) of those that read the shading point, or a
    function (operands, parameters, mode)."""
    registers = program.registers.astype(np.float64)
    for op, destination, a, b, c, d, offset, mode in program.code.tolist():
        name = NAMES[op]
        operands = [registers[i].copy() for i in (a, b, c, d)]
        parameters = program.parameters[offset:].astype(np.float64)
        if name in inputs:
            value = inputs[name]
            registers[destination] = value(operands, parameters, mode) if callable(value) else value
        else:
            counts = {"ramp": 3 * (mode + 1), "ramp_alpha": mode + 1, "transform": 12}
            function = FOLD[name]
            used = operands[: arity(name)]
            registers[destination] = function(*used, parameters=parameters[: counts.get(name, 0)], mode=mode)
    return registers


def arity(name):
    """Returns how many operands an operation of FOLD takes."""
    special = {"ramp": 1, "ramp_alpha": 1, "transform": 1, "channel": 1, "map_range": 3, "blend": 3}
    if name in special:
        return special[name]
    for count in (1, 2, 3):
        try:
            FOLD[name](*[np.full(3, 0.5)] * count, parameters=(), mode=0)
        except (TypeError, ValueError):
            continue
        return count
    raise ValueError(name)


def closure_inputs(program, inputs, index=0):
    """Returns (closure, its weight (3,), dict of its inputs' values by name, without normals left unconnected)."""
    closure = program.closures[index]
    registers = run(program, inputs)
    names = opcodes.CLOSURES[closure.kind]
    values = {name: registers[k] for name, k in zip(names, closure.inputs, strict=True) if k >= 0}
    return closure, registers[closure.weight], values
