# SPDX-License-Identifier: GPL-3.0-or-later
"""Stand-ins for the native module and the exporter, so that the command line is tested by itself.

The fake renderer averages samples that depend on (seed, sample number) only, one after the other on a thread,
with the interface of nephele_native.Renderer. SECONDS_PER_SAMPLE can be set to make it slow, INTERRUPT_AT to
have the process interrupted after that many samples.
"""

import hashlib
import os
import signal
import sys
import threading
import time
import types
from pathlib import Path

import numpy as np
from nephele import description, parameters, passes

__version__ = "0.0-fake"
FIELD = {
    "guiding_field": {"trains": True, "reason": "the fake learns", "regions": 2, "bytes": 4096, "uses": []}
}


def build_info():
    return {"compiler": "none", "commit": "0" * 40}


def scene_features(scene):
    features = ["mesh"] if scene.meshes else []
    return {"kernel_features": features, "left_out": ["volume"], "kernel": ["surfaces"]} | FIELD


SceneParts = object


class Renderer:
    SECONDS_PER_SAMPLE = 0.0
    INTERRUPT_AT = None

    def __init__(self, scene, parts=None):
        for volume in scene.volumes:
            if not Path(volume.path).is_file():
                raise ValueError(f"volume '{volume.name}': {volume.path} does not exist; check its file path")
        self.scene = scene
        self.settings = parameters.checked(scene.settings)
        film = scene.film
        x0, y0, x1, y1 = film.crop or (0, 0, film.width, film.height)
        self.shape = (y1 - y0, x1 - x0)
        self.sums = {
            name: np.zeros((*self.shape, len(passes.BY_NAME[name].channels))) for name in film.passes
        }
        self.done = 0
        self.warnings = ["the fake renders noise"]
        self.cancelled = threading.Event()
        self.thread = threading.Thread(target=self._render)
        self.seconds = 0.0

    def _render(self):
        begin = time.monotonic()
        while self.done < self.settings["samples"] and not self.cancelled.is_set():
            if 0 < self.settings["time_limit"] <= time.monotonic() - begin:
                break
            if (self.error() or 1e9) <= self.settings["target_error"]:
                break
            for name, total in self.sums.items():
                key = hashlib.sha256(f"{self.settings['seed']} {self.done} {name}".encode()).digest()
                total += np.random.default_rng(list(key)).random(total.shape)
            self.done += 1
            if self.done == self.INTERRUPT_AT:
                os.kill(os.getpid(), signal.SIGINT)
            self.cancelled.wait(self.SECONDS_PER_SAMPLE)
            self.seconds = time.monotonic() - begin

    def start(self):
        self.thread.start()

    def wait(self, seconds):
        self.thread.join(seconds)
        return not self.thread.is_alive()

    def cancel(self):
        self.cancelled.set()

    def progress(self):
        samples = self.settings["samples"]
        return {
            "state": "running" if self.thread.is_alive() else "done",
            "message": "",
            "samples_done": self.done,
            "samples": samples,
            "fraction": self.done / samples,
            "seconds": self.seconds,
            "error": self.error(),
        }

    def error(self):
        """The fake's error falls as 1 / samples."""
        told = self.settings["estimate_error"] or self.settings["target_error"] > 0
        return 1 / self.done if told and self.done else None

    def read_pass(self, name):
        return (self.sums[name] / max(self.done, 1)).astype(np.float32)

    def statistics(self):
        return {
            "kernel_features": ["mesh"],
            "left_out": [],
            "kernel": ["surfaces"],
            "memory": {"film": 0, "learning": 0, "light_tree": 0},
            "rays": 10 * self.done,
            "path_segments": 10 * self.done,
            "density_lookups": 20 * self.done,
            "nonfinite_samples": 0,
            "samples_done": self.done,
            "build_seconds": 0.0,
            "render_seconds": self.seconds,
            "render_cpu_seconds": self.seconds,
            "train_seconds": 0.0,
            "first_tile_seconds": 0.001,
            "errors": [
                {"seconds": 0.5 * n, "cpu_seconds": 1.0 * n, "samples": n, "error": 1 / n}
                for n in range(1, self.done + 1)
                if self.error() is not None
            ],
            "target_reached": (self.error() or 1e9) <= self.settings["target_error"],
            "grids": [],
        } | FIELD

    def checkpoint(self):
        return {"done": np.array(self.done)} | {f"sums/{name}": total for name, total in self.sums.items()}

    def restore(self, state):
        self.done = int(state["done"])
        for name, total in self.sums.items():
            total[...] = state[f"sums/{name}"]


def scene(width=16, height=8, film_passes=("Combined",), volumes=(), **film):
    """Returns a small description.Scene: a square under a camera."""
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    mesh = description.Mesh("Square", corners, np.array([[0, 1, 2], [0, 2, 3]], np.int32))
    camera = description.Camera("Camera", "perspective", np.eye(4), (-0.5, 0.5, -0.25, 0.25))
    return description.Scene(
        camera=camera,
        film=description.Film(width, height, passes=film_passes, **film),
        settings={"samples": 4},
        meshes=(mesh,),
        instances=(description.Instance("Square", 0, np.eye(4)),),
        volumes=volumes,
        materials=(
            description.Material("Smoke", volume=(description.VolumeClosure(density_grid="density"),)),
        ),
    )


def export_scene(depsgraph, *, engine=None, cache=None):
    """A fake exporter: the film's size and the frame are the blend's, the rest is scene()'s."""
    import bpy

    blend = depsgraph.scene
    volumes = tuple(
        description.Volume(
            instance.object.name, bpy.path.abspath(instance.object.data.filepath), np.eye(4), 0
        )
        for instance in depsgraph.object_instances
        if instance.object.type == "VOLUME"
    )
    made = scene(blend.render.resolution_x, blend.render.resolution_y, volumes=volumes)
    warnings = (f"frame {blend.frame_current}, {depsgraph.mode}",)
    return description.Scene(
        **(vars(made) | {"settings": {"samples": 4, "seed": blend.frame_current}, "warnings": warnings})
    )


def bridge():
    """Returns a module with the interface of nephele.bridge that hands out the fakes."""
    module = types.ModuleType("nephele.bridge")
    module.NativeModuleError = type("NativeModuleError", (Exception,), {})
    module.create_renderer = Renderer
    module.load_native = lambda: sys.modules[__name__]
    return module


def main():
    """The command line on the fakes, for tests that need a process of their own."""
    import nephele
    from nephele import cli

    export = types.ModuleType("nephele.export")
    export.export_scene = export_scene
    export.ExportCache = object
    export.ExportError = type("ExportError", (Exception,), {})
    sys.modules |= {"nephele.bridge": bridge(), "nephele.export": export}
    Renderer.SECONDS_PER_SAMPLE = float(os.environ.get("SECONDS_PER_SAMPLE", "0"))
    nephele.register = nephele.unregister = lambda: None
    cli.entry()


if __name__ == "__main__":
    main()
