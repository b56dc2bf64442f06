# SPDX-License-Identifier: GPL-3.0-or-later
"""What a step around a scene costs in the rendered 3D view: the time from the step to its first picture.

The bundled cloud, in a view of 640x360 pixels that orbits it without windows: the view's camera changes, the
worker builds, renders the coarsest picture and hands it over. For each step: native (build, render and
reading the pass), wall (from asking for it, the way to the worker's thread included), the processor's time of
the whole process until the first picture, the side of its pixels; then, left alone, the time to the first
picture in full. Prints medians in Markdown.
"""

import argparse
import statistics
import sys
import time
import types
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
SIZE = (640, 360)
PIVOT, DISTANCE = np.array((0.0, 7.0, 1.7)), 9.0
NEWS_SECONDS = 0.0005  # between two looks at the worker


def region_data(angle):
    """Returns what a region looks at from `angle`, rad around the cloud."""
    c, s = np.cos(angle), np.sin(angle)
    world_from_view = np.eye(4)
    world_from_view[:3, :3] = np.array([[c, 0, s], [s, 0, -c], [0, 1, 0]])  # x right, y up, z towards us
    world_from_view[:3, 3] = PIVOT + DISTANCE * world_from_view[:3, 2]
    half = 0.36
    window = np.zeros((4, 4))
    window[0, 0], window[1, 1], window[2, 2], window[3, 2] = 1 / half, SIZE[0] / SIZE[1] / half, -1, -1
    return types.SimpleNamespace(
        view_matrix=np.linalg.inv(world_from_view), window_matrix=window, is_perspective=True
    )


def wait(condition):
    while not condition():
        time.sleep(NEWS_SECONDS)


def measure(steps, full):
    """Returns rows (native, wall, cpu, divider, seconds to the first full picture or None) of each step."""
    import bpy
    from nephele.session import Session
    from nephele.viewport_view import view_of
    from nephele.viewport_worker import Job, Worker

    session = Session()
    space = types.SimpleNamespace(clip_start=0.1, clip_end=1000.0, use_render_border=False)
    real_space = next(a for s in bpy.data.screens for a in s.areas if a.type == "VIEW_3D").spaces.active
    scene = session.export(bpy.context.evaluated_depsgraph_get(), motion=False, space=real_space)
    region = types.SimpleNamespace(width=SIZE[0], height=SIZE[1])
    worker, rows = Worker(session), []
    for step in range(steps + 3):
        view = view_of(region, region_data(0.05 * step), space, bpy.context.scene.render)
        seen = worker.picture
        begin, cpu = time.perf_counter(), time.process_time()
        worker.request(Job(scene, view, samples=1 if full else 64))
        wait(lambda seen=seen: worker.picture is not seen)
        cpu, picture = time.process_time() - cpu, worker.picture
        row = [worker.native_seconds, worker.first_seconds, cpu, SIZE[0] / picture.pixels.shape[1], None]
        if full:
            wait(lambda: not worker.working)
            row[-1] = time.perf_counter() - begin
        rows.append(row)
        if worker.message:
            sys.exit(worker.message)
    worker.close(60)
    return rows[3:]  # the first steps read files and learn how fast this is


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=40)
    arguments = parser.parse_args()
    sys.path[0] = str(ROOT)  # not this folder, whose names Blender's add-ons have too
    import bpy
    import nephele

    bpy.ops.wm.read_factory_settings(use_empty=False)
    nephele.register()
    bpy.ops.wm.open_mainfile(filepath=str(ROOT / "blend_scenes/cloud/cloud.blend"), load_ui=False)
    print("| view | native ms | wall ms | CPU ms | slowest wall ms | side of pixels | full picture ms |")
    print("|---|---|---|---|---|---|---|")
    for name, full in (("keeps moving", False), ("rests after each step", True)):
        rows = measure(arguments.steps, full)
        native, wall, cpu, side, whole = zip(*rows, strict=True)
        cells = [f"{1000 * statistics.median(column):.0f}" for column in (native, wall, cpu)]
        cells += [f"{1000 * max(wall):.0f}", f"{statistics.median(side):.0f}"]
        cells.append(f"{1000 * statistics.median(whole):.0f}" if full else "")
        print(f"| {name} | {' | '.join(cells)} |", flush=True)
    nephele.unregister()


main()
