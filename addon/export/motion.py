# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur: when the shutter is open, and which volumes move while it is."""

SEPARATORS = ("", ".", "_")  # between name and axis of a velocity kept as three grids, as Blender has them


def shutter(render):
    """Returns (open, close), in frames from the current one; equal without motion blur."""
    if not render.use_motion_blur:
        return (0.0, 0.0)
    length = float(render.motion_blur_shutter)
    opening = {"START": 0.0, "CENTER": -0.5, "END": -1.0}[render.motion_blur_position] * length
    return (opening, opening + length)


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
