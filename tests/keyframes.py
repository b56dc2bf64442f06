# SPDX-License-Identifier: GPL-3.0-or-later
"""Keyframes of Blender's objects, for tests of motion."""


def animate(owner, path, values):
    """Keys `path` of owner linearly: values, frame -> value."""
    for frame, value in values.items():
        setattr(owner, path, value)
        owner.keyframe_insert(path, frame=frame)
    action = owner.id_data.animation_data.action
    curves = (
        action.fcurves if hasattr(action, "fcurves") else action.layers[0].strips[0].channelbags[0].fcurves
    )
    for curve in curves:
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"
