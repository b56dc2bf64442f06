# SPDX-License-Identifier: GPL-3.0-or-later
"""The thread that renders a 3D view: coarse pictures first, newer jobs first, pauses, faults, its end. The
renderer is a stand-in whose samples take as long as it is told."""

import threading
import time
from itertools import pairwise

import numpy as np
import pytest
from nephele import description, passes
from nephele.viewport_view import View
from nephele.viewport_worker import COARSEST, FIRST_SECONDS, Job, Worker, dividers

PATIENCE = 20.0  # seconds, on a busy machine


class FakeSession:
    """seconds: that a sample takes. fault: raised by build(). building: keeps build() waiting while clear."""

    def __init__(self):
        self.seconds, self.fault, self.built = 0.0, None, []
        self.go = threading.Event()
        self.go.set()

    def build(self, scene):
        self.go.wait(PATIENCE)
        if self.fault is not None:
            raise self.fault
        self.built.append(FakeRenderer(scene, self.seconds))
        return self.built[-1]


class FakeRenderer:
    def __init__(self, scene, seconds):
        self.scene, self.seconds, self.done = scene, seconds, 0
        self.samples = scene.settings["samples"]
        self.ended, self.cancelled, self.running = threading.Event(), threading.Event(), threading.Event()
        self.running.set()

    def _run(self):
        while self.done < self.samples and not self.cancelled.is_set():
            self.cancelled.wait(self.seconds)
            while not self.running.wait(0.01) and not self.cancelled.is_set():
                pass
            if not self.cancelled.is_set():
                self.done += 1
        self.ended.set()

    def start(self):
        threading.Thread(target=self._run, daemon=True).start()

    def wait(self, seconds):
        return self.ended.wait(seconds)

    def cancel(self):
        self.cancelled.set()

    def pause(self, paused):
        (self.running.clear if paused else self.running.set)()

    def progress(self):
        return {"samples_done": self.done, "samples": self.samples, "error": None,
                "seconds": max(self.done, 1) * max(self.seconds, 0.001),
                "fraction": self.done / self.samples}  # fmt: skip

    def read_pass(self, name):
        x0, y0, x1, y1 = self.scene.film.crop
        return np.full((y1 - y0, x1 - x0, len(passes.BY_NAME[name].channels)), self.done, np.float32)


CAMERA = description.Camera("View", "perspective", np.eye(4), (-1.0, 1.0, -1.0, 1.0))


def job(samples=4, size=(640, 360), crop=True, **members):
    view = View(CAMERA, (0, 0), size, (0, 0, *size) if crop else None)
    limits = {"time_limit": 5.0, "target_error": 0.1}
    scene = description.Scene(CAMERA, description.Film(1, 1), settings=limits)
    return Job(scene, view, samples, **members)


@pytest.fixture
def worker():
    made = Worker(FakeSession())
    yield made
    made.close(PATIENCE)
    assert not made.alive


def wait_for(condition):
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.002)


def idle(worker):
    return lambda: not worker.working


def test_first_pictures_are_as_coarse_as_they_must_be():
    assert dividers(100, 1e9, 1) == [1]
    for rate in (1e3, 1e5, 1e6, 1e7):
        steps = dividers(640 * 360, rate, 1)
        assert steps[-1] == 1 and all(a == 2 * b for a, b in pairwise(steps))
        first = 640 * 360 / steps[0] ** 2 / rate
        assert first <= FIRST_SECONDS or steps[0] == COARSEST
        assert len(steps) == 1 or 4 * first > FIRST_SECONDS  # no coarser than that
    assert dividers(640 * 360, 1e3, 2) == [32, 16, 8, 4, 2]


def test_ever_finer_then_all_samples(worker):
    worker.session.seconds = 0.001
    worker.request(job(samples=6))
    wait_for(idle(worker))
    built = worker.session.built
    widths = [renderer.scene.film.width for renderer in built]
    assert widths == sorted(widths) and widths[-1] == 640 and widths[0] < 640
    assert [renderer.samples for renderer in built] == [1] * (len(built) - 1) + [6]
    assert worker.picture.place == (0, 0, 640, 360)
    assert worker.picture.pixels.shape == (360, 640, 4) and worker.picture.pixels[0, 0, 0] == 6
    assert worker.status.startswith("Sample 6/6")


def test_views_have_no_limits_but_their_samples(worker):
    worker.request(job())
    wait_for(idle(worker))
    settings = worker.session.built[-1].scene.settings
    assert (settings["samples"], settings["time_limit"], settings["target_error"]) == (4, 0.0, 0.0)
    assert settings["hierarchy"] == "by_mesh"


def test_pictures_arrive_while_it_renders(worker):
    worker.session.seconds = 0.05
    worker.request(job(samples=40, size=(64, 36)))
    seen = set()
    wait_for(lambda: seen.add(worker.picture and worker.picture.pixels[0, 0, 0]) or not worker.working)
    assert len(seen - {None}) >= 4 and 40 in seen


def test_a_newer_job_takes_over(worker):
    worker.session.seconds = 0.02
    worker.request(job(samples=100000, size=(64, 36)))
    wait_for(lambda: worker.picture is not None)
    begin = time.monotonic()
    worker.request(job(samples=2, size=(32, 18)))
    wait_for(idle(worker))
    assert worker.picture.pixels.shape[:2] == (18, 32)
    assert worker.session.built[0].cancelled.is_set()
    assert time.monotonic() - begin < PATIENCE / 4


def test_moving_on_and_on_still_shows_pictures(worker):
    """Jobs that come faster than a first picture takes do not keep it from being finished."""
    worker.session.seconds = 0.05
    worker.request(job(size=(640, 360)))
    end, seen = time.monotonic() + 1.5, []
    while time.monotonic() < end:
        time.sleep(0.01)
        worker.request(job(size=(640, 360)))
        if worker.picture is not None and worker.picture not in seen:
            seen.append(worker.picture)
    assert len(seen) >= 3
    assert all(renderer.scene.film.width < 640 for renderer in worker.session.built)


def test_pause(worker):
    worker.session.seconds = 0.005
    worker.request(job(samples=10**6, size=(64, 36)))
    wait_for(lambda: worker.picture is not None)
    worker.pause(True)
    time.sleep(0.1)
    (renderer,) = worker.session.built
    done = renderer.done
    time.sleep(0.2)
    assert renderer.done <= done + 1
    worker.pause(False)
    wait_for(lambda: renderer.done > done + 3)


def test_a_paused_worker_ends(worker):
    worker.session.seconds = 0.005
    worker.pause(True)
    worker.request(job(samples=10**6))
    time.sleep(0.1)


def test_nothing_in_the_region(worker):
    worker.request(job())
    wait_for(idle(worker))
    worker.request(job(crop=False))
    wait_for(idle(worker))
    assert worker.picture is None


def test_stop_keeps_the_picture(worker):
    worker.session.seconds = 0.005
    worker.request(job(samples=10**6, size=(64, 36)))
    wait_for(lambda: worker.picture is not None)
    worker.stop()
    wait_for(lambda: worker.session.built[-1].ended.is_set())
    assert worker.picture is not None and not worker.working
    worker.request(job(samples=3, size=(64, 36)))
    wait_for(idle(worker))
    assert worker.picture.pixels[0, 0, 0] == 3


FAULTS = (ValueError("mesh 'A': bad; mend it"), RuntimeError("full"), TypeError("bug"))


@pytest.mark.parametrize("fault", FAULTS)
def test_faults_are_told_once_and_mended(worker, fault, capsys):
    worker.session.fault = fault
    worker.request(job())
    wait_for(idle(worker))
    expected = f"internal error: TypeError: {fault}" if isinstance(fault, TypeError) else str(fault)
    assert worker.message == expected
    assert ("Traceback" in capsys.readouterr().err) == isinstance(fault, TypeError)
    worker.session.fault = None
    worker.request(job())
    assert worker.message == ""
    wait_for(idle(worker))
    assert worker.message == "" and worker.picture is not None


def test_faults_of_what_nobody_wants_any_more_are_not_told(worker):
    worker.session.go.clear()
    worker.session.fault = ValueError("the file is gone")
    worker.request(job())
    time.sleep(0.05)
    worker.request(job())
    worker.stop()
    worker.session.go.set()
    time.sleep(0.1)
    assert worker.message == ""


def test_closing_does_not_wait_for_a_build(worker):
    worker.session.go.clear()
    worker.request(job())
    time.sleep(0.05)
    session = worker.session
    begin = time.monotonic()
    worker.close()
    assert time.monotonic() - begin < 1.0 and worker.alive
    session.go.set()
    worker.close(PATIENCE)
    assert not worker.alive and worker.picture is None and worker.session is None


def test_denoised_at_powers_of_two(worker, monkeypatch):
    from nephele import viewport_worker

    counts = []

    def denoise(color, albedo, normal):
        counts.append(int(color[0, 0, 0]))
        return color

    monkeypatch.setattr(viewport_worker, "denoiser", lambda: denoise)
    monkeypatch.setattr(viewport_worker, "SHOW_SECONDS", 0.0)
    worker.session.seconds = 0.03
    worker.request(job(samples=11, size=(16, 9), denoise=True))
    wait_for(idle(worker))
    assert counts[-1] == 11
    assert set(counts[1:-1]) <= {1, 2, 4, 8}  # the first picture comes when it comes
