# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders read of the object that made an instance, beside Cycles 5.0: coordinates on its faces, its
attributes, its particles. One emissive quad an instance, one sample a pixel at the pixel's middle."""

import sys
from pathlib import Path

import numpy as np
import pytest
from node_cases import LIFT, Tile

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import cycles, ours  # noqa: E402  the project's root is on the path only now

SIZE = (32, 32)
READS = {
    "generated": lambda tile: tile.out("TexCoord", "Generated", from_instancer=True),
    "uv": lambda tile: tile.out("UVMap", "UV", from_instancer=True),
    "attribute": lambda tile: tile.out(
        "Attribute", "Color", attribute_name="tint", attribute_type="INSTANCER"
    ),
}
PARTICLE = ("Index", "Random", "Age", "Lifetime", "Location", "Size", "Velocity", "Angular Velocity")


def instanced(bpy, read, by_particles):
    """Fills the open, empty file: a quad on every face of a grid, or on every particle that one gave off."""
    scene = bpy.context.scene
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=4, y_subdivisions=4, size=4)
    grid = bpy.context.object
    grid["tint"] = (0.2, 0.5, 0.9)
    bpy.ops.mesh.primitive_plane_add(size=0.5)
    quad = bpy.context.object
    tile = Tile(bpy, "Instance")
    tile.finish(read(tile))
    quad.data.materials.append(tile.material)
    if by_particles:
        settings = grid.modifiers.new("Particles", "PARTICLE_SYSTEM").particle_system.settings
        settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 12, -5, 0, 50
        settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", quad, 1.0
        settings.size_random, settings.effector_weights.gravity = 0.4, 0.0
        grid.show_instancer_for_render = quad.hide_render = False
        quad.location = (0, 0, 100)
    else:
        quad.parent, grid.instance_type = grid, "FACES"
        grid.show_instancer_for_render = False
    camera = bpy.data.cameras.new("Camera")
    camera.type, camera.ortho_scale = "ORTHO", 5
    holder = bpy.data.objects.new("Camera", camera)
    holder.location = (0, 0, 50)
    scene.collection.objects.link(holder)
    scene.camera = holder
    scene.world = bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0


def compare(bpy, folder, read, by_particles=False):
    """Fails unless both renderers show the same to 2 % of the pixels, and something varies."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    instanced(bpy, read, by_particles)
    path = folder / "instances.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    job = cycles.Job(str(path), SIZE, 1, (1,), 0, pixel_filter="GAUSSIAN", filter_width=0.01)
    theirs = cycles.render(job).passes["Combined"][0]
    scene = ours.export(path, folder, SIZE)
    images, _ = ours.render(scene, (1,), samples=1, pixel_filter="gaussian", filter_width=0.01, threads=2)
    shown = (theirs > LIFT / 2).all(-1)
    assert shown.sum() > 50
    off = (np.abs(images["Combined"][0] - theirs) > 1e-3 * np.maximum(1, theirs)).any(-1)
    assert off.mean() < 0.02, f"{off.mean():.0%} of the pixels differ"


@pytest.mark.parametrize("name", READS)
def test_faces_of_the_instancer(bpy, tmp_path, name):
    compare(bpy, tmp_path, READS[name])


@pytest.mark.parametrize(
    "output", [pytest.param(o, marks=pytest.mark.long) if o != "Index" else o for o in PARTICLE]
)
def test_particles(bpy, tmp_path, output):
    compare(bpy, tmp_path, lambda tile: tile.out("ParticleInfo", output), by_particles=True)
