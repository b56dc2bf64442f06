# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces and backgrounds of Mitsuba 3 as shading programs, as far as its participating media scenes need
them: diffuse, checkerboard, plastics, dielectric, thin dielectric, environment map."""

import numpy as np
from assembler import Code
from nephele import description as d
from nephele import opcodes
from truth import diffuse, glass

WATER, AIR, POLYPROPYLENE = 1.333, 1.000277, 1.49  # Mitsuba's refractive indices of these names
ROUGH = 0.1  # alpha of a rough surface that states none
# What a rough coat throws back from below is a mean over cosines. Mitsuba takes the sum over 64 nodes from 0
# to 1, both included, divided by 64: 0.5758 (by its BSDF's values) where the integral is 0.583 and our tables
# say 0.5855. The base's colour over one minus that is what counts.
ROUGH_BASE = (1 - 0.5855) / (1 - 0.5758)


def checkerboard(color0, color1, scale):
    """Diffuse; color0 where the halves of the scaled u and v are both the first or both the second."""
    code = Code()
    cells = code.run("floor", code.run("multiply", code.run("uv"), code.constant((2 * scale, 2 * scale, 0))))
    u, v = (code.run("channel", cells, mode=k) for k in range(2))
    odd = code.run("floored_modulo", code.run("add", u, v), code.constant(2))
    color = code.run("mix", code.constant(color0), code.constant(color1), odd)
    return code.program(("diffuse", 0, color, code.constant(0), None))


def plastic(reflectance, alpha):
    """Polypropylene in air, over a diffuse base; alpha: of Beckmann facets, 0 for a smooth coat."""
    code = Code()
    inputs = [code.constant(v) for v in (reflectance, np.sqrt(alpha), POLYPROPYLENE / AIR, 0)]
    return code.program(("plastic", 0, *inputs, None), mode=opcodes.DISTRIBUTIONS.index("beckmann"))


def thin_dielectric(ior):
    """A sheet without thickness: F + (1 - F)^2 F / (1 - F^2) = 2 F / (1 + F) is mirrored, the rest passes
    straight through. The Fresnel operation turns the index over on back faces; the sheet has none."""
    code = Code()
    seen = code.run("mix", code.constant(ior), code.constant(1 / ior), code.run("backfacing"))
    fresnel = code.run("fresnel", seen, code.run("normal"))
    mirrored = code.run("divide", code.run("add", fresnel, fresnel), code.run("add", 0, fresnel))
    passed = code.run("subtract", 0, mirrored)
    return code.program(("glossy", mirrored, 0, code.constant(0), None), ("transparent", passed, 0))


def environment_map(image):
    """The world of image number 0. Mitsuba's latitude-longitude map is y up, u = 0 towards -z; columns sit at
    texel centres, but the first and last rows at the poles themselves."""
    rows = image.pixels.shape[0]
    code = Code()
    x, y, z = (code.run("channel", code.run("object_coordinate"), mode=k) for k in range(3))
    back = code.run("subtract", code.constant(0), z)
    u = code.run("divide", code.run("arctan2", x, back), code.constant(2 * np.pi))
    from_pole = code.run("divide", code.run("arccosine", y), code.constant(np.pi))
    up = code.run("subtract", 0, from_pole)
    v = code.run("multiply_add", up, code.constant((rows - 1) / rows), code.constant(0.5 / rows))
    color = code.run("image", code.run("combine", u, v, code.constant(0)), parameters=(0.0,))
    return d.World(code.program(("emission", 0, color, 0)))


def surface(kind, values):
    """Returns the program of a BSDF, None for "null". values: its numbers and colours by name."""
    if kind == "null":
        return None
    if kind == "diffuse":
        return values.get("texture") or diffuse(values.get("reflectance", 0.5))
    if kind in ("plastic", "roughplastic"):
        rough = kind == "roughplastic"
        return plastic(values["diffuse_reflectance"] * (ROUGH_BASE if rough else 1), ROUGH if rough else 0)
    names = {"water": WATER, "air": AIR}
    ior = names[values["int_ior"]] / names[values["ext_ior"]]
    if kind == "dielectric":
        return glass(ior)
    if kind == "thindielectric":
        return thin_dielectric(ior)
    raise ValueError(f"no surface stands for Mitsuba's '{kind}'")
