# SPDX-License-Identifier: GPL-3.0-or-later
"""Film, passes and settings: Blender's render properties to description.Film and the settings dict."""

import numpy as np

from .. import description, parameters
from ..passes import PASSES
from .context import ExportError

# Passes that Blender offers for every engine and that we do not have: they would stay black.
OTHER_PASSES = (
    "shadow", "ambient_occlusion", "subsurface_direct", "subsurface_indirect", "subsurface_color",
)  # fmt: skip


def resolution(render):
    """Returns (width, height) of the full frame in pixels, rounded down as Blender does."""
    return (
        max(1, render.resolution_x * render.resolution_percentage // 100),
        max(1, render.resolution_y * render.resolution_percentage // 100),
    )


def border(render, width, height):
    """Returns (x0, y0, x1, y1), the pixels of the render region, or None for the full frame.

    Raises ExportError for a region without a pixel.
    """
    if not render.use_border:
        return None
    # In single precision like Blender: 0.7 * 10 must give 7.
    x0, x1 = (
        int(np.float32(side) * np.float32(width)) for side in (render.border_min_x, render.border_max_x)
    )
    y0, y1 = (
        int(np.float32(side) * np.float32(height)) for side in (render.border_min_y, render.border_max_y)
    )
    if x0 >= x1 or y0 >= y1:
        raise ExportError("the render region is smaller than a pixel; enlarge it or clear it (Ctrl Alt B)")
    return (x0, y0, x1, y1)


def enabled_passes(view_layer, scene):
    """Yields the rows of passes.PASSES that a scene's view layer asks for, Combined always."""
    for row in PASSES:
        if row.name == "Combined" or (
            asked(view_layer, scene, row) and row.levels <= view_layer.pass_cryptomatte_depth
        ):
            yield row


def asked(view_layer, scene, row):
    """Tells whether a view layer's toggle asks for a pass, or its scene for one that comes with denoising."""
    if row.denoised:
        return scene.nephele.denoise
    return getattr(*toggle_of(view_layer, row))


def toggle_of(view_layer, row):
    """Returns (owner, name) of the property that asks for a pass: Blender's, Cycles' or ours."""
    if row.view_layer:
        return view_layer, row.view_layer
    theirs = getattr(view_layer, "cycles", None)
    if row.cycles and hasattr(theirs, row.cycles):
        return theirs, row.cycles
    return view_layer.nephele, toggle_name(row)


def toggle_name(row):
    """Returns the name of our own property for a pass."""
    return f"use_pass_{row.identifier}"


def export_film(context):
    """Returns the description.Film of the view layer; warns about passes that we do not have."""
    scene, layer = context.scene, context.view_layer
    render = scene.render
    if render.use_multiview:
        raise ExportError("stereoscopy is not supported; disable it in the output properties")
    width, height = resolution(render)
    for name in OTHER_PASSES:
        if getattr(layer, f"use_pass_{name}", False):
            context.warn(
                f"view layer '{layer.name}': pass {name.replace('_', ' ').title()} is not supported; "
                "it is black"
            )
    if layer.use_pass_vector and render.use_motion_blur:
        context.warn(f"view layer '{layer.name}': with motion blur there is no pass Vector; it is black")
    if len(layer.aovs):
        context.warn(f"view layer '{layer.name}': shader AOVs are not supported; they are black")
    if len(getattr(layer, "lightgroups", ())):
        context.warn(
            f"view layer '{layer.name}': light groups are not supported; their passes are missing. Render "
            "once for each group with the other lights hidden"
        )
    return description.Film(
        width=width,
        height=height,
        crop=border(render, width, height),
        transparent=render.film_transparent,
        passes=tuple(row.name for row in enabled_passes(layer, scene)),
        mist=_mist(scene.world),
        opaque_alpha=layer.pass_alpha_threshold,
    )


def viewport_film(context):
    """Returns the description.Film of a 3D view, but for its size and passes."""
    scene = context.scene
    return description.Film(1, 1, transparent=scene.render.film_transparent, mist=_mist(scene.world))


def _mist(world):
    """Returns (start, depth, falloff) of the world's mist; Blender's defaults without a world."""
    if world is None:
        return (5.0, 25.0, "quadratic")
    mist = world.mist_settings
    return (mist.start, mist.depth, mist.falloff.lower())


def export_settings(context):
    """Returns the checked settings dict of Scene.nephele; Blender's fixed thread count counts where ours is
    0."""
    scene = context.scene
    settings = {row.name: getattr(scene.nephele, row.name) for row in parameters.PARAMETERS}
    if settings["threads"] == 0 and scene.render.threads_mode == "FIXED":
        settings["threads"] = scene.render.threads
    return parameters.checked(settings)
