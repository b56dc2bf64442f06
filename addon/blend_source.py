# SPDX-License-Identifier: GPL-3.0-or-later
"""A .blend as the source of scene descriptions for the command line, by way of the bpy module.

bpy is imported only when a BlendSource is made. The file's scripts do not run.
"""

import contextlib
import time
from pathlib import Path
from typing import ClassVar

from . import interrupts, noise
from .errors import InputError

EXPORT_ENGINE = "NEPHELE_EXPORT"


class BlendSource:
    """An opened .blend. Use it in a with statement: leaving it unregisters our classes, or bpy may hang at
    exit.

    layer: name of the view layer that is rendered. start_seconds: Blender's own start. open_seconds: reading
    the file.
    """

    def __init__(self, path, resolution=None, several=False):
        """resolution: (width, height) instead of the file's. several: more than one frame will be exported;
        what does not change from one to the next is kept meanwhile. Raises InputError naming the file and its
        fault."""
        self.path = path
        self._several = several
        self._undo = contextlib.ExitStack()  # what leaving has to take back
        try:
            with interrupts.deferred(), noise.hidden():
                self._start()
                self._open(resolution)
        except BaseException:
            self.close()
            raise

    def _start(self):
        begin = time.perf_counter()
        import bpy

        self._bpy = bpy
        # A user's own add-ons and preferences have no part in a render from the command line.
        bpy.ops.wm.read_factory_settings(use_empty=True)
        self.start_seconds = time.perf_counter() - begin
        from . import register, unregister

        register()
        self._undo.callback(unregister)
        self._engine = engine_class(bpy, keeps=self._several)
        bpy.utils.register_class(self._engine)
        self._undo.callback(bpy.utils.unregister_class, self._engine)

    def _open(self, resolution):
        begin = time.perf_counter()
        try:
            self._bpy.ops.wm.open_mainfile(filepath=str(Path(self.path).resolve()), use_scripts=False)
        except RuntimeError as error:
            reason = " ".join(str(error).removeprefix("Error: ").split())
            raise InputError(f"{self.path}: Blender cannot open it: {reason}") from error
        scene, view_layer = self._bpy.context.scene, self._bpy.context.view_layer
        self._scene = scene
        self.layer = view_layer.name
        self.warnings = [
            f"View layer '{other.name}' is not rendered; only the active one, '{self.layer}', is"
            for other in scene.view_layers
            if other.use and other != view_layer
        ]
        for other in scene.view_layers:
            other.use = other == view_layer
        if scene.camera is None:
            raise InputError(
                f"{self.path}: scene '{scene.name}' has no camera; add one and make it the scene's camera"
            )
        render = scene.render
        if resolution:
            render.resolution_x, render.resolution_y = resolution
            render.resolution_percentage = 100
        size = [
            int(side * render.resolution_percentage / 100)
            for side in (render.resolution_x, render.resolution_y)
        ]
        if min(size) == 0:
            raise InputError(
                f"{self.path}: scene '{scene.name}' renders {size[0]}x{size[1]} pixels; raise its resolution"
            )
        # For good: with another engine Blender would let go of the depsgraph that tells what changed.
        kept = (render.engine, render.use_compositing, render.use_sequencer, render.use_persistent_data)
        self._undo.callback(set_up, render, *kept)
        set_up(render, EXPORT_ENGINE, False, False, self._several)
        self.open_seconds = time.perf_counter() - begin

    def export(self, frame=None):
        """Returns the description.Scene of `frame` (None: the frame that the file was saved at).

        Blender evaluates it as for F12, not as the viewport shows it. Raises InputError naming the object and
        its fault.
        """
        with noise.hidden():
            if frame is not None:
                self._scene.frame_set(frame)
            self._engine.outcome.clear()
            try:
                self._bpy.ops.render.render(scene=self._scene.name)
            except RuntimeError as error:
                raise InputError(
                    f"{self.path}: Blender cannot render it: {' '.join(str(error).split())}"
                ) from error
            result = self._engine.outcome.get("result")
            if isinstance(result, InputError):
                raise InputError(f"{self.path}: {result}") from result
            if isinstance(result, BaseException):
                raise result
            if result is None:
                raise InputError(f"{self.path}: Blender rendered nothing of scene '{self._scene.name}'")
            return result

    @property
    def frame(self):
        """The current frame's number."""
        return self._scene.frame_current

    def save_png(self, path, pixels):
        """Writes (h, w, 4) float32 linear premultiplied `pixels`, bottom row first, with the scene's colour
        management."""
        height, width = pixels.shape[:2]
        with noise.hidden():
            image = self._bpy.data.images.new("Nephele PNG", width, height, alpha=True, float_buffer=True)
            settings = self._scene.render.image_settings
            try:
                image.alpha_mode = "PREMUL"
                image.pixels.foreach_set(pixels.reshape(-1))
                if hasattr(settings, "media_type"):  # Blender 5 wants it before the format
                    settings.media_type = "IMAGE"
                settings.file_format = "PNG"
                settings.color_mode = "RGBA" if self._scene.render.film_transparent else "RGB"
                settings.color_depth = "8"
                image.save_render(str(Path(path).resolve()), scene=self._scene)
            except RuntimeError as error:
                raise OSError(" ".join(str(error).split())) from error
            finally:
                self._bpy.data.images.remove(image)

    def close(self):
        """Takes our classes out of Blender."""
        with interrupts.deferred(), noise.hidden():
            self._undo.close()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


def set_up(render, engine, compositing, sequencer, persistent):
    """Says how Blender renders."""
    render.engine, render.use_compositing, render.use_sequencer = engine, compositing, sequencer
    render.use_persistent_data = persistent


def check_volumes(bpy, depsgraph):
    """Raises InputError for a volume object whose file Blender cannot read: without it the picture is
    another."""
    for instance in depsgraph.object_instances:
        data = instance.object.data
        if (
            instance.object.type != "VOLUME"
            or not data.filepath
            or (data.is_sequence and data.sequence_mode == "CLIP")
        ):
            continue
        if not data.grids.load():
            path = bpy.path.abspath(data.grids.frame_filepath or data.filepath)
            reason = data.grids.error_message or "it holds no grids"
            raise InputError(f"volume '{instance.object.name}': {path}: {' '.join(reason.split())}")


def engine_class(bpy, *, keeps=False):
    """Returns a render engine whose render is an export: only engines are given the depsgraph of a final
    render.

    Its `outcome["result"]` is the description.Scene, or what the exporter raised. keeps: each export hands on
    to the next what did not change.
    """
    from .export import ExportCache, ExportError, export_scene

    class NepheleExportEngine(bpy.types.RenderEngine):
        bl_idname = EXPORT_ENGINE
        bl_label = "Nephele Export"
        bl_use_gpu_context = False
        outcome: ClassVar[dict] = {}
        cache = None

        def render(self, depsgraph):
            cache, self.cache = self.cache, None  # it must see each state of the depsgraph that Blender keeps
            try:
                check_volumes(bpy, depsgraph)
                cache = cache if keeps and cache is not None else ExportCache()
                self.outcome["result"] = export_scene(depsgraph, engine=self, cache=cache)
                self.cache = cache
            except ExportError as error:
                self.outcome["result"] = InputError(str(error))
            except BaseException as error:  # noqa: BLE001 - handed to the caller: Blender would print it and go on
                self.outcome["result"] = error

    return NepheleExportEngine
