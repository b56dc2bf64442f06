# SPDX-License-Identifier: GPL-3.0-or-later
"""Media made by nodes, one of a kind each, under a sun, a sky, a lamp and a thin haze that fades with height.

Lower row, left to right: a box of noise through a Color Ramp; a ball of coloured scattering and absorption,
mixed by height; a grid of smoke that grids colour and heat; the same grids through arithmetic, shining by
one of them. Upper row: Rayleigh, Draine (its anisotropy varies), Fournier-Forand and Mie scattering.
Grids: 24^3 voxels of 5 cm, `density` and `heat` in [0, 1], `temperature` in kelvin, `color` three numbers.
Writes media.vdb and media.blend beside this file.
"""

import sys
from pathlib import Path

import numpy as np

FOLDER = Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent))
import common  # noqa: E402  the folder above is on the path only now
import shading  # noqa: E402
from nodes import ShaderNodes  # noqa: E402
from noise import fractal, gradient_noise, smoothstep  # noqa: E402

CELLS, VOXEL_M, SEED = 24, 0.05, 7
RADIUS = 0.6
COLUMNS = (-2.25, -0.75, 0.75, 2.25)
LOW, HIGH = 0.75, 2.3


def grids():
    """Returns ({name: array}, centre of voxel (0, 0, 0)): smoke that is hottest at its bottom."""
    origin = np.full(3, -(CELLS - 1) / 2 * VOXEL_M)
    index = np.stack(np.meshgrid(*(np.arange(CELLS),) * 3, indexing="ij"), axis=-1)
    p = (origin + index * VOXEL_M).astype(np.float32)
    flat = p.reshape(-1, 3)
    bumps = fractal(gradient_noise, flat * 4.0, SEED, 2).reshape(p.shape[:3])
    distance = np.linalg.norm(p, axis=-1) - 0.42 - 0.2 * bumps
    density = smoothstep(0.1, -0.15, distance)
    density[density < 1 / 64] = 0
    heat = smoothstep(0.4, 0.0, np.linalg.norm(p - np.array((0.0, 0.0, -0.2), np.float32), axis=-1))
    color = np.stack([smoothstep(-0.5, 0.5, p[..., axis]) for axis in range(3)], axis=-1)
    color = np.where(density[..., None] > 0, 0.15 + 0.8 * color, 0.0)
    return {
        "density": common.quantise(density, 64),
        "heat": common.quantise(heat, 64),
        "temperature": np.full((CELLS,) * 3, 2400.0),
        "color": common.quantise(color, 64),
    }, origin


def marble():
    """Noise through a ramp; the ramp's colour is both the density and the tint."""
    n = ShaderNodes("Noise")
    noise = n.node("TexNoise", Vector=n.coordinate(), Scale=2.5, Detail=1.0, Roughness=0.5)
    tone = n.ramp(noise, (0.42, (0, 0, 0)), (0.6, (1, 1, 1)))
    tint = n.ramp(noise, (0.4, (0.9, 0.5, 0.2)), (0.65, (0.4, 0.8, 0.95)))
    density = n.math("MULTIPLY", tone, 7.0)
    return n.finish(n.node("VolumePrincipled", Color=tint, Density=density, Anisotropy=0.3))


def layers():
    """Two coloured sums of scattering and absorption, one above and one below. Their phase functions are the
    same: Cycles mixes those of unlike colours in grey."""
    n = ShaderNodes("Layers")
    up = n.axis(n.coordinate(), "Z")
    side = n.map_range(n.axis(n.coordinate("Generated"), "X"), 0.1, 0.9, 0.5, 4.0)
    upper = n.add(
        n.node("VolumeScatter", Color=(0.2, 0.5, 0.9), Density=side, Anisotropy=0.3),
        n.node("VolumeAbsorption", Color=(0.9, 0.6, 0.1), Density=1.5),
    )
    lower = n.add(
        n.node("VolumeScatter", Color=(0.9, 0.3, 0.1), Density=3.0, Anisotropy=0.3),
        n.node("VolumeAbsorption", Color=(0.3, 0.6, 0.9), Density=side),
    )
    return n.finish(n.mix(n.map_range(up, -0.4, 0.4, 0.0, 1.0), lower, upper))


def burning():
    """What the Principled Volume does with a file's grids by itself. The temperature is constant, as Cycles
    reads its grid one voxel at a time, which brightens what is steep; how much burns varies."""
    n = ShaderNodes("Fire")
    fire = {"Blackbody_Intensity": n.math("MULTIPLY", n.grid("heat"), 2.0), "Blackbody_Tint": (1.0, 0.9, 0.8)}
    smoke = {"Color": (0.9, 0.9, 0.9), "Color_Attribute": "color", "Density": 8.0, "Anisotropy": 0.2}
    return n.finish(n.node("VolumePrincipled", Temperature=1.0, **smoke, **fire))


def glowing():
    """The grids through arithmetic: denser where redder, with a blackbody of its own."""
    n = ShaderNodes("Glow")
    color, heat = n.grid("color", "Color"), n.grid("heat")
    red = n.axis(color, "X")
    density = n.math("MULTIPLY", n.grid("density"), n.map_range(red, 0.2, 0.9, 1.0, 8.0))
    scatter = n.node(
        "VolumeScatter", Color=n.vector("MULTIPLY", color, color), Density=density, Anisotropy=0.0
    )
    kelvin = n.map_range(heat, 0.0, 1.0, 1950.0, 3500.0)
    strength = n.math("MULTIPLY", n.math("POWER", heat, 2.0), 4.0)
    shine = n.node("Emission", Color=n.node("Blackbody", Temperature=kelvin), Strength=strength)
    return n.finish(n.add(scatter, shine))


def scattering(name, kind, density, **inputs):
    """A phase function of its own, thinning out to the right; inputs may be functions of the nodes."""
    n = ShaderNodes(name)
    inputs = {key: value(n) if callable(value) else value for key, value in inputs.items()}
    across = n.map_range(n.axis(n.coordinate(), "X"), -0.6, 0.6, density, 0.25 * density)
    settings = {"Color": (0.9, 0.9, 0.9), "Density": across} | inputs
    return n.finish(n.node("VolumeScatter", {"phase": kind}, **settings))


def haze():
    """Fades with height, in the place of the world, without an end of its own."""
    n = ShaderNodes("Haze")
    up = n.axis(n.node("NewGeometry", output="Position"), "Z")
    density = n.math("MULTIPLY", n.math("EXPONENT", n.math("MULTIPLY", up, -1.0)), 0.03)
    return n.finish(n.node("VolumeScatter", Color=(1, 1, 1), Density=density, Anisotropy=0.4))


def main():
    """Write the grids and the scene."""
    arrays, origin = grids()
    common.write_vdb(FOLDER / "media.vdb", arrays, VOXEL_M, origin)
    common.new_scene((192, 128), 64)
    shading.set_world((0.25, 0.35, 0.5))

    def ball(name, column, height, material):
        mesh = common.sphere_mesh(name, RADIUS, 32, 16)
        common.link(name, mesh, (COLUMNS[column], 0, height), material)

    common.link("Noise", common.box_mesh("Noise", (-0.55,) * 3, (0.55,) * 3), (COLUMNS[0], 0, LOW), marble())
    ball("Layers", 1, LOW, layers())
    common.add_volume("Fire", "//media.vdb", burning(), (COLUMNS[2], 0, LOW))
    common.add_volume("Glow", "//media.vdb", glowing(), (COLUMNS[3], 0, LOW))
    ball("Rayleigh", 0, HIGH, scattering("Rayleigh", "RAYLEIGH", 3.0, Color=(0.25, 0.5, 1.0)))
    turning = {"Anisotropy": lambda n: n.map_range(n.axis(n.coordinate(), "Z"), -0.5, 0.5, -0.6, 0.8)}
    ball("Draine", 1, HIGH, scattering("Draine", "DRAINE", 3.0, Alpha=1.0, **turning))
    water = {"IOR": 1.33, "Backscatter": 0.1}
    ball("Fournier-Forand", 2, HIGH, scattering("Fournier-Forand", "FOURNIER_FORAND", 3.0, **water))
    ball("Mie", 3, HIGH, scattering("Mie", "MIE", 3.0, Diameter=10.0))
    common.link("Haze", common.box_mesh("Haze", (-5, -3, -0.05), (5, 3, 4)), material=haze())

    slate, _ = shading.surface_material("Slate", "ShaderNodeBsdfDiffuse", Color=(0.3, 0.3, 0.32))
    common.link("Ground", common.box_mesh("Ground", (-8, -8, -0.3), (8, 8, -0.1)), material=slate)
    common.add_light("SUN", "Sun", (0, 0, 6), 2.5, (1.0, 0.9, 0.75), angle=np.radians(2.0)).rotation_euler = (
        0.7, 0.3, 0.0,
    )  # fmt: skip
    panel = {"shape": "RECTANGLE", "size": 2.0, "size_y": 1.0}
    common.add_light("AREA", "Panel", (-4.0, -6.0, 5.0), 400.0, (0.8, 0.9, 1.0), (0, 0, 1.2), **panel)
    common.add_camera((0.0, -9.0, 2.2), (0.0, 0.0, 1.45), 50.0)
    print(common.save(FOLDER))


main()
