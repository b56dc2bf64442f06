# SPDX-License-Identifier: GPL-3.0-or-later
"""Expression nodes of colour: mixing, ramps and curves (baked to tables), hue, gamma, blackbody."""

import numpy as np

from ..opcodes import BLEND_MODES
from .nodes_math import clamp01
from .nodes_program import ONE, ZERO, constant
from .wavelength import FIRST_NM, LAST_NM, spectrum

TABLE = 257  # entries of a baked ramp


def bake(c, operation, position, samples):
    """Returns `operation` ("ramp" or "ramp_alpha") at `position` in a table of TABLE rows."""
    return c.emit(operation, position, parameters=np.ravel(samples), mode=TABLE - 1)


def blend(c, node, a, b, fac, mode):
    name = mode.lower()
    if name == "mix":
        return c.emit("mix", a, b, fac)
    if name not in BLEND_MODES:
        c.warn(node, f"blend mode {mode.title()} is not supported; Mix is used")
        return c.emit("mix", a, b, fac)
    return c.emit("blend", a, b, fac, mode=BLEND_MODES.index(name))


def mix(c, node, output, path):
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type)
    if kind is None:
        c.warn(node, f"mixing of type {node.data_type.title()} is not supported; what it feeds falls back")
        return None
    a, b = c.input(node, f"A_{kind}", path), c.input(node, f"B_{kind}", path)
    per_channel = kind == "Vector" and node.factor_mode == "NON_UNIFORM"
    fac = c.input(node, "Factor_Vector" if per_channel else "Factor_Float", path)
    if node.clamp_factor:
        fac = clamp01(c, fac)
    if kind != "Color":
        return c.emit("mix", a, b, fac)
    result = blend(c, node, a, b, fac, node.blend_type)
    return clamp01(c, result) if node.clamp_result else result


def mix_rgb(c, node, output, path):
    a, b = c.input(node, "Color1", path), c.input(node, "Color2", path)
    result = blend(c, node, a, b, clamp01(c, c.input(node, "Fac", path)), node.blend_type)
    return clamp01(c, result) if node.use_clamp else result


def color_ramp(c, node, output, path):
    ramp, fac = node.color_ramp, c.input(node, "Fac", path)
    alpha = output.identifier == "Alpha"
    if ramp.interpolation == "CONSTANT" and ramp.color_mode == "RGB":
        return _steps(c, ramp, fac, alpha)
    samples = np.array([ramp.evaluate(k / (TABLE - 1)) for k in range(TABLE)])
    return bake(c, "ramp_alpha", fac, samples[:, 3]) if alpha else bake(c, "ramp", fac, samples[:, :3])


def _steps(c, ramp, fac, alpha):
    """A ramp of constant pieces as comparisons: a table read linearly would blur its steps."""
    pieces = [
        (e.position, constant(e.color[3]) if alpha else constant(tuple(e.color))) for e in ramp.elements
    ]
    result = pieces[0][1]
    for position, color in pieces[1:]:
        before = c.emit("less_than", c.emit("channel", fac, mode=0), constant(position))
        result = c.emit("mix", color, result, before)
    return result


def _curve(c, mapping, curves, value, domain):
    """Returns the Value (one number) of `value` through `curves` in turn; linear outside where the mapping
    extends so."""

    def evaluate(x):
        for curve in curves:
            x = mapping.evaluate(curve, x)
        return x

    low, high = domain
    span = max(high - low, 1e-6)
    samples = [evaluate(low + span * k / (TABLE - 1)) for k in range(TABLE)]
    position = c.emit("divide", c.emit("subtract", value, constant(low)), constant(span))
    result = bake(c, "ramp_alpha", position, samples)
    if mapping.extend != "EXTRAPOLATED":
        return result
    ends = ((low, samples[0], "minimum", -span), (high, samples[-1], "maximum", span))
    for end, sample, side, step in ends:
        slope = (evaluate(end + step) - sample) / step
        beyond = c.emit(side, c.emit("subtract", value, constant(end)), ZERO)
        result = c.emit("multiply_add", beyond, constant(slope), result)
    return result


def _domain(curves):
    """Returns the interval that the points of `curves` span."""
    places = [point.location[0] for curve in curves for point in curve.points]
    return min(places), max(places)


def _apply_curves(c, node, path, identifier, combined):
    """Returns the Value of a three-curve node, mixed with its input by the factor."""
    mapping, value = node.mapping, c.input(node, identifier, path)
    mapping.initialize()
    through = [[mapping.curves[3], curve] if combined else [curve] for curve in mapping.curves[:3]]
    channels = [
        _curve(c, mapping, curves, c.emit("channel", value, mode=k), _domain(curves))
        for k, curves in enumerate(through)
    ]
    return c.emit("mix", value, c.emit("combine", *channels), c.input(node, "Fac", path))


def rgb_curves(c, node, output, path):
    return _apply_curves(c, node, path, "Color", combined=True)


def vector_curves(c, node, output, path):
    return _apply_curves(c, node, path, "Vector", combined=False)


def float_curve(c, node, output, path):
    mapping, value = node.mapping, c.input(node, "Value", path)
    mapping.initialize()
    result = _curve(c, mapping, mapping.curves[:1], value, _domain(mapping.curves[:1]))
    return c.emit("mix", value, result, c.input(node, "Factor", path))


def hue_saturation(c, node, output, path):
    change = c.emit("combine", *(c.input(node, name, path) for name in ("Hue", "Saturation", "Value")))
    return c.emit("hue_saturation", c.input(node, "Color", path), change, c.input(node, "Fac", path))


def bright_contrast(c, node, output, path):
    return c.emit("bright_contrast", *(c.input(node, name, path) for name in ("Color", "Bright", "Contrast")))


def gamma(c, node, output, path):
    return c.emit("gamma", c.input(node, "Color", path), c.input(node, "Gamma", path))


def invert(c, node, output, path):
    return c.emit("invert", c.input(node, "Color", path), c.input(node, "Fac", path))


def blackbody(c, node, output, path):
    return c.emit("blackbody", c.input(node, "Temperature", path))


def wavelength(c, node, output, path):
    step = constant(1 / (LAST_NM - FIRST_NM))
    nanometres = c.input(node, "Wavelength", path)
    place = c.emit("multiply", c.emit("subtract", nanometres, constant(FIRST_NM)), step)
    colors = spectrum()
    visible = c.emit(
        "maximum", c.emit("ramp", place, parameters=np.ravel(colors), mode=len(colors) - 1), ZERO
    )
    within = c.emit(
        "multiply", c.emit("less_than", place, ONE), c.emit("subtract", ONE, c.emit("less_than", place, ZERO))
    )
    return c.emit("multiply", visible, within)


def rgb_to_bw(c, node, output, path):
    return c.emit("luminance", c.input(node, "Color", path))


COLOR_MODES = {"HSV": ("rgb_to_hsv", "hsv_to_rgb"), "HSL": ("rgb_to_hsl", "hsl_to_rgb")}


def separate_color(c, node, output, path, mode=None):
    value, mode = c.value(node.inputs[0], path), mode or node.mode
    if mode in COLOR_MODES:
        value = c.emit(COLOR_MODES[mode][0], value)
    return c.emit("channel", value, mode=list(node.outputs).index(output))


def combine_color(c, node, output, path, mode=None):
    value, mode = c.emit("combine", *(c.value(socket, path) for socket in node.inputs[:3])), mode or node.mode
    return c.emit(COLOR_MODES[mode][1], value) if mode in COLOR_MODES else value


HANDLERS = {
    "MIX": mix,
    "MIX_RGB": mix_rgb,
    "VALTORGB": color_ramp,
    "CURVE_RGB": rgb_curves,
    "CURVE_VEC": vector_curves,
    "CURVE_FLOAT": float_curve,
    "HUE_SAT": hue_saturation,
    "BRIGHTCONTRAST": bright_contrast,
    "GAMMA": gamma,
    "INVERT": invert,
    "INVERT_COLOR": invert,
    "BLACKBODY": blackbody,
    "WAVELENGTH": wavelength,
    "RGBTOBW": rgb_to_bw,
    "SEPARATE_COLOR": separate_color,
    "COMBINE_COLOR": combine_color,
    "SEPHSV": lambda c, node, output, path: separate_color(c, node, output, path, "HSV"),
    "COMBHSV": lambda c, node, output, path: combine_color(c, node, output, path, "HSV"),
}
