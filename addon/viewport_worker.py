# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds and renders what a 3D view shows, on a thread of its own. Knows no bpy.

A job is rendered in ever finer pixels, one sample each, and then in full to its last sample. A newer job
takes the place of an older one at once, but for the coarsest picture: that is always finished, or else a view
that keeps moving would show nothing.
"""

import sys
import threading
import time
import traceback
from dataclasses import dataclass, replace

import numpy as np

from . import description
from .status import status_text
from .viewport_picture import denoiser, passes_for, picture
from .viewport_view import View, coarse

FIRST_SECONDS = 0.05  # that the coarsest picture may take
COARSEST = 16  # pixels of the finest picture beside each other in one of the coarsest
FIRST_RATE = 2e5  # paths per second, until it is known
LOOK_SECONDS = 0.01  # between two looks at whether there is a newer job
STATUS_SECONDS = 0.5  # between two status texts
SHOW_SECONDS, SHOW_GROWTH, LAST_SHOW_SECONDS = 0.1, 1.3, 2.0  # between two pictures of one render


@dataclass(frozen=True, eq=False)
class Job:
    """scene: of Session.export(). samples: of the full picture. shown, denoise: see viewport_picture.py.
    finest: side of the full picture's pixels, in the region's."""

    scene: description.Scene
    view: View
    samples: int
    shown: str = "Combined"
    denoise: bool = False
    finest: int = 1

    def same(self, other):
        """Tells whether another Job, or None, gives the same picture."""
        return other is not None and description.same(self, other)


@dataclass(frozen=True, eq=False)
class Picture:
    """pixels, legend: see viewport_picture.py. place: (x, y, width, height) in the region's pixels."""

    pixels: np.ndarray
    place: tuple
    legend: str


def dividers(pixels, rate, finest):
    """Returns the sides of pixels to render with, in order. rate: paths per second."""
    steps = [finest]
    while steps[0] < COARSEST * finest and pixels / steps[0] ** 2 > rate * FIRST_SECONDS:
        steps.insert(0, 2 * steps[0])
    return steps


class Worker:
    """picture: the latest, or None. status: what it is about. message: why it stopped, "" if it did not.
    news: a number that grows with each of them. working: whether there is more to come. first_seconds: from
    the latest request that was taken up to its first picture; native_seconds: of those, build and render."""

    def __init__(self, session):
        self.session = session
        self.picture, self.status, self.message, self.news, self.working = None, "", "", 0, False
        self.first_seconds = self.native_seconds = 0.0
        self._rate = FIRST_RATE
        self._change = threading.Condition()
        self._job, self._asked, self._closed, self._paused = None, 0.0, False, False
        self._renderer = None
        self._thread = threading.Thread(target=self._run, name="nephele viewport", daemon=True)
        self._thread.start()

    def request(self, job):
        """Renders a Job in place of what was asked for before."""
        with self._change:
            self._job, self._asked, self.working, self.message = job, time.perf_counter(), True, ""
            self._change.notify_all()

    def stop(self):
        """Stops what is being rendered; the picture stays."""
        with self._change:
            self._job = None
            self.working = False
            self._change.notify_all()
        self._cancel()

    def pause(self, paused):
        """Holds the render, or lets it go on."""
        with self._change:
            if self._paused == paused:
                return
            self._paused = paused
            if self._renderer is not None:
                self._renderer.pause(paused)
            self._change.notify_all()

    @property
    def paused(self):
        return self._paused

    def close(self, seconds=0.0):
        """Ends the thread, and waits for that up to `seconds`: the building of a scene cannot be stopped."""
        with self._change:
            self._closed = True
            self._change.notify_all()
        self._cancel()
        self._thread.join(seconds)

    @property
    def alive(self):
        return self._thread.is_alive()

    def _cancel(self):
        renderer = self._renderer
        if renderer is not None:
            renderer.cancel()

    def _take(self):
        """Waits for a job and returns it with the time it was asked for; (None, 0) when there are to be no
        more."""
        with self._change:
            if self._job is None:
                self.working = False
                self._change.wait_for(lambda: self._job is not None or self._closed)
            if self._closed:
                return None, 0.0
            job, self._job = self._job, None
            return job, self._asked

    def _stale(self):
        return self._job is not None or self._closed or not self.working

    def _run(self):
        while True:
            job, asked = self._take()
            if job is None:
                break
            try:
                self._render(job, asked)
            except Exception as fault:  # noqa: BLE001 - told in the view
                self._fail(fault)
            finally:
                self._renderer = None
            del job  # while waiting for the next, nothing is held
        self.picture = self.session = self._job = None

    def _fail(self, fault):
        if self._stale():
            return
        if not isinstance(fault, ValueError | RuntimeError | MemoryError):
            traceback.print_exception(fault, file=sys.stderr)
            fault = f"internal error: {type(fault).__name__}: {fault}"
        self.message = str(fault)
        self.news += 1

    def _render(self, job, asked):
        if job.view.crop is None:
            self.picture = None
            self.news += 1
            return
        steps = dividers(job.view.pixels, self._rate, job.finest)
        for number, divider in enumerate(steps):
            if number > 0 and self._stale():
                return
            self._render_step(job, divider, asked if number == 0 else None)

    def _render_step(self, job, divider, asked):
        """Renders in pixels of one size. asked: when, where this is the job's first picture."""
        begin = time.perf_counter()
        part = coarse(job.view, divider)
        final = divider == job.finest
        scene = _scene_of(job, part, job.samples if final else 1)
        self._tell("Building scene")
        self._renderer = None  # what two scenes do not share would be there twice
        renderer = self.session.build(scene)
        with self._change:
            self._renderer = renderer
            renderer.pause(self._paused)
        renderer.start()
        try:
            self._follow(job, renderer, part, None if asked is None else (asked, begin))
        finally:
            renderer.cancel()
            while not renderer.wait(LOOK_SECONDS):
                pass

    def _follow(self, job, renderer, part, first):
        """Shows pictures while a render goes on. first: (asked, begun) of a job's first picture."""
        pause, next_show, next_status, shown = SHOW_SECONDS, 0.0, 0.0, 0
        x0, y0, x1, y1 = part.crop
        pixels = (x1 - x0) * (y1 - y0)
        over = False
        while not over:
            over = renderer.wait(LOOK_SECONDS)
            if self._closed or (self._stale() and (first is None or shown > 0)):
                return
            if not over and self._hold():
                continue
            progress = renderer.progress()
            now = time.perf_counter()
            done = progress["samples_done"]
            if shown == 0 and done > 0:
                self._rate = pixels * done / max(progress["seconds"], 1e-6)
            if done > shown and (over or now >= next_show):
                # Denoising takes longer than a few samples do: at powers of two, and the last.
                if shown == 0 or over or not job.denoise or done.bit_count() == 1:
                    self._show(job, renderer, part)
                    if shown == 0 and first is not None:
                        end = time.perf_counter()
                        self.first_seconds, self.native_seconds = end - first[0], end - first[1]
                    shown = done
                next_show, pause = time.perf_counter() + pause, min(pause * SHOW_GROWTH, LAST_SHOW_SECONDS)
            if over or now >= next_status:
                next_status = now + STATUS_SECONDS
                self._tell(status_text(progress))

    def _hold(self):
        """While paused, waits a little. Returns whether it did."""
        with self._change:
            if not self._paused:
                return False
            self._change.wait_for(lambda: not self._paused or self._stale(), 1.0)
            return True

    def _show(self, job, renderer, part):
        names = passes_for(job.shown, job.denoise)
        images = {name: renderer.read_pass(name) for name in names}
        pixels, legend = picture(job.shown, images, denoiser() if job.denoise else None)
        self.picture = Picture(pixels, part.place, legend)
        self.news += 1

    def _tell(self, status):
        if status != self.status:
            self.status = status
            self.news += 1


def _scene_of(job, part, samples):
    """Returns the description.Scene of a CoarseView."""
    film = replace(
        job.scene.film,
        width=part.width,
        height=part.height,
        crop=part.crop,
        passes=passes_for(job.shown, job.denoise),
    )
    ours = {"samples": samples, "time_limit": 0.0, "target_error": 0.0, "estimate_error": False}
    ours["hierarchy"] = "by_mesh"  # objects that are dragged about are not to wait for all triangles
    return replace(job.scene, camera=part.camera, film=film, settings=job.scene.settings | ours)
