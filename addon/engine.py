# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine: export, native render, progress, cancel, write-back, error report. One render per view
layer.

The result of the last render stays in `last_render`; functions in `listeners` get every record as it ends.
"""

import time
from dataclasses import dataclass, field, replace

import bpy
import numpy as np

from . import bridge, cryptomatte
from .export import ExportError
from .export.film import border, enabled_passes, resolution
from .maps import FALSE_COLOURED
from .passes import lookup
from .pictures import needed, pictures
from .session import Session
from .status import clock, status_text
from .viewport import USER_FAULTS, Viewport

__all__ = ["NepheleRenderEngine", "RenderRecord", "clock", "last_render", "listeners", "status_text"]

POLL_SECONDS = 0.05  # between two looks at Escape
STATUS_SECONDS = 0.2  # between two status texts
FIRST_UPDATE_SECONDS = 1.0  # between two pictures at first; each next wait is longer by UPDATE_GROWTH
UPDATE_GROWTH, LAST_UPDATE_SECONDS = 1.25, 15.0

PREVIEW_SAMPLES = 16  # of the pictures of materials, worlds and lights in Blender's editors


@dataclass
class RenderRecord:
    """What became of one render. state: "running", "done", "cancelled" or "failed". seconds: wall time of
    "export", "build", "render" and "write". statistics: the native module's. images: the passes that the VSP
    View shows, (h, w, channels) arrays by name, bottom row first."""

    frame: int
    view_layer: str
    state: str = "running"
    message: str = ""
    warnings: list = field(default_factory=list)
    statistics: dict = field(default_factory=dict)
    seconds: dict = field(default_factory=dict)
    images: dict = field(default_factory=dict)


last_render = None
listeners = []  # called with each finished RenderRecord


class NepheleRenderEngine(bpy.types.RenderEngine):
    """Nephele as Blender's render engine."""

    bl_idname = "NEPHELE"
    bl_label = "Nephele"
    bl_use_preview = True
    bl_use_postprocess = True
    bl_use_eevee_viewport = True  # Material Preview is EEVEE's
    bl_use_shading_nodes_custom = False  # the shader nodes are Blender's own
    _session = None  # with Persistent Data: of the render before
    _viewport = None  # of an engine that draws a 3D view

    def update_render_passes(self, scene=None, renderlayer=None):
        """Blender asks which passes there are."""
        for row in enabled_passes(renderlayer, scene):
            name = blender_name(row)
            self.register_pass(scene, renderlayer, name, len(row.channels), row.channels, row.kind)

    def __del__(self):
        """Blender lets go of the engine: what is Blender's of it is gone, and refuses to be asked."""
        viewport = object.__getattribute__(self, "__dict__").get("_viewport")
        if viewport is not None:
            viewport.close()

    def view_update(self, context, depsgraph):
        """Blender says that something changed in what a 3D view shows."""
        if self._viewport is None:
            self._viewport = Viewport(self)
        self._viewport.update(self, context, depsgraph)

    def view_draw(self, context, depsgraph):
        """Blender draws a 3D view."""
        if self._viewport is not None:
            self._viewport.draw(self, context, depsgraph)

    def render(self, depsgraph):
        """Blender asks for the picture of one view layer."""
        global last_render
        # Until it has seen this depsgraph: what it missed, it would never learn of.
        session, self._session = self._session, None
        # A result must be complete before anything can fail: Blender crashes on writing a file without one.
        blank = self._begin_blank(depsgraph)
        self._built_in = set(blank.layers[0].passes.keys())  # passes that Blender makes by itself
        self.end_result(blank)
        record = RenderRecord(depsgraph.scene.frame_current, depsgraph.view_layer.name)
        if not self.is_preview:
            last_render = record
        try:
            self._render(depsgraph, record, session or Session())
        except USER_FAULTS as fault:
            self._fail(record, str(fault))
        except KeyboardInterrupt:
            record.state = "cancelled"
            raise
        except BaseException as fault:
            self._fail(record, f"internal error: {type(fault).__name__}: {fault}")
            raise
        finally:
            if not self.is_preview:
                for listener in listeners:
                    listener(record)

    def _fail(self, record, message):
        """Tells the user interface (error_set) and scripts (report) what went wrong."""
        record.state, record.message = "failed", message
        if not self.is_preview:
            self.error_set(message)
            self.report({"ERROR"}, message)

    def _begin_blank(self, depsgraph):
        """Returns a begun result of the rendered region."""
        width, height = self._region(depsgraph)
        return self.begin_result(0, 0, width, height, layer=depsgraph.view_layer.name)

    def _region(self, depsgraph):
        """Returns (width, height) of the rendered region; Blender puts it into the frame, or crops to it."""
        render = depsgraph.scene.render
        width, height = resolution(render)
        try:
            region = border(render, width, height)
        except ExportError:  # reported by the export that follows
            region = None
        return (region[2] - region[0], region[3] - region[1]) if region else (width, height)

    def _render(self, depsgraph, record, session):
        with _Timer(record, "export"):
            self.update_stats("", "Exporting scene")
            scene = session.export(depsgraph, engine=self)
            if self.is_preview:
                scene = replace(scene, settings=scene.settings | {"samples": PREVIEW_SAMPLES})
            if depsgraph.scene.render.use_persistent_data:  # Blender keeps this engine and the depsgraph
                self._session = session
        self._warn(record, scene.warnings)
        if self._cancelled_before_start(record):
            return
        with _Timer(record, "build"):
            self.update_stats("", "Building scene")
            renderer = session.build(needed(scene))
        self._warn(record, renderer.warnings)
        for row in enabled_passes(depsgraph.view_layer, depsgraph.scene):
            name = blender_name(row)
            if name not in self._built_in:
                self.add_pass(name, len(row.channels), row.channels, layer=depsgraph.view_layer.name)
        if self._cancelled_before_start(record):
            return
        result = self._begin_blank(depsgraph)
        try:
            with _Timer(record, "render"):
                self._run(renderer, result, scene.film.passes, record)
            with _Timer(record, "write"):
                images = pictures(renderer, scene)
                write_passes(result, images)
                # Python cannot read the passes of Blender's own result.
                record.images = {n: image for n, image in images.items() if n in FALSE_COLOURED}
                self._write_manifests(scene, depsgraph.view_layer.name)
        finally:
            self.end_result(result)
            record.statistics = dict(renderer.statistics())

    def _write_manifests(self, scene, layer):
        """Tells Blender, and so its files, which names the mattes' ids stand for."""
        texts = cryptomatte.metadata(scene, layer, bridge.load_native())
        for field_name, text in texts.items():
            self.get_result().stamp_data_add_field(field=field_name, value=text)

    def _warn(self, record, warnings):
        if self.is_preview:  # of scenes that are not the user's
            return
        for text in warnings:
            if text not in record.warnings:
                record.warnings.append(text)
                self.report({"WARNING"}, text)

    def _cancelled_before_start(self, record):
        if self.test_break():
            record.state = "cancelled"
        return record.state == "cancelled"

    def _run(self, renderer, result, passes, record):
        """Starts the renderer and stays until it is done or Escape is pressed."""
        scene_megabytes = _megabytes(renderer.statistics())
        self.update_memory_stats(memory_used=scene_megabytes, memory_peak=scene_megabytes)
        renderer.start()
        try:
            pause = FIRST_UPDATE_SECONDS
            now = time.monotonic()
            next_status, next_picture = now, now + pause
            while not renderer.wait(POLL_SECONDS):
                if self.test_break():
                    record.state = "cancelled"
                    break
                now = time.monotonic()
                if now >= next_status:
                    next_status = now + STATUS_SECONDS
                    self._show_progress(renderer.progress())
                if now >= next_picture:
                    write_passes(result, {name: renderer.read_pass(name) for name in passes})
                    self.update_result(result)
                    pause = min(pause * UPDATE_GROWTH, LAST_UPDATE_SECONDS)
                    next_picture = time.monotonic() + pause
        finally:  # also when a native thread failed or Ctrl C came: no thread may outlive this call
            renderer.cancel()
            while not renderer.wait(POLL_SECONDS):
                pass
        progress = renderer.progress()
        self._show_progress(progress)
        record.message = progress["message"]
        if record.state == "running":
            record.state = "cancelled" if progress["state"] == "cancelled" else "done"

    def _show_progress(self, progress):
        self.update_progress(min(max(progress["fraction"], 0.0), 1.0))
        self.update_stats(status_text(progress), "Rendering")


class _Timer:
    """Context manager that adds a stage's wall time to a record."""

    def __init__(self, record, stage):
        self._record, self._stage = record, stage

    def __enter__(self):
        self._start = time.perf_counter()

    def __exit__(self, *_):
        self._record.seconds[self._stage] = time.perf_counter() - self._start


def _megabytes(statistics):
    """Returns the size of the built scene in MiB, as far as the statistics count it."""
    grids = sum(grid["bytes"] for grid in statistics.get("grids", ()))
    return (grids + statistics.get("embree_bytes", 0)) / 2**20


def blender_name(row):
    """Returns what this Blender calls a pass."""
    return row.old_name if row.old_name and bpy.app.version < (5, 0, 0) else row.name


def write_passes(result, images):
    """Copies images by pass name into a begun result of Blender's."""
    passes = result.layers[0].passes
    for name, image in images.items():
        pixels = np.ascontiguousarray(image, np.float32)
        passes[blender_name(lookup(name))].rect.foreach_set(pixels.reshape(-1))


CLASSES = (NepheleRenderEngine,)

register, unregister = bpy.utils.register_classes_factory(CLASSES)
