# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky textures: a picture of the whole sky, made by Cycles in a process of its own, and a lamp for the
sun's disc."""

import functools
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

from .. import description
from .nodes_procedural import coordinate
from .nodes_program import ZERO
from .nodes_tree import upstream

SETTINGS = (
    "sky_type", "sun_disc", "sun_size", "sun_intensity", "sun_elevation", "sun_rotation", "altitude",
    "air_density", "aerosol_density", "dust_density", "ozone_density", "sun_direction", "turbidity",
    "ground_albedo",
)  # fmt: skip
SCATTERING = ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING")  # the kinds with a disc


def sky_settings(node):
    """Returns the JSON text of a node's settings, as this Blender has them: before 5.0 dust, no aerosol."""
    values = {name: getattr(node, name) for name in SETTINGS if hasattr(node, name)}
    values["sun_direction"] = tuple(values["sun_direction"])
    values["sun_disc"] = node.sun_disc and node.sky_type in SCATTERING
    return json.dumps(values)


@functools.lru_cache(maxsize=8)
def bake(settings):
    """Returns (sky (h, w, 3), sun (3,) irradiance) of sky_bake.py; None where the process failed."""
    script = str(Path(__file__).with_name("sky_bake.py"))
    with tempfile.TemporaryDirectory() as folder:
        request, result = str(Path(folder, "sky.json")), str(Path(folder, "sky.npz"))
        Path(request).write_text(settings)
        if bpy.app.binary_path:
            command = [bpy.app.binary_path, "--background", "--factory-startup", "--python", script, "--"]
        else:
            command = [sys.executable, "-P", script]
        done = subprocess.run([*command, request, result], capture_output=True, text=True, check=False)
        if done.returncode != 0 or not Path(result).exists():
            return None
        with np.load(result) as stored:
            return stored["sky"], stored["sun"]


def sky(c, node, output, path):
    baked = bake(sky_settings(node))
    if baked is None:
        c.warn(node, "Cycles could not make its picture; it is black. Bake it to an environment image")
        return ZERO
    if baked[1].any() and c.plain_sky != node:
        c.warn(node, "the sun's disc shines only where the texture alone colours the world; add a Sun lamp")
    number = c.context.picture_number("Sky", sky_settings(node), baked[0])
    return c.emit("environment", coordinate(c, node, path), parameters=(number,))


def plain_sky(world_output):
    """Returns (Sky Texture, strength) where it alone colours the world, undistorted; else (None, 0)."""
    background = upstream(world_output.inputs["Surface"])
    if background is None or background.node.type != "BACKGROUND" or background.node.mute:
        return None, 0.0
    color, strength = (background.node.inputs[name] for name in ("Color", "Strength"))
    source = upstream(color)
    plain = source is not None and source.node.type == "TEX_SKY" and not source.node.mute
    if not plain or strength.is_linked or any(s.is_linked for s in source.node.inputs):
        return None, 0.0
    return source.node, strength.default_value


def sun_lamp(world_output):
    """Returns the description.Light of the sun's disc, or None where there is none."""
    node, strength = plain_sky(world_output)
    baked = bake(sky_settings(node)) if node is not None else None
    if baked is None or not (baked[1] * strength > 0).any():
        return None
    flat = math.cos(node.sun_elevation)
    z = np.array(
        (flat * math.sin(node.sun_rotation), flat * math.cos(node.sun_rotation), math.sin(node.sun_elevation))
    )
    x = np.array((math.cos(node.sun_rotation), -math.sin(node.sun_rotation), 0.0))
    placed = np.eye(4)
    placed[:3, :3] = np.stack((x, np.cross(z, x), z), -1)  # it shines along its -z
    power = tuple(float(p) for p in np.maximum(baked[1] * strength, 0))
    return description.Light("Sky's sun", "sun", placed, power, angle=node.sun_size)


HANDLERS = {"TEX_SKY": sky}
