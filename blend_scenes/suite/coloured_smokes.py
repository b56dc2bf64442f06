# SPDX-License-Identifier: GPL-3.0-or-later
"""Five plumes of dyed smoke that drift into each other before a white backdrop (those of ../smoke). Each lets
its own colour pass: sigma_t from 1.5 to 12 per metre by channel, albedo from 0.35 to 0.99; g = 0.3
everywhere."""

import common
import numpy as np
import shading
from nodes import ShaderNodes
from props import matt
from shapes import lathe_mesh, shared

BOUNCES = 48
DYES = (  # name, scattering, absorption per metre at full density; place, turn, lean, frame
    ("Red", (9.0, 1.2, 0.9), (0.1, 4.0, 4.5), (-1.55, 0.15), 0.3, 0.16, 1),
    ("Yellow", (8.0, 6.5, 0.8), (0.1, 0.6, 5.0), (-0.75, -0.15), 1.7, 0.10, 2),
    ("Green", (1.0, 7.0, 2.0), (4.0, 0.3, 3.0), (0.0, 0.2), 3.0, 0.0, 1),
    ("Blue", (0.9, 2.2, 9.0), (5.0, 2.5, 0.1), (0.8, -0.1), 4.4, -0.10, 2),
    ("Violet", (5.0, 0.9, 8.0), (1.2, 5.0, 0.3), (1.55, 0.2), 5.6, -0.16, 1),
)


def dye(name, scattering, absorption):
    """Coefficients of each channel times the grid of density."""
    n = ShaderNodes(name)
    s, a = max(scattering), max(absorption)

    def density(largest):
        return n.math("MULTIPLY", n.grid("density"), largest)

    kept, passed = tuple(c / s for c in scattering), tuple(1 - c / a for c in absorption)
    scatters = n.node("VolumeScatter", Color=kept, Density=density(s), Anisotropy=0.3)
    return n.finish(n.add(scatters, n.node("VolumeAbsorption", Color=passed, Density=density(a))))


def backdrop_mesh():
    """A sheet that bends from the floor up into the wall."""
    bend = np.linspace(0, np.pi / 2, 13)
    line = [(-12.0, 0.0), *zip(2.0 + 1.5 * np.sin(bend), 1.5 - 1.5 * np.cos(bend), strict=True), (3.5, 8.0)]
    vertices = [(x, y, z) for y, z in line for x in (-14.0, 14.0)]
    quads = [(2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2) for i in range(len(line) - 1)]
    return common.mesh_from_arrays("Backdrop", vertices, quads, smooth=True)


def build():
    shading.set_world((0.10, 0.12, 0.15))
    common.link("Backdrop", backdrop_mesh(), material=matt("Paper", 0.72, 0.70, 0.67))
    brass, _ = shading.surface_material("Brass", Base_Color=(0.85, 0.60, 0.28), Metallic=1.0, Roughness=0.3)
    profile = [(0, 0), (0.12, 0), (0.27, 0.2), (0.30, 0.3), (0.27, 0.3), (0.22, 0.2), (0, 0.1)]
    bowl = lathe_mesh("Bowl", profile)
    for name, scattering, absorption, (x, y), turn, lean, frame in DYES:
        shared(f"{name} bowl", bowl, (x, y, 0), brass)
        filepath = f"//../smoke/smoke_000{frame}.vdb"
        plume = common.add_volume(f"{name} smoke", filepath, dye(name, scattering, absorption), (x, y, 0.02))
        plume.rotation_euler, plume.scale = (0, lean, turn), (1.05, 1.05, 0.95)
    panel = {"shape": "RECTANGLE", "size": 2.0, "size_y": 2.6}
    common.add_light("AREA", "Key", (-4.2, -3.8, 4.2), 330.0, (1.0, 0.93, 0.84), (0, 0, 1.2), **panel)
    common.add_light("AREA", "Rim", (6.0, -0.6, 4.6), 230.0, (0.80, 0.90, 1.0), (0, 0, 1.4), **panel)
    common.add_camera((0.0, -7.4, 1.55), (0.0, 0.0, 1.35), 44.0)
