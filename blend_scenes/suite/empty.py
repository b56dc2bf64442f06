# SPDX-License-Identifier: GPL-3.0-or-later
"""No volume at all: a game of chess in lamplight. Textures, glass, metal, lamps, depth of field."""

import common
import shading
from nodes import ShaderNodes
from props import box, matt
from shapes import lathe_mesh, shared

BOUNCES = 12
FOOT = [(0, 0), (0.30, 0), (0.32, 0.05), (0.28, 0.12), (0.22, 0.16), (0.16, 0.24)]
BODIES = {  # what stands on the foot, in squares
    "Pawn": [(0.11, 0.5), (0.18, 0.56), (0.1, 0.6), (0.17, 0.7), (0.18, 0.78), (0.13, 0.88), (0, 0.92)],
    "Rook": [(0.14, 0.7), (0.22, 0.78), (0.23, 1.0), (0.16, 1.0), (0.16, 0.9), (0, 0.9)],
    "Bishop": [(0.11, 0.8), (0.19, 0.86), (0.11, 0.92), (0.17, 1.04), (0.15, 1.2), (0.05, 1.34), (0, 1.44)],
    "Queen": [(0.12, 1.0), (0.21, 1.06), (0.13, 1.12), (0.22, 1.42), (0.15, 1.44), (0.07, 1.55), (0, 1.62)],
    "King": [(0.13, 1.1), (0.22, 1.16), (0.14, 1.22), (0.21, 1.54), (0.17, 1.6), (0.05, 1.84), (0, 1.86)],
}
PIECES = {"P": "Pawn", "R": "Rook", "B": "Bishop", "Q": "Queen", "K": "King"}
STAND = {
    "Ivory": "Ra1 Kg1 Qd3 Bc4 Pa2 Pb3 Pe4 Pf2 Pg2 Ph3",
    "Ebony": "Kg8 Rf8 Qe7 Bf5 Pa7 Pb6 Pd5 Pf7 Pg7 Ph6",
}


def board():
    """Chequered squares of two polished woods, veined by noise."""
    n = ShaderNodes("Board")
    place = n.coordinate()
    grain = n.node("TexNoise", Vector=n.vector("MULTIPLY", place, (1.0, 9.0, 1.0)), Scale=2.0, Detail=4.0)
    light = n.ramp(grain, (0.3, (0.62, 0.42, 0.22)), (0.7, (0.48, 0.29, 0.13)))
    dark = n.ramp(grain, (0.3, (0.11, 0.045, 0.02)), (0.7, (0.06, 0.025, 0.012)))
    lifted = n.vector("ADD", place, (0.0, 0.0, 0.5))  # the top face lies between two layers of the pattern
    wood = n.node("TexChecker", Vector=lifted, Color1=light, Color2=dark, Scale=1.0, output="Color")
    return n.finish(surface=n.node("BsdfPrincipled", Base_Color=wood, Roughness=0.18))


def build():
    shading.set_world((0.035, 0.05, 0.09))
    ivory, _ = shading.surface_material("Ivory", Base_Color=(0.80, 0.70, 0.54), Roughness=0.25)
    ebony, _ = shading.surface_material("Ebony", Base_Color=(0.035, 0.022, 0.018), Roughness=0.2)
    frame, _ = shading.surface_material("Frame", Base_Color=(0.16, 0.06, 0.03), Roughness=0.25)
    cloth = ShaderNodes("Cloth")
    weave = cloth.ramp(cloth.noise(6.0, 6.0), (0.35, (0.05, 0.09, 0.07)), (0.65, (0.10, 0.16, 0.11)))
    table = cloth.finish(surface=cloth.node("BsdfDiffuse", Color=weave))
    box("Table", (-16, -12, -1.0), (16, 16, -0.5), table)
    box("Frame", (-4.5, -4.5, -0.5), (4.5, 4.5, -0.02), frame)
    common.link("Board", common.box_mesh("Board", (-4, -4, -0.3), (4, 4, 0)), material=board())
    box("Wall", (-20, 16, -1), (20, 16.3, 18), matt("Wall", 0.30, 0.16, 0.11))
    meshes = {name: lathe_mesh(name, FOOT + body, 40) for name, body in BODIES.items()}
    for side, material in (("Ivory", ivory), ("Ebony", ebony)):
        for square in STAND[side].split():
            piece, x, y = PIECES[square[0]], "abcdefgh".index(square[1]) - 3.5, int(square[2]) - 4.5
            ob = shared(f"{side} {piece} {square[1:]}", meshes[piece], (x, y, 0), material)
            ob.scale = (1.15, 1.15, 1.15)
    glass, _ = shading.surface_material("Glass", "ShaderNodeBsdfGlass", Color=(1, 1, 1), IOR=1.5)
    tumbler = [(0, 0), (0.75, 0), (0.85, 2.2), (0.78, 2.2), (0.7, 0.3), (0, 0.3), (0, 0)]
    common.link("Tumbler", lathe_mesh("Tumbler", tumbler[:-1], 64), (5.6, 1.2, -0.5), glass)
    brass, _ = shading.surface_material("Brass", Base_Color=(0.88, 0.62, 0.28), Metallic=1.0, Roughness=0.35)
    stick = [
        (0, 0),
        (0.9, 0),
        (0.9, 0.1),
        (0.25, 0.3),
        (0.16, 1.2),
        (0.28, 1.4),
        (0.16, 1.6),
        (0.3, 2.4),
        (0, 2.4),
    ]
    common.link("Candlestick", lathe_mesh("Candlestick", stick, 48), (-6.0, 4.0, -0.5), brass)
    common.add_light("POINT", "Candle", (-6.0, 4.0, 3.4), 420.0, (1.0, 0.58, 0.24), shadow_soft_size=0.15)
    shade = {"shape": "DISK", "size": 3.0}
    common.add_light("AREA", "Lamp", (5.0, -3.0, 9.5), 800.0, (1.0, 0.80, 0.55), (0, 0.5, 0), **shade)
    window = {"shape": "RECTANGLE", "size": 4.0, "size_y": 6.0}
    common.add_light("AREA", "Window", (-13.0, 0.0, 6.0), 900.0, (0.5, 0.7, 1.0), (0, 0, 0), **window)
    camera = common.add_camera((2.4, -10.2, 4.3), (0.3, 0.3, 0.35), 42.0)
    camera.data.dof.use_dof = True
    camera.data.dof.focus_distance, camera.data.dof.aperture_fstop = 9.4, 0.16
