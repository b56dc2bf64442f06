# SPDX-License-Identifier: GPL-3.0-or-later
"""What each operation of opcodes.py computes, in numpy, for operands known while compiling.

Every function takes arrays of three floats and returns three floats or one for all three. Operations that
need the shading point, an image or a noise table are absent. The native interpreter is the other half of this
contract: native/shading/program.h.
"""

import numpy as np

from ..opcodes import BLEND_MODES
from .blackbody import blackbody_rgb

REC709_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))


def _nonzero(x):
    """Returns `x` with 1 in place of 0, to divide by."""
    return np.where(x == 0, 1.0, x)


def _divide(a, b):
    return np.where(b == 0, 0.0, a / _nonzero(b))


def _power(a, b):
    result = np.power(a, b)
    return np.where(np.isfinite(result), result, 0.0)


def _logarithm(a, b):
    result = np.log(np.maximum(a, 1e-300)) / np.log(np.maximum(b, 1e-300))
    return np.where((a > 0) & (b > 0) & np.isfinite(result), result, 0.0)


def _smooth_min(a, b, distance):
    h = np.maximum(distance - np.abs(a - b), 0.0) / _nonzero(distance)
    return np.where(distance == 0, np.minimum(a, b), np.minimum(a, b) - h**3 * distance / 6)


def _wrap(a, high, low):
    span = high - low
    return np.where(span == 0, low, a - span * np.floor((a - low) / _nonzero(span)))


def _pingpong(a, b):
    period = 2 * _nonzero(b)
    position = a / period - np.floor(a / period)
    return np.where(b == 0, 0.0, np.abs(np.where(position > 0.5, 1 - position, position) * period))


def _ease(t, mode):
    """Map Range's interpolation of t: 0 linear, 1 smoothstep, 2 smootherstep (the last two clamp)."""
    if mode == 0:
        return t
    t = np.clip(t, 0.0, 1.0)
    return t * t * (3 - 2 * t) if mode == 1 else t**3 * (t * (t * 6 - 15) + 10)


def _map_range(a, source, target, mode):
    span = source[1] - source[0]
    t = _divide(a - source[0], span)
    return target[0] + (target[1] - target[0]) * _ease(t, mode)


def _transform(a, parameters, mode):
    matrix = np.array(parameters).reshape(3, 4)
    return matrix[:, :3] @ a + (0.0 if mode == 1 else matrix[:, 3])


def _ramp(a, parameters, mode, channels):
    table = np.array(parameters).reshape(mode + 1, channels)
    positions = np.linspace(0.0, 1.0, mode + 1)
    return np.array([np.interp(a[0], positions, table[:, k]) for k in range(channels)])


def rgb_to_hsv(rgb):
    """Returns (hue, saturation, value), hue in [0, 1)."""
    high, low = rgb.max(), rgb.min()
    return np.array((_hue(rgb, high, low), (high - low) / high if high > 0 else 0.0, high))


def hsv_to_rgb(hsv):
    """Returns the RGB of (hue, saturation, value); hue wraps."""
    shade = np.clip(np.abs((hsv[0] * 6 + np.array((0.0, 4.0, 2.0))) % 6 - 3) - 1, 0.0, 1.0)
    return hsv[2] * (1 + hsv[1] * (shade - 1))


def _rgb_to_hsl(rgb):
    high, low = rgb.max(), rgb.min()
    lightness = (high + low) / 2
    room = 2 - high - low if lightness > 0.5 else high + low
    return np.array((_hue(rgb, high, low), (high - low) / room if high > low else 0.0, lightness))


def _hsl_to_rgb(hsl):
    shade = np.clip(np.abs((hsl[0] * 6 + np.array((0.0, 4.0, 2.0))) % 6 - 3) - 1, 0.0, 1.0)
    chroma = (1 - abs(2 * hsl[2] - 1)) * hsl[1]
    return (shade - 0.5) * chroma + hsl[2]


def _hue(rgb, high, low):
    if high == low:
        return 0.0
    r, g, b = (rgb - low) / (high - low)
    sector = (g - b) if rgb[0] == high else (2 + b - r) if rgb[1] == high else (4 + r - g)
    return (sector / 6) % 1.0


def _hue_saturation(a, change, fac):
    hsv = rgb_to_hsv(a)
    hsv[0] = (hsv[0] + change[0] + 0.5) % 1.0
    hsv[1] = np.clip(hsv[1] * change[1], 0.0, 1.0)
    hsv[2] *= change[2]
    return np.maximum(a + (hsv_to_rgb(hsv) - a) * fac[0], 0.0)


def _bright_contrast(a, brightness, contrast):
    return np.maximum((1 + contrast[0]) * a + brightness[0] - contrast[0] / 2, 0.0)


def _overlay(a, b, t):
    return np.where(a < 0.5, a * (1 - t + 2 * t * b), 1 - (1 - t + 2 * t * (1 - b)) * (1 - a))


def _dodge(a, b, t):
    room = 1 - t * b
    return np.where(
        a == 0, 0.0, np.where(room <= 0, 1.0, np.minimum(a / np.where(room <= 0, 1.0, room), 1.0))
    )


def _burn(a, b, t):
    room = 1 - t + t * b
    burnt = np.clip(1 - (1 - a) / np.where(room <= 0, 1.0, room), 0.0, 1.0)
    return np.where(room <= 0, 0.0, burnt)


def _soft_light(a, b, t):
    screen = 1 - (1 - b) * (1 - a)
    return (1 - t) * a + t * ((1 - a) * b * a + a * screen)


def _component(a, b, t, of_b):
    """Hue, saturation, colour and value modes: HSV of `a` with the components `of_b` taken from `b`."""
    from_a, from_b = rgb_to_hsv(a), rgb_to_hsv(b)
    if 0 in of_b and from_b[1] == 0:  # a grey has no hue to give
        return a
    if of_b == (1,):
        if from_a[1] == 0:
            return a
        return hsv_to_rgb(np.array((from_a[0], from_a[1] + (from_b[1] - from_a[1]) * t[0], from_a[2])))
    if of_b == (2,):
        return hsv_to_rgb(np.array((from_a[0], from_a[1], from_a[2] + (from_b[2] - from_a[2]) * t[0])))
    mixed = np.array([from_b[k] if k in of_b else from_a[k] for k in range(3)])
    return a + (hsv_to_rgb(mixed) - a) * t


BLEND = {
    "mix": lambda a, b, t: a + (b - a) * t,
    "darken": lambda a, b, t: a + (np.minimum(a, b) - a) * t,
    "multiply": lambda a, b, t: a * (1 - t + t * b),
    "burn": _burn,
    "lighten": lambda a, b, t: a + (np.maximum(a, b) - a) * t,
    "screen": lambda a, b, t: 1 - (1 - t + t * (1 - b)) * (1 - a),
    "dodge": _dodge,
    "add": lambda a, b, t: a + t * b,
    "overlay": _overlay,
    "soft_light": _soft_light,
    "linear_light": lambda a, b, t: a + t * (2 * b - 1),
    "difference": lambda a, b, t: a + (np.abs(a - b) - a) * t,
    "exclusion": lambda a, b, t: np.maximum(a + (a + b - 2 * a * b - a) * t, 0.0),
    "subtract": lambda a, b, t: a - t * b,
    "divide": lambda a, b, t: np.where(b == 0, a, (1 - t) * a + t * a / _nonzero(b)),
    "hue": lambda a, b, t: _component(a, b, t, (0,)),
    "saturation": lambda a, b, t: _component(a, b, t, (1,)),
    "color": lambda a, b, t: _component(a, b, t, (0, 1)),
    "value": lambda a, b, t: _component(a, b, t, (2,)),
}


def _plain(function):
    """Adapts a function of the operands alone to the signature of FOLD's."""
    return lambda *operands, parameters, mode: function(*operands)


FOLD = {
    name: _plain(function)
    for name, function in {
        "copy": lambda a: a,
        "add": np.add,
        "subtract": np.subtract,
        "multiply": np.multiply,
        "divide": _divide,
        "multiply_add": lambda a, b, c: a * b + c,
        "power": _power,
        "logarithm": _logarithm,
        "sqrt": lambda a: np.sqrt(np.maximum(a, 0.0)),
        "inverse_sqrt": lambda a: np.where(a > 0, 1 / np.sqrt(np.where(a > 0, a, 1.0)), 0.0),
        "absolute": np.abs,
        "exponent": np.exp,
        "minimum": lambda a, b: np.where(b < a, b, a),  # no number in b leaves a, as natively
        "maximum": lambda a, b: np.where(a < b, b, a),
        "less_than": lambda a, b: (a < b).astype(float),
        "greater_than": lambda a, b: (a > b).astype(float),
        "sign": np.sign,
        "compare": lambda a, b, c: (np.abs(a - b) <= np.maximum(c, 1e-5)).astype(float),
        "smooth_min": _smooth_min,
        "smooth_max": lambda a, b, c: -_smooth_min(-a, -b, c),
        "round": lambda a: np.floor(a + 0.5),
        "floor": np.floor,
        "ceil": np.ceil,
        "truncate": np.trunc,
        "fraction": lambda a: a - np.floor(a),
        "modulo": lambda a, b: np.where(b == 0, 0.0, np.fmod(a, _nonzero(b))),
        "floored_modulo": lambda a, b: np.where(b == 0, 0.0, a - np.floor(a / _nonzero(b)) * b),
        "wrap": _wrap,
        "snap": lambda a, b: np.where(b == 0, 0.0, np.floor(a / _nonzero(b)) * b),
        "pingpong": _pingpong,
        "sine": np.sin,
        "cosine": np.cos,
        "tangent": np.tan,
        "arcsine": lambda a: np.arcsin(np.clip(a, -1.0, 1.0)),
        "arccosine": lambda a: np.arccos(np.clip(a, -1.0, 1.0)),
        "arctangent": np.arctan,
        "arctan2": np.arctan2,
        "sinh": np.sinh,
        "cosh": np.cosh,
        "tanh": np.tanh,
        "clamp": lambda a, low, high: np.minimum(np.maximum(a, low), high),
        "mix": lambda a, b, c: a + (b - a) * c,
        "dot": np.dot,
        "cross": np.cross,
        "length": np.linalg.norm,
        "normalize": lambda a: a / (np.linalg.norm(a) or 1.0),
        "distance": lambda a, b: np.linalg.norm(a - b),
        "combine": lambda a, b, c: np.array((a[0], b[0], c[0])),
        "average": np.mean,
        "luminance": lambda a: a @ REC709_LUMINANCE,
        "rgb_to_hsv": rgb_to_hsv,
        "hsv_to_rgb": hsv_to_rgb,
        "rgb_to_hsl": _rgb_to_hsl,
        "hsl_to_rgb": _hsl_to_rgb,
        "hue_saturation": _hue_saturation,
        "bright_contrast": _bright_contrast,
        "gamma": lambda a, b: np.where(a > 0, np.power(np.where(a > 0, a, 1.0), b[0]), a),
        "invert": lambda a, b: a + (1 - 2 * a) * b[0],
        "blackbody": lambda a: blackbody_rgb(a[0]),
    }.items()
} | {
    "map_range": lambda a, b, c, parameters, mode: _map_range(a, b, c, mode),
    "blend": lambda a, b, c, parameters, mode: BLEND[BLEND_MODES[mode]](a, b, c),
    "transform": lambda a, parameters, mode: _transform(a, parameters, mode),
    "channel": lambda a, parameters, mode: a[mode],
    "ramp": lambda a, parameters, mode: _ramp(a, parameters, mode, 3),
    "ramp_alpha": lambda a, parameters, mode: _ramp(a, parameters, mode, 1),
}
