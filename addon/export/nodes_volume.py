# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders: a tree of volume nodes becomes a tuple of description.VolumeClosure.

Coefficients as in Cycles, with density d and colour c:
    Principled   sigma_s = c d,  sigma_a = max(1 - c, 0) max(1 - sqrt(absorption colour), 0) d
    Scatter      sigma_s = c d          Absorption   sigma_a = (1 - c) d
    Coefficients sigma_s, sigma_a and emission as given
Emission is not scaled by density. An input may be a constant, or a constant times one grid that the file
holds.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..description import Phase, VolumeClosure
from .nodes_math import clamp01
from .nodes_tree import default_value, inputs_first, relay, upstream

GRID_READERS = {"ATTRIBUTE", "VOLUME_INFO"}  # types of nodes that give the value of a grid


@dataclass(frozen=True)
class Factor:
    """A coefficient: rgb (3,), multiplied by the grid called `grid` unless that is None."""

    rgb: np.ndarray
    grid: str | None = None

    @property
    def scalar(self):
        return float(self.rgb[0])

    @property
    def is_zero(self):
        return not np.any(self.rgb)


class VolumeCompiler:
    """Compiles the Volume socket of one tree. grids: True for VDB volumes and fluid domains, whose attributes
    are grids; False for meshes and the world, which have none."""

    def __init__(self, compiler, grids):
        self._c = compiler
        self._grids = grids
        self._closures = []

    def compile(self, socket):
        """Returns the tuple of VolumeClosure behind `socket`."""
        self._visit(socket, (), 1.0)
        return tuple(self._closures)

    def _visit(self, socket, path, weight):
        output = upstream(socket)
        if output is None or weight == 0:
            return
        passed = relay(output, path)
        if passed is not None:
            if passed[0] is not None:
                self._visit(*passed, weight)
            return
        node = output.node
        if node.type == "ADD_SHADER":
            self._visit(node.inputs[0], path, weight)
            self._visit(node.inputs[1], path, weight)
        elif node.type == "MIX_SHADER":
            fac = self._mix_factor(node, path)
            self._visit(node.inputs[1], path, weight * (1 - fac))
            self._visit(node.inputs[2], path, weight * fac)
        elif node.type in NODES:
            for closure in NODES[node.type](self, node, path):
                self._add(closure, weight)
        else:
            self._c.warn(node, f"this node ({node.bl_label}) is not supported in a volume; it adds nothing")

    def _add(self, closure, weight):
        scaled = {
            name: tuple(float(v) * weight for v in getattr(closure, name))
            for name in ("sigma_s", "sigma_a", "emission")
        }
        if any(any(values) for values in scaled.values()):
            self._closures.append(replace(closure, **scaled))

    def _mix_factor(self, node, path):
        value = clamp01(self._c, self._c.input(node, "Fac", path))
        if value.constant is None:
            self._c.warn(
                node, "a factor that is not constant is not supported in a volume; the socket's value is used"
            )
            value = clamp01(self._c, default_value(self._c.socket(node, "Fac")))
        return value.constant[0]

    def color(self, node, identifier, path):
        """Returns a constant input as (3,) float64; the socket's own value, with a warning, where it is no
        constant."""
        factor = self.factor(node, identifier, path)
        if factor.grid is None:
            return factor.rgb
        self._c.warn(
            node, f"'{identifier}' may not depend on grid '{factor.grid}'; the socket's value is used"
        )
        return np.array(default_value(self._c.socket(node, identifier)).constant)

    def number(self, node, identifier, path):
        """Returns a constant input as a float (0 where this Blender's node lacks the socket)."""
        return float(self.color(node, identifier, path)[0])

    def factor(self, node, identifier, path):
        """Returns the Factor of an input."""
        socket = self._c.socket(node, identifier)
        if socket is None:
            return Factor(np.zeros(3))
        found = self._product(socket, path)
        if found is None:
            self._c.warn(
                node,
                f"what is linked to '{identifier}' is not supported in a volume; the socket's value is used",
            )
            found = Factor(np.array(default_value(socket).constant))
        return found

    def _product(self, socket, path):
        """Returns the Factor behind an input socket; None where it is neither constant nor a constant times a
        grid."""
        output = upstream(socket)
        if output is None:
            return Factor(np.array(default_value(socket).constant))
        passed = relay(output, path)
        if passed is not None:
            if passed[0] is None:
                return Factor(np.array(default_value(socket).constant))
            return self._product(*passed)
        node = output.node
        if node.type in GRID_READERS:
            return self._grid(node, output)
        if node.type in ("MATH", "VECT_MATH") and self._depends_on_grid(node, path):
            return self._arithmetic(node, path)
        if self._depends_on_grid(node, path):
            return None
        value = self._c.value(socket, path)
        return None if value.constant is None else Factor(np.array(value.constant))

    def _grid(self, node, output):
        name = node.attribute_name if node.type == "ATTRIBUTE" else output.identifier.lower()
        geometry = node.type == "VOLUME_INFO" or node.attribute_type == "GEOMETRY"
        if self._grids and geometry and name and output.identifier not in ("Color", "Alpha"):
            return Factor(np.ones(3), name)
        if self._grids and node.type == "ATTRIBUTE" and geometry and name and output.identifier == "Color":
            self._c.warn(node, f"grid '{name}' is read as one number, not as a colour")
            return Factor(np.ones(3), name)
        self._c.warn(node, f"there is no grid '{name}' here; it is 0")
        return Factor(np.zeros(3))

    def _depends_on_grid(self, node, path):
        """True when `node` or what feeds it, followed upstream, reads a grid."""
        if node.type in GRID_READERS:
            return True
        for socket in node.inputs:
            for behind, behind_path in inputs_first(socket, path, lambda feeder: feeder.inputs):
                output = upstream(behind)
                if (
                    output is not None
                    and relay(output, behind_path) is None
                    and output.node.type in GRID_READERS
                ):
                    return True
        return False

    def _arithmetic(self, node, path):
        """Multiply, divide by a constant, and scale keep a product; other operations do not."""
        operation, clamped = node.operation, getattr(node, "use_clamp", False)
        if operation not in ("MULTIPLY", "DIVIDE", "SCALE") or clamped:
            return None
        second = self._c.socket(node, "Scale") if operation == "SCALE" else node.inputs[1]
        a, b = self._product(node.inputs[0], path), self._product(second, path)
        if a is None or b is None or (a.grid and b.grid) or (operation == "DIVIDE" and b.grid):
            return None
        if operation == "DIVIDE":
            return Factor(np.divide(a.rgb, b.rgb, out=np.zeros(3), where=b.rgb != 0), a.grid)
        return Factor(a.rgb * b.rgb, a.grid or b.grid)

    def density(self, node, path):
        """Returns the Density input as (factor, grid name or None)."""
        found = self.factor(node, "Density", path)
        return max(found.scalar, 0.0), found.grid

    def attribute_grid(self, node, identifier):
        """Returns the grid that a string socket names, or None where it names none or there are no grids
        here."""
        socket = self._c.socket(node, identifier)
        return (socket.default_value or None) if socket is not None and self._grids else None

    def phase(self, node, path):
        """Returns the Henyey-Greenstein g of a scattering node; warns about other phase functions."""
        kind = getattr(node, "phase", "HENYEY_GREENSTEIN")
        if kind == "HENYEY_GREENSTEIN":
            return float(np.clip(self.number(node, "Anisotropy", path), -0.999, 0.999))
        g = self.number(node, "Anisotropy", path) if kind == "DRAINE" else 0.0
        self._c.warn(
            node,
            f"phase function {kind.replace('_', ' ').title()} is not supported; Henyey-Greenstein, g = {g:g}",
        )
        return float(np.clip(g, -0.999, 0.999))

    def warn(self, node, text):
        self._c.warn(node, text)


def _principled(v, node, path):
    density, grid = v.density(node, path)
    attribute = v.attribute_grid(node, "Density Attribute")
    if grid and attribute and density:
        v.warn(
            node,
            f"density is grid '{grid}' times grid '{attribute}', only one is supported; '{attribute}' "
            "is left out",
        )
    grid = grid or attribute
    if v.attribute_grid(node, "Color Attribute"):
        v.warn(node, "a colour grid is not supported; the constant colour is used")
    if v.number(node, "Blackbody Intensity", path) > 0:
        v.warn(node, "blackbody emission is not supported; it is left out")
    color = np.maximum(v.color(node, "Color", path), 0.0)
    absorption = np.sqrt(np.maximum(v.color(node, "Absorption Color", path), 0.0))
    yield VolumeClosure(
        sigma_s=tuple(color * density),
        sigma_a=tuple(np.maximum(1 - color, 0) * np.maximum(1 - absorption, 0) * density),
        phase=Phase(a=v.phase(node, path)),
        density_grid=grid,
    )
    yield from _emission(v, node, path, "Emission Color", "Emission Strength")


def _emission(v, node, path, color, strength):
    factor = v.factor(node, strength, path)
    if factor.scalar > 0:
        rgb = np.maximum(v.color(node, color, path), 0.0)
        yield VolumeClosure(emission=tuple(rgb * factor.scalar), emission_grid=factor.grid)


def _scatter(v, node, path):
    density, grid = v.density(node, path)
    color = np.maximum(v.color(node, "Color", path), 0.0)
    yield VolumeClosure(sigma_s=tuple(color * density), phase=Phase(a=v.phase(node, path)), density_grid=grid)


def _absorption(v, node, path):
    density, grid = v.density(node, path)
    color = v.color(node, "Color", path)
    yield VolumeClosure(sigma_a=tuple(np.maximum(1 - color, 0) * density), density_grid=grid)


def _coefficients(v, node, path):
    scatter, absorb, emit = (
        v.factor(node, f"{name} Coefficients", path) for name in ("Scatter", "Absorption", "Emission")
    )
    rgb = [tuple(np.maximum(f.rgb, 0.0)) for f in (scatter, absorb, emit)]
    phase = Phase(a=v.phase(node, path))
    if scatter.grid == absorb.grid:
        yield VolumeClosure(sigma_s=rgb[0], sigma_a=rgb[1], phase=phase, density_grid=scatter.grid)
    else:
        yield VolumeClosure(sigma_s=rgb[0], phase=phase, density_grid=scatter.grid)
        yield VolumeClosure(sigma_a=rgb[1], density_grid=absorb.grid)
    yield VolumeClosure(emission=rgb[2], emission_grid=emit.grid)


NODES = {
    "PRINCIPLED_VOLUME": _principled,
    "VOLUME_SCATTER": _scatter,
    "VOLUME_ABSORPTION": _absorption,
    "VOLUME_COEFFICIENTS": _coefficients,
    "EMISSION": lambda v, node, path: _emission(v, node, path, "Color", "Strength"),
}
