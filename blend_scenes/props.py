# SPDX-License-Identifier: GPL-3.0-or-later
"""What scenes are furnished with: boxes, matt and glowing materials, clouds, suns."""

import common
import numpy as np
import shading


def box(name, low, high, material, turn=0.0):
    """A box between two corners, turned about the z axis through the middle of its base (radians)."""
    low, high = np.array(low, float), np.array(high, float)
    base = np.array([*((low + high) / 2)[:2], low[2]])
    ob = common.link(name, common.box_mesh(name, low - base, high - base), tuple(base), material)
    ob.rotation_euler = (0, 0, turn)
    return ob


def matt(name, *colour):
    """Diffuse material of a linear colour."""
    return shading.surface_material(name, "ShaderNodeBsdfDiffuse", Color=colour)[0]


def glow(name, colour, strength):
    """Emissive material: colour times strength is its radiance."""
    return shading.surface_material(name, "ShaderNodeEmission", Color=colour, Strength=strength)[0]


def cloud(name, albedo, density, g):
    """Medium of a `density` grid: albedo, extinction per metre at density 1, anisotropy."""
    inputs = {"Color": albedo, "Density": density, "Anisotropy": g}
    return shading.volume_material(name, ("ShaderNodeVolumePrincipled", inputs))


def sun_from(azimuth, elevation):
    """Unit vector towards a sun at these angles in degrees, the azimuth counted from +x towards +y."""
    azimuth, elevation = np.radians(azimuth), np.radians(elevation)
    flat = np.cos(elevation)
    return np.array([flat * np.cos(azimuth), flat * np.sin(azimuth), np.sin(elevation)])


def add_sun(direction, irradiance, colour):
    """A sun lamp, one degree wide."""
    common.add_light(
        "SUN", "Sun", tuple(20 * direction), irradiance, colour, (0, 0, 0), angle=np.radians(1.0)
    )
