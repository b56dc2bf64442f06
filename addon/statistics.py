# SPDX-License-Identifier: GPL-3.0-or-later
"""The content of STATS.json: what was rendered, by what, on what, and what it cost.

Seconds are wall time unless named cpu.
"""

import hashlib
import json
import os
import platform
import resource
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

from .output import atomic


def process_start():
    """Returns when this process started on the clock of time.perf_counter(); elsewhere than on Linux, about
    now."""
    now = time.perf_counter()
    stat = Path("/proc/self/stat")
    if not stat.exists():
        return now
    ticks = int(stat.read_text().rpartition(")")[2].split()[19])  # field 22 of proc(5): start after boot
    return now - (time.clock_gettime(time.CLOCK_BOOTTIME) - ticks / os.sysconf("SC_CLK_TCK"))


def commit(build_info):
    """Returns the Git commit of this checkout (with "-dirty" where files differ), else the native
    module's."""
    here = Path(__file__).resolve().parent
    if not (here.parent / ".git").exists():
        return build_info.get("commit", "")
    command = ["git", "-C", str(here), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):  # no git, no commit yet, or a checkout of another user
        return build_info.get("commit", "")


def machine():
    """Returns a dict that describes the computer."""
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text().splitlines() if cpuinfo.exists() else []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return {
        "system": platform.platform(),
        "processor": models[0] if models else platform.processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
    }


def peak_rss_bytes():
    """Returns the largest resident set size that this process has had."""
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def checksums(images):
    """Returns {pass name: {"sha256": of its little-endian float32 values, bottom row first}} of a dict of
    arrays."""
    return {
        name: {"sha256": hashlib.sha256(np.ascontiguousarray(pixels, "<f4").data).hexdigest()}
        for name, pixels in images.items()
    }


def collect(scene, native, native_module, images, seconds, first_tile, context):
    """Returns the statistics of one image as a dict of JSON values.

    native: what Renderer.statistics() returned. images: dict of pass name -> array. seconds: dict of wall
    times by stage. first_tile: from the process's start to the first finished tile, Blender's own start
    included. context: further entries, such as the scene's path and frame.
    """
    build_info = dict(native_module.build_info())
    film = scene.film
    return context | {
        "version": native_module.__version__,
        "commit": commit(build_info),
        "build": build_info,
        "machine": machine(),
        "settings": scene.settings,
        "kernel_features": native["kernel_features"],
        "left_out": native["left_out"],
        "kernel": native["kernel"],
        "memory": dict(native["memory"]),
        "guiding_field": dict(native["guiding_field"]),
        "resolution": [film.width, film.height],
        "crop": film.crop,
        "samples": scene.settings["samples"],
        "samples_done": native["samples_done"],
        "target_reached": native["target_reached"],
        "errors": [dict(mark) for mark in native["errors"]],
        "seconds": seconds | {"train": native["train_seconds"], "render_cpu": native["render_cpu_seconds"]},
        "first_tile_seconds": first_tile - seconds["blender_start"],
        "process_to_first_tile_seconds": first_tile,
        "peak_rss_bytes": peak_rss_bytes(),
        "rays": native["rays"],
        "path_segments": native["path_segments"],
        "density_lookups": native["density_lookups"],
        "nonfinite_samples": native["nonfinite_samples"],
        "grids": [dict(grid) for grid in native["grids"]],
        "passes": checksums(images),
    }


def write(path, content):
    """Writes the statistics as JSON."""
    with atomic(path) as temporary:
        temporary.write_text(json.dumps(content, indent=2) + "\n")
