# SPDX-License-Identifier: GPL-3.0-or-later
"""The exporter: an evaluated depsgraph to a description.Scene. It imports neither panels nor the native
module."""

import bpy

from .. import description
from .camera import export_camera
from .context import Context, ExportError
from .film import export_film, export_settings
from .motion import shutter
from .nodes import compile_world
from .objects import Objects

__all__ = ["ExportError", "export_scene"]


def export_scene(depsgraph, *, engine=None):
    """Returns the description.Scene of an evaluated depsgraph at its frame.

    engine: the RenderEngine that renders it: it knows of an overridden camera and evaluates other moments for
    motion blur; without one, objects and the camera stand still. Raises ExportError, its
    message naming what is at fault and the remedy. What is left out is named in the result's `warnings`.
    """
    context = Context(depsgraph)
    film = export_film(context)
    camera = export_camera(context, engine, film.width, film.height)
    settings = export_settings(context)
    _check_scene(context)
    objects = Objects(context)
    objects.walk()
    world = compile_world(context.scene.world, context)
    scene = description.Scene(
        camera=camera,
        film=film,
        settings=settings,
        meshes=objects.meshes,
        instances=tuple(objects.instances),
        volumes=tuple(objects.volumes),
        materials=tuple(context.materials),
        images=tuple(context.images),
        lights=(*objects.lights, *context.sky_lights),
        world=world,
        warnings=tuple(context.warnings),
        shutter=shutter(context.scene.render),
    )
    if engine is None or scene.shutter[0] == scene.shutter[1]:
        return scene
    return objects.tracks.export(engine, scene)


def _check_scene(context):
    """Warns about settings of the scene that we do not have."""
    working_space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
    if working_space != "Linear Rec.709":
        context.warn(
            f"the file's working colour space is {working_space}; colours are taken as Linear Rec.709"
        )
