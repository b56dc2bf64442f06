# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders an exported scene with Mitsuba 3's spectral-MIS volume path tracer (volpathmis), where Mitsuba can
express it: diffuse, principled and glowing surfaces without textures, area lamps, constant sky, and one
homogeneous medium in a box around the camera.

Mitsuba runs in a process of its own, all seeds in one; this file is also that process's script:

    python -P bench/mitsuba.py JOB.json OUT.npz

(-P: this folder on the module path would hide the package `mitsuba`; import this as bench.mitsuba.) Needs the
package `mitsuba` of bench/requirements.txt. Its principled surface is not quite Blender's: compare the spread
over seeds, and read the mean as a check that the scene is the same.
"""

import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np


class NotExpressible(ValueError):
    """The scene has what Mitsuba's scene description has not, or what is not translated here."""


def render(description_path, samples, seeds, bounces):
    """Returns (images (seeds, height, width, 3), CPU seconds (seeds,)) of a scene file of
    `nephele render --save-description`.

    Raises NotExpressible; RuntimeError with Mitsuba's words where it fails."""
    with tempfile.TemporaryDirectory() as folder:
        request, result = Path(folder, "job.json"), Path(folder, "renders.npz")
        job = {"scene": str(description_path), "samples": samples, "seeds": list(seeds), "bounces": bounces}
        request.write_text(json.dumps(job))
        command = [sys.executable, "-P", __file__, str(request), str(result)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode == 3:
            raise NotExpressible(done.stderr.strip())
        if done.returncode != 0:
            raise RuntimeError(f"Mitsuba failed: {done.stderr.strip()}")
        with np.load(result) as stored:
            return stored["images"], stored["cpu_seconds"]


# ------------------------------------------------------------------------------------ inside the process


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def constants(program):
    """Returns the closure of a program of one closure and no texture, with its inputs as numbers (3,)."""
    if len(program.code) or len(program.closures) != 1:
        raise NotExpressible("a material has textures or is mixed")
    closure = program.closures[0]
    return closure.kind, [program.registers[i] if i >= 0 else None for i in closure.inputs]


def surface(program):
    """Returns {"bsdf": ...}, with {"emitter": ...} where it glows."""
    kind, inputs = constants(program)
    if kind == "diffuse":
        bsdf = {"type": "diffuse", "reflectance": rgb(inputs[0])}
    elif kind == "principled":
        base, metallic, roughness = inputs[0], float(inputs[1][0]), float(inputs[2][0])
        bsdf = {"type": "principled", "base_color": rgb(base), "metallic": metallic, "roughness": roughness}
    elif kind == "emission":
        glow = {"type": "area", "radiance": rgb(inputs[0] * inputs[1])}
        return {"bsdf": {"type": "diffuse", "reflectance": rgb((0, 0, 0))}, "emitter": glow}
    else:
        raise NotExpressible(f"a surface is of {kind}")
    return {"bsdf": {"type": "twosided", "bsdf": bsdf}}


def medium(closures):
    """Returns the medium of one homogeneous closure."""
    (closure,) = closures
    if closure.program or closure.density_grid or closure.phase.kind != "henyey_greenstein":
        raise NotExpressible("a medium varies or has another phase function than Henyey and Greenstein's")
    sigma_s, sigma_a = np.array(closure.sigma_s), np.array(closure.sigma_a)
    albedo = sigma_s / np.maximum(sigma_s + sigma_a, 1e-30)
    return {
        "type": "homogeneous",
        "sigma_t": rgb(sigma_s + sigma_a),
        "albedo": rgb(albedo),
        "phase": {"type": "hg", "g": closure.phase.a},
    }


def lamp(mi, light):
    """Returns the emitter of an area lamp or sun. Both shine along their local -z, Mitsuba's rectangle along
    its +z."""
    if light.kind == "sun":
        direction = [float(v) for v in -light.world_from_light[:3, 2]]
        return {"type": "directional", "direction": direction, "irradiance": rgb(light.power)}
    if light.kind != "area" or light.spread < math.pi or not light.normalize:
        raise NotExpressible(f"lamp '{light.name}' is neither a sun nor a plain area lamp")
    ellipse = light.shape == "ellipse"
    area = light.size[0] * light.size[1] * (math.pi / 4 if ellipse else 1)
    shrink = np.diag([light.size[0] / 2, -light.size[1] / 2, -1.0, 1.0])
    return {
        "type": "disk" if ellipse else "rectangle",
        "to_world": mi.ScalarTransform4f((light.world_from_light @ shrink).tolist()),
        "emitter": {"type": "area", "radiance": rgb(np.array(light.power) / (math.pi * area))},
    }


def shape(mi, scene, instance, folder):
    """Returns (the shape of an instance, the medium inside or None)."""
    mesh, material = scene.meshes[instance.mesh], scene.materials[instance.materials[0]]
    if mesh.material_index is not None and len(set(instance.materials)) > 1:
        raise NotExpressible(f"object '{instance.name}' has several materials")
    m = instance.world_from_object
    positions = mesh.positions.astype(np.float64) @ m[:3, :3].T + m[:3, 3]
    made = mi.Mesh("mesh", len(positions), len(mesh.triangles))
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = positions.astype(np.float32).ravel()
    parameters["faces"] = mesh.triangles.astype(np.uint32).ravel()
    parameters.update()
    path = str(Path(folder, f"{instance.name}.ply"))
    made.write_ply(path)
    result = {"type": "ply", "filename": path, "face_normals": mesh.corner_normals is None}
    if material.volume:
        if material.surface is not None:
            raise NotExpressible(f"object '{instance.name}' has a surface and a volume")
        inside = mi.load_dict(medium(material.volume))
        return result | {"bsdf": {"type": "null"}, "interior": inside}, inside
    return result | surface(material.surface), None


def camera(mi, scene, inside, samples):
    """Returns the sensor; inside: the medium that it stands in, or None."""
    seen, film = scene.camera, scene.film
    left, right, bottom, top = seen.viewplane
    if seen.kind != "perspective" or seen.aperture_radius > 0 or abs(left + right) + abs(bottom + top) > 1e-5:
        raise NotExpressible("the camera is not a plain perspective")
    m = seen.world_from_camera
    result = {
        "type": "perspective",
        "fov": math.degrees(2 * math.atan(right)),
        "fov_axis": "x",
        "near_clip": 1e-3,
        "to_world": mi.ScalarTransform4f((m @ np.diag([-1.0, 1.0, -1.0, 1.0])).tolist()),
        "film": {
            "type": "hdrfilm",
            "width": film.width,
            "height": film.height,
            "pixel_format": "rgb",
            "rfilter": {"type": "box"},
        },
        "sampler": {"type": "independent", "sample_count": samples},
    }
    return result | ({"medium": inside} if inside is not None else {})


def translated(mi, scene, job, folder):
    """Returns Mitsuba's scene as a dict."""
    if scene.volumes or scene.world.volume:
        raise NotExpressible("the scene has VDB volumes, or a volume without end")
    result = {"type": "scene", "integrator": {"type": "volpathmis", "max_depth": job["bounces"] + 1}}
    inside = None
    for i, instance in enumerate(scene.instances):
        result[f"shape{i}"], found = shape(mi, scene, instance, folder)
        if found is not None and inside is not None:
            raise NotExpressible("there are two media")
        inside = inside if found is None else found
    for i, light in enumerate(scene.lights):
        result[f"lamp{i}"] = lamp(mi, light)
    if scene.world.background is not None:
        _, (color, strength) = constants(scene.world.background)
        result["sky"] = {"type": "constant", "radiance": rgb(color * strength)}
    return result | {"sensor": camera(mi, scene, inside, job["samples"])}


def main():
    import mitsuba as mi
    from nephele import description_file

    mi.set_variant("scalar_rgb")
    job = json.loads(Path(sys.argv[1]).read_text())
    with tempfile.TemporaryDirectory() as folder:
        try:
            scene = mi.load_dict(translated(mi, description_file.load(job["scene"], folder), job, folder))
        except NotExpressible as error:
            print(error, file=sys.stderr)
            return 3
        images, seconds = [], []
        for seed in job["seeds"]:
            before = time.process_time()
            images.append(np.array(mi.render(scene, seed=seed)))
            seconds.append(time.process_time() - before)
    np.savez(sys.argv[2], images=np.array(images), cpu_seconds=np.array(seconds))
    return 0


if __name__ == "__main__":
    sys.exit(main())
