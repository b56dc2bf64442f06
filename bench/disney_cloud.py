# SPDX-License-Identifier: GPL-3.0-or-later
"""CPU time per sample on the Disney cloud, against Cycles 5.0 in its unbiased mode, and the time to load it.

    python bench/disney_cloud.py CLOUD.vdb [--repeats 3]

CLOUD.vdb: a fog volume with a grid "density" (Walt Disney Animation Studios' cloud, CC BY-SA 3.0). Albedo
0.97, optical depth about 60 across the longest edge, sun and sky, 32 bounces. Prints Markdown.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from bench import foundation  # noqa: E402  the project's root is on the path only now

RESOLUTION, SAMPLES, BOUNCES = (320, 240), 8, 32
OPTICAL_DEPTH, ALBEDO = 60.0, 0.97


def make_scene(vdb, path):
    """Writes the .blend: the cloud scaled to 8 m, a sun, a sky, a camera."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.object.volume_import(filepath=str(vdb), files=[{"name": Path(vdb).name}])
    cloud = bpy.context.object
    cloud.location, cloud.rotation_euler, cloud.scale = (0, 0, 0), (0, 0, 0), (1, 1, 1)
    corners = np.array(cloud.evaluated_get(bpy.context.evaluated_depsgraph_get()).bound_box)
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = 8 / (high - low).max()
    x, y, z = (low + high) / 2 * scale
    cloud.scale, cloud.rotation_euler = (scale,) * 3, (np.pi / 2, 0, 0)  # the file has y up
    cloud.location = (-x, z, -y)
    cloud.data.render.space = "WORLD"
    material = bpy.data.materials.new("Cloud")
    tree = material.node_tree
    tree.nodes.clear()
    volume, output = tree.nodes.new("ShaderNodeVolumePrincipled"), tree.nodes.new("ShaderNodeOutputMaterial")
    volume.inputs["Color"].default_value = (ALBEDO,) * 3 + (1,)
    volume.inputs["Density"].default_value = OPTICAL_DEPTH / 8
    tree.links.new(volume.outputs[0], output.inputs["Volume"])
    cloud.data.materials.append(material)
    world = bpy.data.worlds.new("Sky")
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.2, 0.35, 0.7, 1)
    scene.world = world
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle = 5.0, 0.01
    sun.rotation_euler = (0.8, 0.2, 0.6)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location = (0, -12, 0)
    camera.rotation_euler = (1.5707963, 0, 0)
    for item in (sun, camera):
        scene.collection.objects.link(item)
    scene.camera = camera
    bpy.ops.wm.save_as_mainfile(filepath=str(path))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("vdb", type=Path)
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    if not arguments.vdb.is_file():
        parser.error(f"{arguments.vdb} is not there")
    with tempfile.TemporaryDirectory() as folder:
        scene = Path(folder, "disney.blend")
        make_scene(arguments.vdb.resolve(), scene)
        workload = foundation.Workload(scene, RESOLUTION, SAMPLES, BOUNCES)
        row = foundation.compare(workload, arguments.repeats)
    print("| Cycles CPU s | Nephele CPU s | Nephele / Cycles | Cycles relMSE | Nephele relMSE | build s |")
    print("|---|---|---|---|---|---|")
    print(
        f"| {row['cycles_cpu']:.2f} | {row['nephele_cpu']:.2f} | {1 / row['ratio']:.2f} | "
        f"{row['cycles_relmse']:.4f} | {row['nephele_relmse']:.4f} | {row['build']:.3f} |"
    )


if __name__ == "__main__":
    main()
