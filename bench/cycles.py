# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a .blend with Blender's own path tracer, Cycles, set to solve the same equation as Nephele.

Unbiased volumes (null scattering) on grids at full precision, the same bounce limits, no clamping, filtered
caustics, adaptive sampling or denoising; light tree and guiding only where a job asks for them. Cycles runs
in a process of its own, all seeds in one; this file is also that process's script:

    python -P bench/cycles.py JOB.json OUT.npz

(-P: this folder on the module path would hide Blender's own package `cycles`; import this as bench.cycles.)
Blender 5.0 or newer: older ones march rays through volumes, with a bias.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from nephele.passes import PASSES as SHARED

# Pass names -> Blender's or Cycles' toggle and the letters in the EXR. Combined is taken without alpha.
PASSES = {row.name: (row.view_layer or row.cycles, row.channels) for row in SHARED}
PASSES["Combined"] = ("use_pass_combined", "RGB")


@dataclass(frozen=True)
class Job:
    """What to render.

    scene: path of the .blend. resolution: (width, height) in pixels. seeds: one image each. bounces:
    scattering events of a path, whatever their kind, as Nephele's `max_bounces`. pixel_filter: "BOX",
    "GAUSSIAN" or "BLACKMAN_HARRIS", filter_width in pixels (not for BOX); None: the file's own. frame: None
    for the file's. guiding: path guiding, surfaces and volumes. light_tree: choose lamps by it. persistent:
    keep what was set up from one seed to the next; without it every image pays for the whole preparation,
    which for a volume takes Cycles seconds. warm_up: render an image of one sample first, for what is
    kept."""

    scene: str
    resolution: tuple
    samples: int
    seeds: tuple
    bounces: int
    frame: int | None = None
    passes: tuple = ("Combined",)
    threads: int = 2
    pixel_filter: str | None = None
    filter_width: float = 1.5
    guiding: bool = False
    light_tree: bool = False
    persistent: bool = True
    warm_up: bool = False


@dataclass(frozen=True)
class Renders:
    """The images of a job: passes[name] is (seeds, height, width, channels) float32, top row first.

    cpu_seconds, wall_seconds: (seeds,), of the render operator: synchronisation, hierarchy, sampling, file.
    warm_up_cpu: of the image of one sample before, 0 without. peak_rss_bytes: of Blender's process. version:
    Blender's.
    """

    passes: dict
    cpu_seconds: np.ndarray
    wall_seconds: np.ndarray
    warm_up_cpu: float
    peak_rss_bytes: int
    version: str


def render(job):
    """Returns the Renders of a Job. Raises RuntimeError with Blender's words where it fails."""
    with tempfile.TemporaryDirectory() as folder:
        request, result = Path(folder, "job.json"), Path(folder, "renders.npz")
        request.write_text(json.dumps(asdict(job) | {"scene": str(job.scene)}))
        command = [sys.executable, "-P", __file__, str(request), str(result)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0 or not result.exists():
            raise RuntimeError(f"{job.scene}: Cycles failed: {done.stderr.strip() or done.stdout.strip()}")
        with np.load(result) as stored:
            images = {name: stored[f"pass {name}"] for name in job.passes}
            return Renders(
                images,
                stored["cpu_seconds"],
                stored["wall_seconds"],
                float(stored["warm_up_cpu"]),
                int(stored["peak_rss_bytes"]),
                str(stored["version"]),
            )


# ------------------------------------------------------------------------------------ inside the process


def prepare(bpy, job):
    """Opens the scene of a job and sets everything but the seed."""
    bpy.ops.wm.open_mainfile(filepath=str(Path(job["scene"]).resolve()), use_scripts=False)
    scene, layer = bpy.context.scene, bpy.context.view_layer
    if job["frame"] is not None:
        scene.frame_set(job["frame"])
    render = scene.render
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y = job["resolution"]
    render.resolution_percentage = 100
    render.threads_mode, render.threads = "FIXED", job["threads"]
    render.use_compositing = render.use_sequencer = render.use_simplify = False
    render.use_persistent_data = job["persistent"]
    render.image_settings.media_type = "MULTI_LAYER_IMAGE"
    render.image_settings.file_format = "OPEN_EXR_MULTILAYER"
    render.image_settings.color_depth = "32"
    for name in job["passes"]:
        toggle = PASSES[name][0]
        setattr(layer if hasattr(layer, toggle) else layer.cycles, toggle, True)
    layer.samples = 0
    match_settings(scene.cycles, job)
    for light in bpy.data.lights:
        # Cycles 5.0 loses light where a path in a medium meets a point or spot lamp inside it: 4 % of such a
        # lamp at the second bounce, 6 to 14 % after sixteen. Without MIS nothing but light sampling finds
        # it, and all is well.
        light.cycles.use_multiple_importance_sampling = light.type not in {"POINT", "SPOT"}
    for volume in bpy.data.volumes:
        volume.render.precision = "FULL"
        volume.render.clipping = 0.0
    return scene


def match_settings(cycles, job):
    """Sets Cycles to solve the transport equation without a short cut, up to the bounces of the job."""
    cycles.device = "CPU"
    cycles.samples = job["samples"]
    cycles.sampling_pattern = "TABULATED_SOBOL"  # shuffles every pixel and seed by itself, unlike blue noise
    for kind in ("max", "diffuse", "glossy", "transmission", "volume"):
        setattr(cycles, f"{kind}_bounces", job["bounces"])
    cycles.transparent_max_bounces = max(job["bounces"], 1024)  # no event; Cycles counts volume boundaries
    cycles.min_light_bounces = cycles.min_transparent_bounces = 0
    cycles.volume_biased = False
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.use_light_tree = job["light_tree"]
    cycles.use_auto_tile = cycles.use_fast_gi = cycles.use_animated_seed = False
    cycles.light_sampling_threshold = 0.0
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.film_exposure = 1.0
    cycles.use_guiding = job["guiding"]
    if job["pixel_filter"] is not None:
        cycles.pixel_filter_type, cycles.filter_width = job["pixel_filter"], job["filter_width"]


def cpu_seconds():
    """Returns the processor time of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def read_passes(path, names):
    """Returns dict of pass name -> (height, width, channels) of Blender's multilayer file."""
    import OpenEXR

    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {
            name: channel.pixels for part in file.parts for name, channel in part.channels.items()
        }  # "ViewLayer.Combined.R"; Blender 5 writes a part for each pass
    images = {}
    for name in names:
        layers = [next(c for c in channels if c.endswith(f".{name}.{letter}")) for letter in PASSES[name][1]]
        images[name] = np.stack([channels[layer] for layer in layers], axis=-1).astype(np.float32)
    return images


def run(job, out):
    """Renders every seed of a job and writes the arrays of Renders to the .npz file `out`."""
    import bpy

    scene = prepare(bpy, job)
    images, cpu, wall = {name: [] for name in job["passes"]}, [], []
    warm_up = 0.0
    with tempfile.TemporaryDirectory() as folder:
        if job["warm_up"]:
            begin = cpu_seconds()
            scene.cycles.samples = 1
            scene.render.filepath = str(Path(folder, "warm_up.exr"))
            bpy.ops.render.render(write_still=True)
            warm_up = cpu_seconds() - begin
            scene.cycles.samples = job["samples"]
        for seed in job["seeds"]:
            scene.cycles.seed = seed
            scene.render.filepath = str(Path(folder, f"{seed}.exr"))
            start_cpu, start_wall = cpu_seconds(), time.perf_counter()
            bpy.ops.render.render(write_still=True)
            cpu.append(cpu_seconds() - start_cpu)
            wall.append(time.perf_counter() - start_wall)
            for name, pixels in read_passes(scene.render.filepath, job["passes"]).items():
                images[name].append(pixels)
    stacks = {f"pass {name}": np.stack(stack) for name, stack in images.items()}
    told = {
        "warm_up_cpu": warm_up,
        "peak_rss_bytes": 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss,
        "version": f"Cycles of Blender {bpy.app.version_string}",
    }
    np.savez(out, cpu_seconds=cpu, wall_seconds=wall, **told, **stacks)


if __name__ == "__main__":
    run(json.loads(Path(sys.argv[1]).read_text()), sys.argv[2])
