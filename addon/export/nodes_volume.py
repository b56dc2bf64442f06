# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume shaders: a tree of volume nodes becomes a tuple of description.VolumeClosure.

Coefficients as in Cycles, with density d, colour c and temperature T:
    Principled   sigma_s = c d,  sigma_a = max(1 - c, 0) max(1 - sqrt(absorption colour), 0) d,
                 emission = strength colour + intensity tint sigma T^4 blackbody(T), see BOLTZMANN
    Scatter      sigma_s = c d          Absorption   sigma_a = (1 - c) d
    Coefficients sigma_s, sigma_a and emission as given
Emission is not scaled by density. Densities and colours below 0 count as 0.
"""

import math
from dataclasses import replace

from .nodes_math import clamp01
from .nodes_medium import COEFFICIENTS, Medium, closures_of
from .nodes_program import ONE, ZERO, constant
from .nodes_tree import relay, upstream

# Stefan's and Boltzmann's constant over pi, in MW/(m^2 sr K^4): Cycles' unit of blackbody emission.
BOLTZMANN = 5.670373e-8 * 1e-6 / math.pi

LARGEST_G = 0.999

# property `phase` of a node -> (phase function, (socket, least, greatest) of each parameter), limits as in
# Cycles.
_ANISOTROPY = ("Anisotropy", -LARGEST_G, LARGEST_G)
PHASE_SOCKETS = {
    "HENYEY_GREENSTEIN": ("henyey_greenstein", (_ANISOTROPY,)),
    "RAYLEIGH": ("rayleigh", ()),
    "DRAINE": ("draine", (_ANISOTROPY, ("Alpha", 0.0, math.inf))),
    "FOURNIER_FORAND": ("fournier_forand", (("IOR", 1.001, math.inf), ("Backscatter", 0.0, 0.499))),
    "MIE": ("mie", (("Diameter", 0.0, math.inf),)),
}


def compile_volume(c, socket):
    """Returns the tuple of VolumeClosure behind `socket`. c: VolumeCompiler."""
    return tuple(_closures(c, socket, (), ONE))


def _closures(c, socket, path, weight):
    """Yields the closures behind shader input `socket`, scaled by the Value `weight`."""
    output = upstream(socket)
    if output is None or weight.is_zero:
        return
    passed = relay(output, path)
    if passed is not None:
        if passed[0] is not None:
            yield from _closures(c, *passed, weight)
        return
    node = output.node
    if output.type != "SHADER":
        c.warn(node, f"'{output.name}' is no shader; it is taken as emission")
        yield from _weighted(c, node, Medium(emission=_nonnegative(c, c.value(socket, path))), weight)
    elif node.type == "ADD_SHADER":
        yield from _closures(c, node.inputs[0], path, weight)
        yield from _closures(c, node.inputs[1], path, weight)
    elif node.type == "MIX_SHADER":
        fac = clamp01(c, c.input(node, "Fac", path))
        yield from _closures(
            c, node.inputs[1], path, c.emit("multiply", weight, c.emit("subtract", ONE, fac))
        )
        yield from _closures(c, node.inputs[2], path, c.emit("multiply", weight, fac))
    elif node.type in NODES:
        yield from _weighted(c, node, NODES[node.type](c, node, path), weight)
    else:
        c.warn(node, f"this node ({node.bl_label}) is not supported in a volume; it adds nothing")


def _weighted(c, node, medium, weight):
    scaled = {name: c.emit("multiply", weight, getattr(medium, name)) for name in COEFFICIENTS}
    return closures_of(c, node, replace(medium, **scaled))


def _nonnegative(c, value):
    return c.emit("maximum", ZERO, value)


def _input(c, node, identifier, path):
    """Returns the Value of an input that is not below 0."""
    return _nonnegative(c, c.input(node, identifier, path))


def _one_minus(c, value):
    """max(1 - value, 0)"""
    return _nonnegative(c, c.emit("subtract", ONE, value))


def _phase(c, node, path):
    """Returns the fields `phase`, `a` and `b` of a Medium."""
    choice = getattr(node, "phase", "HENYEY_GREENSTEIN")
    if choice not in PHASE_SOCKETS:
        c.warn(node, f"phase function {choice.replace('_', ' ').title()} is not supported; it is isotropic")
        return {}
    kind, sockets = PHASE_SOCKETS[choice]
    values = {}
    for field, (identifier, least, greatest) in zip("ab", sockets, strict=False):
        value = c.emit("maximum", constant(least), c.input(node, identifier, path))
        values[field] = value if math.isinf(greatest) else c.emit("minimum", value, constant(greatest))
    return {"phase": kind} | values


def _named_grid(c, node, identifier):
    """Returns the name in a string socket, or None where it is empty or there are no grids here."""
    socket = c.socket(node, identifier)
    return (socket.default_value or None) if socket is not None and c.grids is not None else None


def _principled(c, node, path):
    density, color = _input(c, node, "Density", path), _input(c, node, "Color", path)
    if (name := _named_grid(c, node, "Density Attribute")) is not None:
        density = c.emit("multiply", density, c.read_number(name))
    if (name := _found_grid(c, node, "Color Attribute")) is not None:
        color = c.emit("multiply", color, _nonnegative(c, c.read_grid(name)))
    absorption = _one_minus(c, c.emit("sqrt", _input(c, node, "Absorption Color", path)))
    absorbed = c.emit("multiply", _one_minus(c, color), absorption)
    return Medium(
        sigma_s=c.emit("multiply", color, density),
        sigma_a=c.emit("multiply", absorbed, density),
        emission=c.emit(
            "add", _shine(c, node, path, "Emission Color", "Emission Strength"), _blackbody(c, node, path)
        ),
        **_phase(c, node, path),
    )


def _found_grid(c, node, identifier):
    """As _named_grid; None, with a warning, where the data have no such grid: it is left out of the
    product."""
    name = _named_grid(c, node, identifier)
    if name is None or c.has_grid(name):
        return name
    c.warn(node, f"there is no grid '{name}' here; '{identifier}' is left out")
    return None


def _blackbody(c, node, path):
    intensity = _input(c, node, "Blackbody Intensity", path)
    if intensity.is_zero:
        return ZERO
    kelvin = _input(c, node, "Temperature", path)
    if (name := _found_grid(c, node, "Temperature Attribute")) is not None:
        kelvin = c.emit("multiply", kelvin, _nonnegative(c, c.read_number(name)))
    squared = c.emit("multiply", kelvin, kelvin)
    scale = c.emit("multiply", intensity, constant(BOLTZMANN))
    power = c.emit("multiply", c.emit("multiply", squared, squared), scale)
    color = c.emit("multiply", c.emit("blackbody", kelvin), _input(c, node, "Blackbody Tint", path))
    return c.emit("multiply", power, color)


def _shine(c, node, path, color, strength):
    return c.emit("multiply", _input(c, node, color, path), _input(c, node, strength, path))


def _scatter(c, node, path):
    return Medium(sigma_s=_shine(c, node, path, "Color", "Density"), **_phase(c, node, path))


def _absorption(c, node, path):
    color, density = c.input(node, "Color", path), _input(c, node, "Density", path)
    return Medium(sigma_a=c.emit("multiply", _one_minus(c, color), density))


def _coefficients(c, node, path):
    scatter, absorb, emit = (
        _input(c, node, f"{name} Coefficients", path) for name in ("Scatter", "Absorption", "Emission")
    )
    return Medium(scatter, absorb, emit, **_phase(c, node, path))


NODES = {
    "PRINCIPLED_VOLUME": _principled,
    "VOLUME_SCATTER": _scatter,
    "VOLUME_ABSORPTION": _absorption,
    "VOLUME_COEFFICIENTS": _coefficients,
    "EMISSION": lambda c, node, path: Medium(emission=_shine(c, node, path, "Color", "Strength")),
}
