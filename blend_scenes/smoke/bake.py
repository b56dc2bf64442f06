# SPDX-License-Identifier: GPL-3.0-or-later
"""Bake a small fire-and-smoke simulation in a real Blender (run by bake.sh).

    blender -b --factory-startup --python bake.py -- RESOLUTION LAST_FRAME CACHE_DIRECTORY

RESOLUTION counts cells along the longest side of the domain. The cache lands in
CACHE_DIRECTORY/data/fluid_data_%04d.vdb; the domain's placement, which the cache files do not hold,
in CACHE_DIRECTORY/domain.json (corners of the axis-aligned box, in metres of world space).

`quick_smoke` builds the set-up because it is the one way that works in every Blender from 3.4 on.
"""

import json
import sys
from pathlib import Path

import bpy
from mathutils import Matrix

EMITTER_RADIUS_M = 0.36
DOMAIN_MIN_M = (-1.0, -1.0, 0.0)
DOMAIN_MAX_M = (1.0, 1.0, 3.2)
FRAMES_PER_SECOND = 24


def build_emitter():
    """A flattened ball on the floor, noisy enough that the plume does not stay symmetric."""
    for other in list(bpy.data.objects):
        bpy.data.objects.remove(other)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=EMITTER_RADIUS_M, location=(0.0, 0.0, 0.45))
    emitter = bpy.context.object
    emitter.scale = (1.0, 0.8, 0.6)
    return emitter


def build_domain(resolution, last_frame, cache_directory):
    """Make the gas domain around the selected emitter and give it its size, cells and cache."""
    bpy.ops.object.quick_smoke(style="BOTH")
    domain = next(ob for ob in bpy.data.objects if is_domain(ob))
    for vertex in domain.data.vertices:  # the cube's corners, in metres; the object itself is not scaled
        vertex.co = [(DOMAIN_MAX_M if c > 0 else DOMAIN_MIN_M)[axis] for axis, c in enumerate(vertex.co)]
    domain.matrix_world = Matrix.Identity(4)

    settings = domain.modifiers["Fluid"].domain_settings
    settings.resolution_max = resolution
    settings.cache_type = "ALL"
    settings.cache_directory = str(cache_directory)
    settings.cache_frame_start = 1
    settings.cache_frame_end = last_frame
    settings.openvdb_cache_compress_type = "BLOSC"
    settings.openvdb_data_depth = "16"
    settings.use_adaptive_domain = False
    settings.use_noise = False
    settings.vorticity = 0.12
    settings.alpha = 0.4
    settings.beta = 0.9
    settings.burning_rate = 1.6
    settings.flame_vorticity = 0.4
    settings.use_dissolve_smoke = True
    settings.dissolve_speed = 60
    return domain


def is_domain(ob):
    """True for an object whose fluid modifier is the domain."""
    return any(m.type == "FLUID" and m.fluid_type == "DOMAIN" for m in ob.modifiers)


def build_flow(emitter):
    """Fuel with texture-free, frame-independent settings, pushed a little sideways."""
    flow = emitter.modifiers["Fluid"].flow_settings
    flow.flow_type = "BOTH"
    flow.density = 1.0
    flow.fuel_amount = 1.1
    flow.temperature = 1.5
    flow.use_initial_velocity = True
    flow.velocity_coord = (0.12, 0.05, 0.2)


def write_domain(cache_directory):
    """Record where the cache's box stands; see the module's docstring."""
    record = {"min": DOMAIN_MIN_M, "max": DOMAIN_MAX_M, "blender": bpy.app.version_string}
    (cache_directory / "domain.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")


def main(resolution, last_frame, cache_directory):
    """Bake; raise when the solver left no file for the last frame."""
    cache_directory.mkdir(parents=True, exist_ok=True)
    emitter = build_emitter()
    domain = build_domain(resolution, last_frame, cache_directory)
    build_flow(emitter)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, last_frame
    scene.render.fps = FRAMES_PER_SECOND

    bpy.ops.object.select_all(action="DESELECT")
    domain.select_set(True)
    bpy.context.view_layer.objects.active = domain
    bpy.ops.fluid.bake_all()

    last = cache_directory / "data" / f"fluid_data_{last_frame:04d}.vdb"
    if not last.is_file():
        raise RuntimeError(f"the fluid bake wrote no {last}; bake with Blender 3.4, or 5.2 and newer")
    write_domain(cache_directory)


arguments = sys.argv[sys.argv.index("--") + 1 :]
main(int(arguments[0]), int(arguments[1]), Path(arguments[2]).resolve())
