# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele info`: what is in a scene, what of the renderer it needs, and what the export leaves out."""

import collections
import dataclasses
import json

from .. import issues, render_request, rendering, vdb_info
from ..parameters import defaults
from .render import opened


def add_parser(subparsers):
    """Adds the command's arguments."""
    parser = subparsers.add_parser("info", help="show what is in a scene", allow_abbrev=False)
    parser.add_argument("scene", metavar="SCENE", help="a .blend or a scene description")
    parser.add_argument(
        "--frame", type=int, metavar="N", help="default: the frame that the .blend was saved at"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=run)


def run(arguments):
    """Prints what is in the scene. Returns the exit code."""
    request = render_request.Request(arguments.scene, render_request.is_description(arguments.scene))
    with opened(request) as source:
        report = describe(request.applied(source.export(arguments.frame)))
        report["warnings"] = [*source.warnings, *report["warnings"]]
        report["issues"] = [dataclasses.asdict(issues.issue(text)) for text in report["warnings"]]
    report = {"scene": arguments.scene} | report
    if arguments.json:
        print(json.dumps(report, indent=2))
    else:
        print_text(report)
    return 0


def describe(scene):
    """Returns the report on a description.Scene as a dict of JSON values."""
    features = rendering.native_module().scene_features(scene)
    triangles = [len(mesh.triangles) for mesh in scene.meshes]
    return {
        "resolution": [scene.film.width, scene.film.height],
        "camera": {"name": scene.camera.name, "kind": scene.camera.kind},
        "meshes": len(scene.meshes),
        "instances": len(scene.instances),
        "triangles": sum(triangles),
        "instanced_triangles": sum(triangles[instance.mesh] for instance in scene.instances),
        "volumes": [describe_volume(scene, volume) for volume in scene.volumes],
        "mesh_volumes": sum(has_volume(scene, instance) for instance in scene.instances),
        "lights": [{"name": light.name, "kind": light.kind} for light in scene.lights],
        "world": {"background": scene.world.background is not None, "volume": bool(scene.world.volume)},
        "materials": [
            {"name": m.name, "surface": m.surface is not None, "volume": bool(m.volume)}
            for m in scene.materials
        ],
        "textures": [
            {
                "name": i.name,
                "width": i.pixels.shape[1],
                "height": i.pixels.shape[0],
                "bytes": i.pixels.nbytes,
            }
            for i in scene.images
        ],
        "passes": list(scene.film.passes),
        "settings": scene.settings,
        "kernel_features": list(features["kernel_features"]),
        "left_out": list(features["left_out"]),
        "kernel": list(features["kernel"]),
        "guiding_field": dict(features["guiding_field"]),
        "warnings": list(scene.warnings),
    }


def has_volume(scene, instance):
    """Tells whether a mesh instance bounds a volume."""
    return any(scene.materials[index].volume for index in instance.materials if index >= 0)


def describe_volume(scene, volume):
    """Returns the entry of a description.Volume."""
    closures = scene.materials[volume.material].volume if volume.material >= 0 else ()
    used = {grid for closure in closures for grid in (closure.density_grid, closure.emission_grid) if grid}
    used |= {grid for closure in closures for grid in closure.grids}
    if scene.shutter[0] != scene.shutter[1]:
        used |= set(volume.velocity_grids)
    grids = [grid | {"used": grid["name"] in used} for grid in vdb_info.grids(volume.path)]
    return {"name": volume.name, "path": volume.path, "grids": grids}


def print_text(report):
    """Prints the report for people."""
    size = "x".join(map(str, report["resolution"]))
    print(f"{report['scene']}: {size}, {report['camera']['kind']} camera")
    print(
        f"meshes: {report['meshes']} ({report['triangles']} triangles), placed {report['instances']} times "
        f"({report['instanced_triangles']} triangles), {report['mesh_volumes']} of them bounding a volume"
    )
    for volume in report["volumes"]:
        print(f"volume {volume['name']}: {volume['path']}")
        for grid in volume["grids"]:
            size = "x".join(map(str, grid["resolution"])) if grid["resolution"] else "unknown size"
            voxels = "unknown" if grid["active_voxels"] is None else grid["active_voxels"]
            used = ", used" if grid["used"] else ""
            print(f"  {grid['name']} ({grid['type']}): {size}, {voxels} voxels{used}")
    kinds = collections.Counter(light["kind"] for light in report["lights"])
    print(f"lights: {', '.join(f'{count} {kind}' for kind, count in kinds.items()) or 'none'}")
    world = [name for name, present in report["world"].items() if present]
    print(f"world: {' and '.join(world) or 'black'}")
    print(f"materials: {', '.join(material['name'] for material in report['materials']) or 'none'}")
    for image in report["textures"]:
        print(f"texture {image['name']}: {image['width']}x{image['height']}, {image['bytes']} bytes")
    print(f"passes: {', '.join(report['passes'])}")
    changed = [f"{name}={value}" for name, value in report["settings"].items() if value != defaults()[name]]
    print(f"settings other than default: {', '.join(changed) or 'none'}")
    print(f"kernel features: {', '.join(report['kernel_features']) or 'none'}")
    print(f"left out: {', '.join(report['left_out']) or 'nothing'}")
    print(f"kernel compiled for: {', '.join(report['kernel'])}")
    field = report["guiding_field"]
    print(f"guiding field: {'trained' if field['trains'] else 'none'} ({field['reason']})")
    print(f"issues: {len(report['warnings']) or 'none'}")
    for line in issues.text_lines(report["warnings"]):
        print(f"  {line}")
