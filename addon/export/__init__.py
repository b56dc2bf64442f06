# SPDX-License-Identifier: GPL-3.0-or-later
"""The exporter: an evaluated depsgraph to a description.Scene. It imports neither panels nor the native
module."""

import bpy
import numpy as np

from .. import description
from . import needs
from .cache import ExportCache
from .camera import export_camera
from .context import Context, ExportError
from .film import export_film, export_settings, viewport_film
from .motion import shutter, shutter_curve
from .nodes import compile_world
from .objects import Objects

__all__ = ["ExportCache", "ExportError", "export_scene"]


# Stands in for the camera of 3D views, which move while nothing else changes.
VIEW_CAMERA = description.Camera("View", "perspective", np.eye(4), (-1.0, 1.0, -1.0, 1.0))


def export_scene(depsgraph, *, engine=None, cache=None, motion=True, space=None):
    """Returns the description.Scene of an evaluated depsgraph at its frame.

    engine: the RenderEngine that renders it: it knows of an overridden camera and evaluates other moments for
    motion blur; without one, objects and the camera stand still. cache: ExportCache of the exports of this
    scene before it: what is as it was is the same object again. The updates of `depsgraph` are believed where
    there is an engine, which must have handed each of its depsgraphs to an export with this cache, or use
    another cache from then on. motion: False for no motion blur, as in viewports. space: the SpaceView3D
    that it is for: it says what is hidden, and the caller puts in camera and film, see viewport_view.py.
    Raises ExportError, its message naming what is at fault and the remedy. What is left out is named in the
    result's `warnings`.
    """
    cache = ExportCache() if cache is None else cache
    cache.begin(depsgraph, engine, motion)
    context = Context(depsgraph, cache, space)
    if space is None:
        film = export_film(context)
        camera = export_camera(context, engine, film.width, film.height)
    else:
        film, camera = viewport_film(context), VIEW_CAMERA
    settings = export_settings(context)
    _check_scene(context)
    objects = Objects(context)
    objects.walk()
    world = compile_world(context.view_layer.world_override or context.scene.world, context)
    images = needs.images_read(context.materials, world, objects.lights)
    places = {number: place for place, number in enumerate(images)}
    scene = description.Scene(
        camera=camera,
        film=film,
        settings=settings,
        meshes=objects.meshes,
        instances=tuple(objects.instances),
        volumes=tuple(objects.volumes),
        materials=tuple(needs.renumbered(material, places) for material in context.materials),
        images=context.read_images(images),
        lights=(*(needs.renumbered(light, places) for light in objects.lights), *context.sky_lights),
        world=needs.renumbered(world, places),
        warnings=tuple(context.warnings),
        shutter=shutter(context.scene.render) if motion else (0.0, 0.0),
        shutter_curve=shutter_curve(context.scene.render) if motion else (),
    )
    if engine is not None and motion and objects.tracks.is_wanted(scene):
        scene = objects.tracks.export(engine, scene)
    cache.end(depsgraph, objects.arrays_by_name)
    return scene


def _check_scene(context):
    """Warns about settings of the scene that we do not have."""
    cycles = getattr(context.scene, "cycles", None)
    if context.scene.render.use_motion_blur and getattr(cycles, "rolling_shutter_type", "NONE") != "NONE":
        context.warn("a rolling shutter is not supported; the whole picture is exposed at once")
    working_space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
    if working_space != "Linear Rec.709":
        context.warn(
            f"the file's working colour space is {working_space}; colours are taken as Linear Rec.709"
        )
