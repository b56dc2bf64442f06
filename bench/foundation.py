# SPDX-License-Identifier: GPL-3.0-or-later
"""What `make bench` measures: CPU time at equal samples against Cycles 5.0, time to the first tile, memory
of a sparse grid.

Both renderers get the same .blend, 2 threads, unbiased volumes and the same bounces, in turns, and the
medians of their CPU seconds are compared: from the scene in memory to the finished image, preparation
included. Prints Markdown and writes out/bench/foundation.json.
"""

import argparse
import json
import resource
import statistics
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from bench import cycles, ours  # noqa: E402  the project's root is on the path only now

SCENES = {"cloud": (480, 270), "smoke": (240, 320)}
SAMPLES, BOUNCES = 16, 16
GRID_SIZE = 320  # voxels along an edge of the memory test's grid


def cpu_seconds():
    """Returns the processor time of this process so far."""
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def relative_mse(image, reference):
    """Returns the mean over pixels and channels of (I - R)^2 / (R^2 + 0.01)."""
    return float(np.mean((image - reference) ** 2 / (reference**2 + 0.01)))


@dataclass(frozen=True)
class Workload:
    """A .blend to render with both. bounces: of each kind, and of all together."""

    path: Path
    resolution: tuple
    samples: int = SAMPLES
    bounces: int = BOUNCES


def compare(work, repeats):
    """Returns one row: medians of CPU seconds and relMSE of both renderers."""
    rows = []
    limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), work.bounces)
    shared = {"pixel_filter": "box", "threads": 2, **limits}
    with tempfile.TemporaryDirectory() as folder:
        scene = ours.export(work.path, folder, work.resolution)
        cold = ours.render(scene, (1000,), samples=16 * work.samples, **shared)
        reference = cold[0]["Combined"][0]
        build = cold[1][0]["build_seconds"]  # later ones find the grids in memory
        for seed in range(1, repeats + 1):
            job = cycles.Job(
                str(work.path),
                work.resolution,
                work.samples,
                (seed,),
                work.bounces,
                pixel_filter="BOX",
                persistent=False,
            )
            theirs = cycles.render(job)
            before = cpu_seconds()
            mine, stats = ours.render(scene, (seed,), samples=work.samples, **shared)
            rows.append(
                {
                    "cycles_cpu": float(theirs.cpu_seconds[0]),
                    "nephele_cpu": cpu_seconds() - before,
                    "cycles_relmse": relative_mse(theirs.passes["Combined"][0], reference),
                    "nephele_relmse": relative_mse(mine["Combined"][0], reference),
                    "first_tile": stats[0]["build_seconds"] + stats[0]["first_tile_seconds"],
                    "density_lookups": stats[0]["density_lookups"],
                }
            )
    row = {key: statistics.median(r[key] for r in rows) for key in rows[0]}
    row["ratio"] = row["cycles_cpu"] / row["nephele_cpu"]
    row["runs"], row["build"] = rows, build
    return row


MEMORY_SCRIPT = """
import resource, sys
import numpy as np
from nephele import description as d, parameters
from nephele.bridge import create_renderer
volumes = (d.Volume("Grid", sys.argv[1], np.eye(4), 0),) if sys.argv[1] else ()
smoke = d.Material("Smoke", volume=(d.VolumeClosure((1.0,) * 3, density_grid="density"),))
camera = d.Camera("Camera", "perspective", np.eye(4), (-0.5, 0.5, -0.5, 0.5))
film = d.Film(16, 16)
renderer = create_renderer(d.Scene(camera, film, parameters.checked({"samples": 1}), volumes=volumes, materials=(smoke,)))
renderer.start()
renderer.wait(600)
print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024)
"""
GRID_SCRIPT = """
import sys
import bpy
sys.path.append(bpy.utils.resource_path("LOCAL") + "/python/lib/python3.11/site-packages")
import numpy as np, openvdb
size = int(sys.argv[2])
grid = openvdb.FloatGrid()
grid.copyFromArray(np.random.default_rng(1).random((size, size, size), np.float32) + 0.01)
grid.name = "density"
openvdb.write(sys.argv[1], [grid])
"""


def run_script(script, *arguments):
    """Returns the last line that a Python script prints in a process of its own. Raises
    CalledProcessError."""
    command = [sys.executable, "-c", script, *map(str, arguments)]
    return (
        subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip().rpartition("\n")[2]
    )


def measure_memory():
    """Returns the peak memory that a float grid of GRID_SIZE^3 active voxels adds, over 4 bytes a voxel."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "dense.vdb")
        run_script(GRID_SCRIPT, path, GRID_SIZE)
        added = int(run_script(MEMORY_SCRIPT, path)) - int(run_script(MEMORY_SCRIPT, ""))
    return {"active_voxels": GRID_SIZE**3, "added_bytes": added, "ratio": added / (4 * GRID_SIZE**3)}


def table(results):
    """Returns the Markdown of the results."""
    lines = [
        "| scene | Cycles CPU s | Nephele CPU s | ratio | Cycles relMSE | Nephele relMSE | scene to first tile s |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, row in results["scenes"].items():
        lines.append(
            f"| {name} {SCENES[name][0]}x{SCENES[name][1]}, {SAMPLES} spp | {row['cycles_cpu']:.2f} | "
            f"{row['nephele_cpu']:.2f} | {row['ratio']:.2f} | {row['cycles_relmse']:.4f} | "
            f"{row['nephele_relmse']:.4f} | {row['first_tile']:.3f} |"
        )
    memory = results["memory"]
    lines += [
        "",
        f"Peak memory added by a float grid of {memory['active_voxels']:,} active voxels: "
        f"{memory['added_bytes'] / 2**20:.0f} MiB, {memory['ratio']:.2f} x its voxels' float size.",
    ]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    results = {"memory": measure_memory(), "scenes": {}}
    for name, resolution in SCENES.items():
        path = ROOT / "blend_scenes" / name / f"{name}.blend"
        results["scenes"][name] = compare(Workload(path, resolution), arguments.repeats)
    out = ROOT / "out" / "bench"
    out.mkdir(parents=True, exist_ok=True)
    (out / "foundation.json").write_text(json.dumps(results, indent=2))
    print(table(results))


if __name__ == "__main__":
    main()
