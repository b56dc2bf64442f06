# SPDX-License-Identifier: GPL-3.0-or-later
"""Coefficients of a volume shader become description.VolumeClosure: constants, constants times one grid of
numbers, or a program where they vary otherwise."""

from dataclasses import dataclass

import numpy as np

from ..description import Phase, VolumeClosure
from ..opcodes import PHASES
from .nodes_program import ONE, OP_INDEX, ZERO, ProgramTooLarge, Value

COEFFICIENTS = ("sigma_s", "sigma_a", "emission")


@dataclass(frozen=True)
class Medium:
    """What a volume shader computes at a point. sigma_s, sigma_a: Values, 1/m. emission: W/(m^3 sr). phase:
    key of opcodes.PHASES, with the Values of its parameters a and b."""

    sigma_s: Value = ZERO
    sigma_a: Value = ZERO
    emission: Value = ZERO
    phase: str = "henyey_greenstein"
    a: Value = ZERO
    b: Value = ZERO


@dataclass(frozen=True)
class Product:
    """rgb (3,) times the grid called `grid`, unless that is None. A grid is taken to be nowhere negative."""

    rgb: np.ndarray
    grid: str | None = None


def closures_of(compiler, node, medium):
    """Returns the list of VolumeClosure of a Medium; warns, naming `node`, of what no closure can hold."""
    found = products(compiler)
    fixed_phase = None not in (medium.a.constant, medium.b.constant)
    direct, varying = {}, {}
    for name in COEFFICIENTS:
        value = getattr(medium, name)
        product = _product_of(value, found)
        if product is None or (name == "sigma_s" and not fixed_phase and not value.is_zero):
            varying[name] = value
            continue
        if not np.isfinite(product.rgb).all():
            compiler.warn(node, f"{name} is infinite or no number; it is 0")
            continue
        rgb = np.maximum(product.rgb, 0.0)
        if rgb.any():
            direct[name] = Product(rgb, product.grid)
    phase = Phase(medium.phase, medium.a.constant[0], medium.b.constant[0]) if fixed_phase else Phase()
    closures = list(_direct_closures(direct, phase))
    if varying:
        closures += _program_closures(compiler, node, medium, varying)
    return closures


def _direct_closures(direct, phase):
    """Yields closures without programs: one for both sigma where the same grid scales them."""
    rgb = {name: tuple(product.rgb.tolist()) for name, product in direct.items()}
    grids = {name: product.grid for name, product in direct.items()}
    if len(grids.keys() & {"sigma_s", "sigma_a"}) == 2 and grids["sigma_s"] == grids["sigma_a"]:
        yield VolumeClosure(rgb["sigma_s"], rgb["sigma_a"], phase=phase, density_grid=grids["sigma_s"])
    else:
        if "sigma_s" in direct:
            yield VolumeClosure(sigma_s=rgb["sigma_s"], phase=phase, density_grid=grids["sigma_s"])
        if "sigma_a" in direct:
            yield VolumeClosure(sigma_a=rgb["sigma_a"], density_grid=grids["sigma_a"])
    if "emission" in direct:
        yield VolumeClosure(emission=rgb["emission"], emission_grid=grids["emission"])


def _program_closures(c, node, medium, varying):
    """Returns the list of the one closure whose program computes the coefficients `varying` (name ->
    Value)."""
    # 0 comes first: maximum(0, x) is 0 where x is no number
    inputs = [c.emit("maximum", ZERO, varying.get(name, ZERO)) for name in COEFFICIENTS]
    a, b = (medium.a, medium.b) if "sigma_s" in varying else (ZERO, ZERO)
    kind = medium.phase if "sigma_s" in varying else "henyey_greenstein"
    row = ("medium", ONE, (*inputs, a, b), list(PHASES).index(kind))
    try:
        program = c.builder.finish([row])
    except ProgramTooLarge as fault:
        c.warn(node, f"the volume's node tree {fault}; it is left out. Simplify it")
        return []
    reads = program.code[:, 0] == OP_INDEX["grid"]
    numbers, program.code[reads, 7] = np.unique(program.code[reads, 7], return_inverse=True)
    return [VolumeClosure(program=program, grids=tuple(c.grid_names[k] for k in numbers))]


# --- Products, found in the instructions ---


def _product_of(value, found):
    return found[value.register] if value.constant is None else Product(np.array(value.constant))


def products(compiler):
    """Returns, for each instruction of the compiler's program, the Product that it computes, or None."""
    instructions, found = compiler.builder.instructions, []
    for op, operands, _, mode in instructions:
        if op == "grid":
            found.append(_grid(compiler, instructions, operands[0], compiler.grid_names[mode]))
        else:
            factors = [_product_of(value, found) for value in operands]
            known = op in PRODUCTS and None not in factors
            found.append(PRODUCTS[op](*factors, mode=mode) if known else None)
    return found


def _grid(compiler, instructions, point, name):
    """A grid of numbers read at the point itself is a Product; one read elsewhere or of vectors is none."""
    unmoved = point.constant is None and instructions[point.register][0] == "position"
    vector = compiler.grids is not None and compiler.grids.count(name) == 3
    return Product(np.ones(3), name) if unmoved and not vector else None


def _multiply(a, b, mode):
    return None if a.grid and b.grid else Product(a.rgb * b.rgb, a.grid or b.grid)


def _divide(a, b, mode):
    if b.grid:
        return None
    return Product(np.divide(a.rgb, b.rgb, out=np.zeros(3), where=b.rgb != 0), a.grid)


def _maximum(a, b, mode):
    if a.rgb.any() and b.rgb.any():
        return None
    return Product(np.maximum(a.rgb, b.rgb), a.grid or b.grid)


PRODUCTS = {
    "multiply": _multiply,
    "divide": _divide,
    "maximum": _maximum,
    "average": lambda a, mode: Product(np.full(3, a.rgb.mean()), a.grid),
    "luminance": lambda a, mode: Product(np.full(3, a.rgb @ (0.2126, 0.7152, 0.0722)), a.grid),
    "channel": lambda a, mode: Product(np.full(3, a.rgb[mode]), a.grid),
}
