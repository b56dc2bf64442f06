# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: when the shutter is open and how far, and which volumes move while it is."""

import numpy as np

CURVE_SAMPLES, CURVE_PARTS = 1025, 256
SEPARATORS = ("", ".", "_")  # between name and axis of a velocity kept as three grids, as Blender has them


def shutter(render):
    """Returns (open, close), in frames from the current one; equal without motion blur."""
    if not render.use_motion_blur:
        return (0.0, 0.0)
    length = float(render.motion_blur_shutter)
    opening = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[render.motion_blur_position] * length
    return (opening, opening + length)


def shutter_curve(render):
    """Returns times in [0, 1] of the shutter that divide its light into CURVE_PARTS equal parts; () where it
    is open all the way, all the time."""
    if not render.use_motion_blur:
        return ()
    mapping = render.motion_blur_shutter_curve
    mapping.initialize()
    places = np.linspace(0.0, 1.0, CURVE_SAMPLES)
    opening = np.array([max(mapping.evaluate(mapping.curves[0], place), 0.0) for place in places])
    if np.ptp(opening) < 1e-6 or not opening.any():
        return ()
    light = np.concatenate(([0.0], np.cumsum(opening[1:] + opening[:-1])))
    even = np.linspace(0.0, light[-1], CURVE_PARTS + 1)
    return tuple(float(time) for time in np.interp(even, light, places))


def frames_per_second(render):
    return render.fps / render.fps_base


def is_blurred(context, instance):
    """Returns whether motion blur is on for the scene and for the instance (a setting that Cycles adds to
    objects: on where Cycles is absent)."""
    owners = [instance.object] if instance.parent is None else [instance.object, instance.parent]
    return context.scene.render.use_motion_blur and all(
        getattr(getattr(owner, "cycles", None), "use_motion_blur", True) for owner in owners
    )


def velocity_grids(data):
    """Returns the names of the grids that hold the velocity of Blender's volume `data`, which is loaded: one
    of vectors, or three of numbers; () where there is none."""
    available = {grid.name for grid in data.grids}
    base = data.velocity_grid or "velocity"
    split = [(data.velocity_x_grid, data.velocity_y_grid, data.velocity_z_grid)]
    split += [tuple(base + separator + axis for axis in "xyz") for separator in SEPARATORS]
    for names in [(base,), *split]:
        if available.issuperset(names):
            return names
    return ()


def velocity_scale(data, render):
    """Returns what turns the values of `data`'s velocity grids into metres per frame."""
    scale = data.velocity_scale
    return scale / frames_per_second(render) if data.velocity_unit == "SECOND" else scale
