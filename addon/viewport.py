# SPDX-License-Identifier: GPL-3.0-or-later
"""The rendered 3D view: what Blender's view_update and view_draw ask of an engine, one Viewport for each.

All here runs on Blender's main thread: export, and drawing what the Worker has ready. A timer looks at the
workers and has regions drawn anew where there is something new to see.
"""

import atexit
import traceback
import types
import weakref
from dataclasses import replace

import bpy

from . import bridge
from .export import ExportError
from .export.camera import export_camera
from .export.context import Context
from .export.film import export_settings, resolution, viewport_film
from .export.space import viewplane
from .session import Session
from .viewport_view import view_of
from .viewport_worker import Job, Worker

LOOK_SECONDS = 0.04  # between two looks at the workers
HIDDEN_AFTER = 40  # looks at which a region was to be drawn and was not: it is hidden
CLOSE_SECONDS = 60.0  # that threads get when the add-on goes

USER_FAULTS = (ExportError, bridge.NativeModuleError, ValueError, RuntimeError, MemoryError)

_open = weakref.WeakSet()  # Viewports
_closing = []  # Workers that were told to end


class Viewport:
    """One region's. Blender has an engine of its own for each."""

    def __init__(self, engine):
        self._engine = weakref.ref(engine)
        self._session = self._worker = self._drawing = None
        self._scene = None  # as exported last; None where that failed
        self._job = None  # as asked for last
        self._message = self._told = ""
        self._news, self._unseen = -1, 0
        _open.add(self)

    def update(self, engine, context, depsgraph):
        """Something changed in the scene."""
        try:
            if self._session is None:
                self._session = Session()
            scene = self._session.export(depsgraph, engine=engine, motion=False, space=context.space_data)
        except USER_FAULTS as fault:
            self._fail(str(fault))
        except Exception as fault:  # noqa: BLE001 - an exception would come back with every update
            self._session = None
            self._fail(self._bug(fault))
        else:
            self._message = ""
            if self._scene is None or not scene_same(scene, self._scene):
                self._scene = scene
        engine.tag_redraw()

    def draw(self, engine, context, depsgraph):
        """Draws what there is, and asks for what is to be seen from now on."""
        self._unseen = 0
        if self._scene is not None:
            try:
                self._ask(engine, context, depsgraph)
            except USER_FAULTS as fault:
                self._stop(str(fault))
            except Exception as fault:  # noqa: BLE001 - and with every redraw
                self._stop(self._bug(fault))
        worker = self._worker
        picture = None
        if worker is not None:
            self._news = worker.news
            worker.pause(False)
            picture = worker.picture
        if picture is not None:
            if self._drawing is None:
                from .viewport_draw import Drawing

                self._drawing = Drawing()
            self._drawing.draw(engine, depsgraph.scene, picture)
        self._tell(engine, picture)
        _start_looking()

    def look(self):
        """Has the region drawn where there is news. Returns whether there may be more."""
        worker, engine = self._worker, self._engine()
        if worker is None or engine is None:
            return False
        if worker.news != self._news:
            engine.tag_redraw()
            self._unseen += 1
            if self._unseen >= HIDDEN_AFTER:
                worker.pause(True)
        return (worker.working and not worker.paused) or (
            worker.news != self._news and self._unseen < HIDDEN_AFTER
        )

    def distrust(self):
        """Undo and redo put other data in the place of those that were exported."""
        if self._session is not None:
            self._session.distrust()

    def close(self):
        """Lets go of everything."""
        _open.discard(self)
        if self._worker is not None:
            self._worker.close()
            _closing.append(self._worker)
        _closing[:] = [worker for worker in _closing if worker.alive]
        self._worker = self._session = self._scene = self._job = self._drawing = None

    def _ask(self, engine, context, depsgraph):
        """Asks the worker for what the view shows, where that is not what was asked for last."""
        scene, shading = depsgraph.scene, context.space_data.shading.nephele
        inner = Context(depsgraph, space=context.space_data)
        inner.scene = scene  # not every setting that changes has Blender evaluate the scene again
        settings, film = export_settings(inner), viewport_film(inner)
        if (settings, film) != (self._scene.settings, self._scene.film):
            self._scene = replace(self._scene, settings=settings, film=film)
        through = ()
        if context.region_data.view_perspective == "CAMERA":
            through = camera_and_frame(inner, context.space_data.camera, scene.render)
        view = view_of(context.region, context.region_data, context.space_data, scene.render, *through)
        job = Job(
            scene=self._scene,
            view=view,
            samples=settings["viewport_samples"],
            shown=shading.shown_pass(),
            denoise=shading.denoise,
            finest=engine.get_preview_pixel_size(scene),
        )
        if self._worker is None:
            self._worker = Worker(self._session)
        if not job.same(self._job):
            self._job, self._message = job, ""
            self._worker.session = self._session
            self._worker.request(job)

    def _bug(self, fault):
        """Returns what to say of a fault that is ours, whose traceback is printed once."""
        message = f"internal error: {type(fault).__name__}: {fault}"
        if message != self._message:
            traceback.print_exception(fault)
        return message

    def _fail(self, message):
        self._scene = None
        self._stop(message)

    def _stop(self, message):
        self._job, self._message = None, message
        if self._worker is not None:
            self._worker.stop()

    def _tell(self, engine, picture):
        """Writes what it is about into the view's corner."""
        worker = self._worker
        text = self._message or (worker.message if worker is not None else "")
        if not text and worker is not None:
            text = " | ".join(filter(None, (worker.status, picture.legend if picture else "")))
        if text != self._told:
            engine.update_stats("", text)
            self._told = text


def scene_same(scene, other):
    """Tells whether two exports give the same pictures, whatever their warnings."""
    from .description import same

    return same(replace(scene, warnings=()), replace(other, warnings=()))


def camera_and_frame(context, camera, render):
    """Returns what view_of() wants to know of the object that a view looks through; () where that is no
    camera. Raises ExportError."""
    if camera is None or camera.type != "CAMERA":
        return ()
    width, height = resolution(render)
    described = export_camera(context, types.SimpleNamespace(camera_override=camera), width, height)
    evaluated = camera.evaluated_get(context.depsgraph)
    matrix = evaluated.calc_matrix_camera(
        context.depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
    )
    return described, viewplane(matrix, evaluated.data.type != "ORTHO")


def _look():
    """Timer: looks at all viewports."""
    more = [viewport.look() for viewport in list(_open)]
    return LOOK_SECONDS if any(more) else None


def _start_looking():
    if not bpy.app.timers.is_registered(_look):
        bpy.app.timers.register(_look, first_interval=LOOK_SECONDS, persistent=True)


@bpy.app.handlers.persistent
def _distrust(*_):
    for viewport in list(_open):
        viewport.distrust()


def close_all():
    """Closes every viewport, and waits for their threads."""
    for viewport in list(_open):
        viewport.close()
    for worker in _closing:
        worker.close(CLOSE_SECONDS)
    _closing.clear()


HANDLERS = ("undo_post", "redo_post")


def register():
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).append(_distrust)
    atexit.register(close_all)


def unregister():
    atexit.unregister(close_all)
    for name in HANDLERS:
        getattr(bpy.app.handlers, name).remove(_distrust)
    if bpy.app.timers.is_registered(_look):
        bpy.app.timers.unregister(_look)
    close_all()
