# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders one scene by one method with one seed, and keeps the image each time that a CPU budget is spent.

Every run has a process of its own, so that its memory is its own and a crash is its own; this file is also
that process's script:

    python -P bench/slices.py JOB.json OUT.npz

CPU time counts from the built scene: what building took is told apart. An image is taken at the end of the
pass over all pixels in which its budget ran out, when all of them have the same number of samples.
"""

import dataclasses
import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

ENOUGH_SAMPLES = 2**24  # never reached: the budget ends a render
POLL_SECONDS = 0.004


@dataclass(frozen=True)
class Job:
    """description: path of a scene file (`nephele render --save-description`). settings: besides those of the
    scene. budgets: CPU seconds, ascending. passes: further ones, kept from the last image."""

    description: str
    settings: dict
    seed: int
    budgets: tuple
    passes: tuple = ()


@dataclass(frozen=True)
class Slices:
    """images: (budgets, height, width, 3) float32, top row first. cpu, samples: (budgets,), of each image.
    passes: name -> (height, width, channels) at the end. told: what the run cost, JSON values."""

    images: np.ndarray
    cpu: np.ndarray
    samples: np.ndarray
    passes: dict = field(default_factory=dict)
    told: dict = field(default_factory=dict)


class RunFailed(RuntimeError):
    """A program did not render; its words."""


def render(job):
    """Returns the Slices of a Job. Raises RunFailed with the process's last words."""
    with tempfile.TemporaryDirectory() as folder:
        request, result = Path(folder, "job.json"), Path(folder, "slices.npz")
        request.write_text(json.dumps(asdict(job)))
        command = [sys.executable, "-P", __file__, str(request), str(result)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0 or not result.exists():
            words = done.stderr.strip().splitlines()[-1:] or [f"ended with status {done.returncode}"]
            raise RunFailed(words[0])
        with np.load(result) as stored:
            passes = {name[5:]: stored[name] for name in stored.files if name.startswith("pass ")}
            told = json.loads(str(stored["told"]))
            return Slices(stored["images"], stored["cpu"], stored["samples"], passes, told)


# ------------------------------------------------------------------------------------ inside the process


def cpu_seconds():
    """Returns the processor time of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def top_first(renderer, name):
    """Returns a pass with its top row first, Combined without alpha."""
    pixels = renderer.read_pass(name)[::-1]
    return pixels[..., :3] if name == "Combined" else pixels


def pictures(renderer, budgets):
    """Yields (image, CPU seconds, samples) as the running renderer spends each budget."""
    begin = cpu_seconds()
    renderer.start()
    due, samples = 0, 0
    while due < len(budgets):
        if renderer.wait(POLL_SECONDS):
            raise RuntimeError("the render ended before its time")
        done = renderer.progress()["samples_done"]
        if done == samples:
            continue
        samples, spent = done, cpu_seconds() - begin
        if spent < budgets[due]:
            continue
        yield top_first(renderer, "Combined"), spent, samples
        while due < len(budgets) and spent >= budgets[due]:
            due += 1
    renderer.cancel()
    while not renderer.wait(1.0):
        pass


def run(job, out):
    """Renders a job (a dict) and writes the arrays of Slices to the .npz file `out`."""
    from nephele import description_file, statistics
    from nephele.bridge import create_renderer

    with tempfile.TemporaryDirectory() as folder:
        scene = description_file.load(job["description"], folder)
        film = dataclasses.replace(scene.film, passes=("Combined", *job["passes"]))
        settings = scene.settings | job["settings"] | {"seed": job["seed"], "samples": ENOUGH_SAMPLES}
        scene = dataclasses.replace(scene, film=film, settings=settings)
        before = cpu_seconds(), time.perf_counter(), statistics.peak_rss_bytes()
        renderer = create_renderer(scene)
        built = cpu_seconds(), time.perf_counter()
    images, cpu, samples = zip(*pictures(renderer, job["budgets"]), strict=True)
    native = renderer.statistics()
    width, height = scene.film.width, scene.film.height
    taken = renderer.progress()["fraction"] * ENOUGH_SAMPLES * width * height
    told = {
        "build_cpu": built[0] - before[0],
        "build_seconds": built[1] - before[1],
        "peak_rss_bytes": statistics.peak_rss_bytes(),
        "rss_before_bytes": before[2],
        "path_length": native["path_segments"] / taken,
        "lookups": native["density_lookups"] / taken,
        "train_share": native["train_seconds"] / native["render_seconds"],
        "nonfinite_samples": native["nonfinite_samples"],
        "kernel_features": list(native["kernel_features"]),
        "field": dict(native["guiding_field"]),
    }
    passes = {f"pass {name}": top_first(renderer, name) for name in job["passes"]}
    np.savez(out, images=images, cpu=cpu, samples=samples, told=json.dumps(told), **passes)


if __name__ == "__main__":
    run(json.loads(Path(sys.argv[1]).read_text()), sys.argv[2])
