# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes that Blender's dependency graphs take no notice of: values of modifiers and curves that are for
renders only. A graph that is made for each render has them anyway; one that is kept would show old shapes."""

import bpy

from .history import uid

SIMPLE = {"BOOLEAN", "INT", "FLOAT", "ENUM", "STRING"}
OF_DATA = ("render_resolution_u", "render_resolution_v", "render_resolution")  # of curves and metaballs
_names = {}  # class of modifiers -> names of its values


def evaluate_unnoticed(engine, depsgraph, values):
    """Has Blender evaluate the objects whose values for renders changed since the last export, if it kept
    `depsgraph` from then without evaluating them. values: Kept of that export."""
    changed = []
    for item in depsgraph.objects:
        state = _state(item.original)
        if not state:
            continue
        before = values.get(uid(item))
        if before is not None and before != state:
            changed.append(item.original)
        values.put(uid(item), state)
    if not changed:
        return
    for item in changed:
        item.update_tag(refresh={"DATA"})
    scene = depsgraph.scene
    engine.frame_set(scene.frame_current, scene.frame_subframe)


def _state(item):
    """Returns the values that an object's shape in renders depends on, beside its data."""
    state = [getattr(item.data, name) for name in OF_DATA if hasattr(item.data, name)]
    for modifier in item.modifiers:
        state.append(modifier.type)
        state.extend(_plain(getattr(modifier, name)) for name in _names_of(type(modifier)))
    return tuple(state)


def _plain(value):
    """Returns a value that can be compared later."""
    if isinstance(value, bool | int | float | str):
        return value
    return frozenset(value) if isinstance(value, set) else tuple(value)


def _names_of(cls):
    if cls not in _names:
        skip = {*bpy.types.Modifier.bl_rna.properties.keys()} - {"show_render"}
        found = [p for p in cls.bl_rna.properties if p.type in SIMPLE and p.identifier not in skip]
        _names[cls] = [p.identifier for p in found]
    return _names[cls]
