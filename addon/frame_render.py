# SPDX-License-Identifier: GPL-3.0-or-later
"""One frame from the command line, start to end: export, build, render, write."""

import time
from concurrent.futures import ThreadPoolExecutor

from . import (
    checkpoint,
    cryptomatte,
    description_file,
    exr,
    guiding_file,
    pictures,
    rendering,
    report,
    statistics,
)
from .errors import InputError
from .output import atomic


def render_frame(request, source, frame, reporter, first, parts=None):
    """Renders `frame` of `source` (see blend_source.py) as the Request asks and writes its files.

    first: the frame's times count from the start of the process. parts: SceneParts that frames hand on, see
    bridge.py. Raises InputError, or KeyboardInterrupt once
    the checkpoint of a cancelled render is written.
    """
    begin = statistics.process_start() if first else time.perf_counter()
    seconds = {
        "blender_start": source.start_seconds if first else 0.0,
        "open": source.open_seconds if first else 0.0,
    }
    stage = time.perf_counter()
    scene = request.applied(source.export(frame))
    if request.description:
        description_file.save(request.path("description", frame), scene)
    seconds["export"] = time.perf_counter() - stage
    if request.image:
        # The fingerprint reads every VDB file again; beside the build and the render nobody waits for it.
        with ThreadPoolExecutor(1) as helper:
            fingerprint = helper.submit(description_file.fingerprint, scene)
            FrameRender(request, source, frame, reporter, scene, seconds, begin, fingerprint).run(parts)


class FrameRender:
    """The part of a frame after the export."""

    def __init__(self, request, source, frame, reporter, scene, seconds, begin, fingerprint):
        self.request, self.source, self.frame, self.reporter = request, source, frame, reporter
        self.scene, self.seconds, self.begin, self.fingerprint = scene, seconds, begin, fingerprint
        self.native_module = rendering.native_module()
        self.image_path = request.path("image", frame)
        self.checkpoint_path = checkpoint.path_for(self.image_path)

    def run(self, parts):
        """Builds, renders and writes. See render_frame()."""
        state, notes = None, []
        if self.request.resume:
            if self.checkpoint_path.exists():
                state, resumed = checkpoint.load(
                    self.checkpoint_path, self.identity(), self.scene.settings["samples"]
                )
            elif checkpoint.is_complete(self.image_path, self.identity(), self.scene.settings):
                self.reporter.say(f"{self.image_path} is complete already")
                return
            else:
                notes.append(f"{self.checkpoint_path} does not exist; starting at the first sample")
        stage = time.perf_counter()
        renderer = rendering.build(pictures.needed(self.scene), parts)
        if state is not None:
            try:
                renderer.restore(state)
            except ValueError as error:
                raise InputError(f"{self.checkpoint_path}: {error}") from error
            notes.append(f"going on after {resumed} samples per pixel")
        elif self.request.guiding_load:  # a checkpoint holds what was loaded when it began
            notes.append(self.inherit(renderer))
        self.seconds["build"] = time.perf_counter() - stage
        # Said only now, when nothing of the input can be refused any more: a refusal is a single line.
        for line in [*(f"warning: {text}" for text in self.warnings(renderer)), *notes]:
            self.reporter.say(line)
        try:
            self.render_and_write(renderer)
        except KeyboardInterrupt:
            rendering.stop(renderer)
            self.save_checkpoint(renderer)
            self.reporter.say(f"cancelled; --resume continues from {self.checkpoint_path}")
            raise

    def inherit(self, renderer):
        """Starts from what --guiding-load names. Returns a note."""
        path = self.request.guiding_load
        knowledge = guiding_file.load(path, self.scene, self.native_module.__version__)
        try:
            return f"{path}: {renderer.inherit(knowledge)} taken over"
        except ValueError as error:
            raise InputError(f"{path}: {error}") from error

    def render_and_write(self, renderer):
        """Renders to the end or the time limit, then writes every file of the frame."""
        label = "Rendering" if self.frame is None else f"Frame {self.frame}"
        self.reporter.begin(label)
        started = time.perf_counter()
        rendering.run(renderer, self.reporter)
        self.seconds["render"] = time.perf_counter() - started
        native = renderer.statistics()
        stage = time.perf_counter()
        images = pictures.pictures(renderer, self.scene)
        self.write_images(images, native)
        if not self.complete(native):
            self.save_checkpoint(renderer)
        else:
            self.checkpoint_path.unlink(missing_ok=True)
        if self.request.guiding_save:
            path = self.request.path("guiding_save", self.frame)
            guiding_file.save(path, renderer, self.scene, self.native_module.__version__)
        self.seconds["write"] = time.perf_counter() - stage
        self.seconds["total"] = time.perf_counter() - self.begin
        if self.request.report:
            self.write_report(native, images)
        if self.request.stats:
            first_tile = started - self.begin + native["first_tile_seconds"]
            self.write_statistics(renderer, native, images, first_tile)
        self.tell(native)

    def complete(self, native):
        """Tells whether nothing is left to render."""
        return native["target_reached"] or native["samples_done"] >= self.scene.settings["samples"]

    def write_images(self, images, native):
        """Writes the EXR and the PNG."""
        done, error = native["samples_done"], last_error(native)
        attributes = checkpoint.image_attributes(self.identity(), done, error)
        layer = self.source.layer
        mattes = cryptomatte.metadata(self.scene, layer, self.native_module)
        exr.write(self.image_path, images, self.scene.film, layer, attributes, mattes)
        if self.request.png:
            with atomic(self.request.path("png", self.frame)) as temporary:
                self.source.save_png(temporary, images["Combined"])

    def write_statistics(self, renderer, native, images, first_tile):
        """Writes STATS.json."""
        context = {
            "scene": self.request.scene,
            "frame": self.frame if self.frame is not None else self.source.frame,
            "image": str(self.image_path),
            "warnings": self.warnings(renderer),
        }
        content = statistics.collect(
            self.scene, native, self.native_module, images, self.seconds, first_tile, context
        )
        statistics.write(self.request.path("stats", self.frame), content)

    def write_report(self, native, images):
        """Writes the page of the error against time."""
        shown = {"machine": statistics.machine(), "settings": self.scene.settings}
        page = report.page(str(self.image_path), native, images.get("Combined"), shown)
        with atomic(self.request.path("report", self.frame)) as temporary:
            temporary.write_text(page, encoding="utf-8")

    def warnings(self, renderer):
        """Returns what the opening of the file, the export and the build left out."""
        return [*self.source.warnings, *self.scene.warnings, *renderer.warnings]

    def save_checkpoint(self, renderer):
        """Writes the checkpoint of a renderer that stands still."""
        samples_done = renderer.progress()["samples_done"]
        checkpoint.save(self.checkpoint_path, renderer, self.identity(), samples_done)

    def identity(self):
        """Returns the identity of this render, see checkpoint.py."""
        return checkpoint.identity(self.scene, self.fingerprint.result(), self.native_module.__version__)

    def tell(self, native):
        """Says what came of it."""
        done, wanted = native["samples_done"], self.scene.settings["samples"]
        if native["nonfinite_samples"]:
            self.reporter.say(f"warning: {native['nonfinite_samples']} samples were not finite and left out")
        self.reporter.say(field_line(native["guiding_field"]))
        why = "target error reached" if native["target_reached"] else "time limit; --resume continues"
        limit = f" of {wanted} ({why})" if done < wanted else ""
        error = last_error(native)
        estimate = "" if error is None else f", estimated error {error:.3g}"
        self.reporter.say(
            f"{self.image_path}: {done}{limit} samples, {self.seconds['render']:.1f} s{estimate}"
        )


def last_error(native):
    """Returns the error as Renderer.statistics() estimated it last, or None."""
    return native["errors"][-1]["error"] if native["errors"] else None


def field_line(field):
    """Returns what the guiding field was good for, in a line. field: of Renderer.statistics()."""
    if not field["trains"]:
        return f"guiding field: none ({field['reason']})"
    size = f"{field['regions']} regions, {field['bytes'] / 2**20:.1f} MiB"
    if field["uses"] is None:
        return f"guiding field: {size}, its uses still on trial"
    return f"guiding field: {size}, used for {', '.join(field['uses']) or 'nothing: it did not pay'}"
