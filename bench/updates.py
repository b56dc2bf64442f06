# SPDX-License-Identifier: GPL-3.0-or-later
"""What a change costs: the time from a change in Blender to the first pixels, and memory.

A scene of 5 million triangles in 40 meshes of their own (bumpy balls, with UV maps and a material each),
three VDB volumes, two lamps and a world is rendered in a Blender that keeps its dependency graph; then one
thing changes after the other. For each: Blender's own evaluation, export, build, start to the first tile of
the first sample, the sum without Blender's share, and the processor's time of export and build. Prints
Markdown and writes out/bench/updates_HIERARCHY.json.
"""

import argparse
import dataclasses
import json
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
BALLS, ROWS, VOLUMES, SAMPLES = 40, 250, 3, 4
STAGES = ("blender", "export", "build", "first_tile")
COLUMNS = (*STAGES, "total", "cpu")
HEAD = "| hierarchy | change | Blender | export | build | first tile | total | CPU | peak, GB |"


def peak_gigabytes():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20


def ball(bpy, name, rows, phase):
    """Returns a mesh of 4 rows^2 triangles: a ball of radius 1 with bumps."""
    columns = 2 * rows
    theta, phi = np.meshgrid(
        np.linspace(0, np.pi, rows + 1), np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij"
    )
    radius = 1 + 0.03 * np.sin(15 * theta + phase) * np.cos(12 * phi)
    points = radius[..., None] * np.stack(
        (np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)), -1
    )
    row, column = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    right = (column + 1) % columns
    a, b = row * columns + column, row * columns + right
    faces = np.stack((a, a + columns, b + columns, a, b + columns, b), -1).reshape(-1, 3).astype(np.int32)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(points.size // 3)
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    mesh.update(calc_edges=True)
    uv = mesh.uv_layers.new(name="map")
    around = np.stack((phi / (2 * np.pi), theta / np.pi), -1).reshape(-1, 2)
    uv.uv.foreach_set("vector", around[faces.ravel()].astype(np.float32).ravel())
    return mesh


def smoke(openvdb, path, size, seed):
    """Writes a VDB file of a noisy cloud."""
    rng = np.random.default_rng(seed)
    axis = np.linspace(-1, 1, size)
    x, y, z = np.meshgrid(axis, axis, axis, indexing="ij")
    density = np.clip(1 - np.sqrt(x * x + y * y + z * z), 0, 1) * rng.random((size,) * 3)
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.copyFromArray(density.astype(np.float32))
    grid.transform = openvdb.createLinearTransform(4 / size)
    openvdb.write(str(path), grids=[grid])


def build_scene(bpy, folder, rows, hierarchy):
    """Makes the scene in an empty Blender."""
    from nephele import vdb_info

    openvdb = vdb_info.module()
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 960, 540
    scene.render.use_persistent_data, scene.render.use_compositing = True, False
    scene.nephele.hierarchy = hierarchy

    def link(name, data):
        item = bpy.data.objects.new(name, data)
        scene.collection.objects.link(item)
        return item

    scene.camera = link("Camera", bpy.data.cameras.new("Camera"))
    scene.camera.location, scene.camera.rotation_euler = (0, -22, 4), (1.4, 0, 0)
    for i in range(BALLS):
        item = link(f"Ball {i}", ball(bpy, f"Ball {i}", rows, i))
        item.location = (3 * (i % 8) - 10.5, 3 * (i // 8) - 6, 0)
        material = bpy.data.materials.new(f"Material {i}")
        color = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
        color.default_value = (i / BALLS, 0.5, 0.5, 1)
        item.data.materials.append(material)
    cloud = bpy.data.materials.new("Cloud")
    nodes = cloud.node_tree.nodes
    nodes.remove(nodes["Principled BSDF"])
    shader = nodes.new("ShaderNodeVolumePrincipled")
    cloud.node_tree.links.new(shader.outputs[0], nodes["Material Output"].inputs["Volume"])
    for i in range(VOLUMES):
        path = Path(folder, f"cloud{i}.vdb")
        smoke(openvdb, path, 160, i)
        data = bpy.data.volumes.new(f"Cloud {i}")
        data.filepath = str(path)
        data.materials.append(cloud)
        link(f"Cloud {i}", data).location = (6 * i - 8, -4, 2)
    for i in range(2):
        lamp = bpy.data.lights.new(f"Lamp {i}", "AREA")
        lamp.energy, lamp.size = 2000, 3
        link(f"Lamp {i}", lamp).location = (10 * i - 5, -6, 10)
    scene.world = bpy.data.worlds.new("World")


def engine_class(bpy):
    """Returns an engine that renders up to the first tile, and notes when what was done."""
    from nephele.session import Session

    class UpdatesEngine(bpy.types.RenderEngine):
        bl_idname = "NEPHELE_UPDATES"
        bl_label = "Updates"
        session, seconds, scene = None, {}, None

        def render(self, depsgraph):
            cls = type(self)
            entered, cpu = time.perf_counter(), time.process_time()
            cls.session = cls.session or Session()
            cls.scene = cls.session.export(depsgraph, engine=self)
            exported = time.perf_counter()
            cpu = time.process_time() - cpu
            cls.seconds = first_tile(cls.session, cls.scene)
            cls.seconds |= {"entered": entered, "export": exported - entered, "cpu": cls.seconds["cpu"] + cpu}

    return UpdatesEngine


def first_tile(session, scene):
    """Builds and renders up to the first tile. Returns seconds."""
    begin, cpu = time.perf_counter(), time.process_time()
    renderer = session.build(scene)
    built, cpu = time.perf_counter(), time.process_time() - cpu
    renderer.start()
    while renderer.statistics()["first_tile_seconds"] == 0:
        renderer.wait(0.0005)
    seconds = renderer.statistics()["first_tile_seconds"]
    renderer.cancel()
    while not renderer.wait(0.1):
        pass
    return {"build": built - begin, "first_tile": seconds, "cpu": cpu}


def render_cpu(engine):
    """Returns the processor's seconds of rendering a few samples: what the hierarchy's layout costs rays."""
    settings = engine.scene.settings | {"samples": SAMPLES}
    renderer = engine.session.build(dataclasses.replace(engine.scene, settings=settings))
    renderer.start()
    while not renderer.wait(1.0):
        pass
    return renderer.statistics()["render_cpu_seconds"]


def edits(bpy):
    """Yields (what changes, function that changes it) for each kind of change."""
    data = bpy.data

    def move_vertices():
        mesh = data.meshes["Ball 3"]
        points = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", points)
        mesh.vertices.foreach_set("co", 1.01 * points)
        mesh.update()

    def scale(owner, name, factor):
        setattr(owner, name, factor * getattr(owner, name))

    def shader(name, node, socket, factor):
        scale(data.materials[name].node_tree.nodes[node].inputs[socket], "default_value", factor)

    def shift(name, axis, by):
        data.objects[name].location[axis] += by

    yield "nothing", lambda: None
    yield "camera", lambda: shift("Camera", 0, 0.1)
    yield "lamp's energy", lambda: scale(data.lights["Lamp 0"], "energy", 1.1)
    yield "lamp's place", lambda: shift("Lamp 1", 2, 0.1)
    yield "material's value", lambda: shader("Material 3", "Principled BSDF", "Roughness", 0.9)
    yield "volumes' density", lambda: shader("Cloud", "Principled Volume", "Density", 1.1)
    yield "volume's place", lambda: shift("Cloud 0", 2, 0.1)
    yield "object's place", lambda: shift("Ball 3", 2, 0.1)
    yield "mesh's vertices", move_vertices


def measure(bpy, hierarchy, rows, repeats):
    """Returns rows, dicts of medians in seconds, for one layout; with GB at the peak so far."""
    engine = engine_class(bpy)
    bpy.utils.register_class(engine)
    rows_out = []

    def render():
        begin = time.perf_counter()
        bpy.ops.render.render()
        return {"blender": engine.seconds["entered"] - begin} | {
            name: value for name, value in engine.seconds.items() if name != "entered"
        }

    def note(what, measured):
        row = {"hierarchy": hierarchy, "change": what}
        row |= {stage: float(np.median([m[stage] for m in measured])) for stage in (*STAGES, "cpu")}
        row["total"] = float(np.median([sum(m[s] for s in STAGES[1:]) for m in measured]))
        rows_out.append(row | {"peak_gigabytes": peak_gigabytes()})
        print(line(rows_out[-1]), flush=True)

    with tempfile.TemporaryDirectory() as folder:
        build_scene(bpy, folder, rows, hierarchy)
        bpy.context.scene.render.engine = engine.bl_idname
        note("all of it, first", [render()])
        for what, change in edits(bpy):
            measured = []
            for _ in range(repeats):
                change()
                measured.append(render())
            note(what, measured)
        measured = []
        for i in range(repeats):  # as a viewport does where only the view changes
            place = engine.scene.camera.world_from_camera.copy()
            place[0, 3] += 0.1 * (i + 1)
            camera = dataclasses.replace(engine.scene.camera, world_from_camera=place)
            scene = dataclasses.replace(engine.scene, camera=camera)
            measured.append({"blender": 0.0, "export": 0.0} | first_tile(engine.session, scene))
        note("camera, in a viewport", measured)
        print(f"\nRendering, {SAMPLES} samples a pixel: {render_cpu(engine):.2f} s of CPU", flush=True)
        engine.session = engine.scene = None
    bpy.context.scene.render.engine = "NEPHELE"
    bpy.utils.unregister_class(engine)
    return rows_out


def line(row):
    stages = " | ".join(f"{1000 * row[stage]:.1f}" for stage in COLUMNS)
    return f"| {row['hierarchy']} | {row['change']} | {stages} | {row['peak_gigabytes']:.2f} |"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--hierarchy", choices=("whole", "by_mesh"), default="whole")
    parser.add_argument("--rows", type=int, default=ROWS, help="of each ball; triangles grow with its square")
    parser.add_argument("--repeats", type=int, default=5)
    arguments = parser.parse_args()
    sys.path[0] = str(ROOT)  # not this folder, whose names Blender's add-ons have too
    import bpy
    import nephele

    bpy.ops.wm.read_factory_settings(use_empty=True)
    nephele.register()
    try:
        print(f"Milliseconds.\n\n{HEAD}\n{'| --- ' * HEAD.count(' | ')}| --- |")
        rows = measure(bpy, arguments.hierarchy, arguments.rows, arguments.repeats)
    finally:
        nephele.unregister()
    target = ROOT / "out" / "bench" / f"updates_{arguments.hierarchy}.json"
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(json.dumps(rows, indent=2))
    return 0


if __name__ == "__main__":
    sys.exit(main())
