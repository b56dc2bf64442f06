# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the participating media test scenes of Mitsuba 3 into scene descriptions: just the elements that
those files use. World space is theirs (metres, y up).

Paths: Mitsuba's `max_depth` counts the vertices after the camera, the last of which only shines: N scattering
events at most are max_depth = N + 1, and our max_bounces counts them from 0. Its null surfaces do not count.
"""

import dataclasses
import xml.etree.ElementTree as xml
from pathlib import Path

import mitsuba_shaders
import numpy as np
import OpenEXR
from nephele import description as d
from truth import Scene, box, emission, perspective

# Half the width of a square picture at distance 1: a lens of 50 mm and the diagonal of a film of 36 x 24 mm.
HALF_PICTURE = np.hypot(36, 24) / 100 / np.sqrt(2)


def read_exr(path):
    """Returns (height, width, 3) float64, first row at the bottom."""
    with OpenEXR.File(str(path)) as file:
        return file.channels()["RGB"].pixels[::-1].astype(np.float64)


def read_grid(path):
    """Returns (x, y, z, channels) float32 of a .vol file, whose x runs fastest, channels within."""
    data = Path(path).read_bytes()
    if data[:4] != b"VOL\x03" or np.frombuffer(data[4:8], "<i4")[0] != 1:
        raise ValueError(f"{path}: not a grid of floats in Mitsuba's format 3")
    nx, ny, nz, channels = np.frombuffer(data[8:24], "<i4")
    return np.frombuffer(data[48:], "<f4").reshape(nz, ny, nx, channels).transpose(2, 1, 0, 3)


def read_obj(path):
    """Returns the d.Mesh of a Wavefront file of triangles with normals and texture coordinates. Mitsuba turns
    v over; `s off` (flat normals) says the same as its normals."""
    rows = {"v": [], "vt": [], "vn": [], "f": []}
    for line in Path(path).read_text().splitlines():
        kind, *fields = line.split() or ("#",)
        if kind in rows:
            rows[kind].append([f.split("/") for f in fields] if kind == "f" else [float(f) for f in fields])
    position, uv, normal = (np.array(rows[kind], np.float32) for kind in ("v", "vt", "vn"))
    corners = np.array(rows["f"], np.int32) - 1
    texture = uv[corners[..., 1]] * (1, -1) + (0, 1)
    return d.Mesh(
        Path(path).stem,
        position,
        np.ascontiguousarray(corners[..., 0]),
        normal[corners[..., 2]],
        (texture.astype(np.float32),),
    )


def numbers(text):
    return np.array([float(part) for part in text.replace(",", " ").split()])


def placement(element):
    """Returns the 4x4 matrix of the transform named to_world or to_uv, identity without one. Its steps apply
    in the order of the file."""
    matrix = np.eye(4)
    for step in element.findall("transform/*"):
        if step.tag == "matrix":
            one = numbers(step.get("value")).reshape(4, 4)
        elif step.tag in ("translate", "scale"):
            one, default = np.eye(4), 0.0 if step.tag == "translate" else 1.0
            v = [float(step.get(axis, default)) for axis in "xyz"]
            one[:3] = np.c_[np.eye(3), v] if step.tag == "translate" else np.c_[np.diag(v), np.zeros(3)]
        else:
            raise ValueError(f"no reading of the transform <{step.tag}>")
        matrix = one @ matrix
    return matrix


def values_of(element):
    """Returns the element's plain children by name: strings, numbers and RGB."""
    values = {}
    for child in element:
        if child.tag == "rgb":
            values[child.get("name")] = np.broadcast_to(numbers(child.get("value")), 3)
        elif child.tag in ("float", "integer"):
            values[child.get("name")] = float(child.get("value"))
        elif child.tag in ("string", "boolean"):
            values[child.get("name")] = child.get("value")
    return values


@dataclasses.dataclass(frozen=True)
class Grid:
    """A grid volume: values (x, y, z, channels) on the cube of this size at `origin`, and the corners of the
    box that its medium fills."""

    values: np.ndarray
    origin: np.ndarray
    size: float
    low: np.ndarray
    high: np.ndarray


def box_of(points, matrix):
    """Returns the (low, high) corners of transformed points."""
    points = points @ matrix[:3, :3].T + matrix[:3, 3]
    return points.min(0), points.max(0)


def overlap(one, other):
    """Returns the box that two boxes share: a varying medium of Mitsuba's ends at its volume's box as well as
    at its mesh."""
    return np.maximum(one[0], other[0]), np.minimum(one[1], other[1])


class Reader:
    """One scene file. grid_medium(grid, scale, albedo): returns what Scene.add_volume takes, for a Grid of
    sigma_t / scale."""

    def __init__(self, path, grid_medium):
        self.folder, self.grid_medium = Path(path).parent, grid_medium
        self.elements, self.paths = [], [self.folder]
        self._flatten(path)

    def _flatten(self, path):
        for element in xml.parse(path).getroot():
            if element.tag == "include":
                self._flatten(self.folder / element.get("filename"))
            elif element.tag == "path":
                self.paths.append((self.folder / element.get("value")).resolve())
            elif element.tag != "default":  # resolution, samples and integrator: ours
                self.elements.append(element)

    def _file(self, values):
        return next(p / values["filename"] for p in self.paths if (p / values["filename"]).exists())

    def _all(self, tag):
        return [e for e in self.elements if e.tag == tag]

    def description(self, **settings):
        """Returns the d.Scene: 48 x 48 pixels, box filter."""
        view = {e.tag: e for e in self._all("sensor")[0].find("transform")}["lookat"]
        clips = values_of(self._all("sensor")[0])
        camera = perspective(
            numbers(view.get("origin")),
            numbers(view.get("target")),
            HALF_PICTURE,
            clip_start=clips["near_clip"],
            clip_end=clips["far_clip"],
        )
        depth = values_of(self._all("integrator")[0].find("integrator"))["max_depth"]
        events = int(depth) - 2
        scene, images = Scene(camera), ()
        for emitter in self._all("emitter"):
            pixels = read_exr(self._file(values_of(emitter)))
            rgba = np.dstack([pixels, np.ones(pixels.shape[:2])]).astype(np.float32)
            images = (d.Image("environment", rgba),)
            scene.world = mitsuba_shaders.environment_map(images[0])
        for shape in self._all("shape"):
            self._add_shape(scene, shape)
        limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), events)
        description = scene.description(48, pixel_filter="box", **limits, **settings)
        return dataclasses.replace(description, images=images)

    def _add_shape(self, scene, shape):
        mesh, matrix = read_obj(self._file(values_of(shape))), placement(shape)
        emitter, bsdf, inside = shape.find("emitter"), shape.find("bsdf"), shape.find("ref")
        if emitter is not None:
            scene.add(mesh, emission(values_of(emitter)["radiance"]), (), matrix)  # its BSDF is black
            return
        values = values_of(bsdf)
        texture = bsdf.find("texture")
        if texture is not None:
            scale = placement(texture)[0, 0]
            colors = values_of(texture)
            values["texture"] = mitsuba_shaders.checkerboard(colors["color0"], colors["color1"], scale)
        surface = mitsuba_shaders.surface(bsdf.get("type"), values)
        if inside is None:
            scene.add(mesh, surface, (), matrix)
            return
        medium = next(m for m in self._all("medium") if m.get("id") == inside.get("id"))
        values, volume = values_of(medium), medium.find("volume")
        scale, albedo = values["scale"], values["albedo"]
        to_world = np.eye(4) if volume is None else placement(volume)
        if volume is None:
            self._fill(scene, mesh, surface, matrix, scale * values["sigma_t"], albedo)
            return
        if surface is not None:
            raise ValueError("no reading of a volume inside a visible surface")
        low, high = overlap(
            box_of(mesh.positions, matrix), box_of(np.array([(0, 0, 0), (1, 1, 1)]), to_world)
        )
        if volume.get("type") == "constvolume":
            sigma_t = scale * values_of(volume)["value"]
            self._fill(scene, box(low, high), None, np.eye(4), sigma_t, albedo)
            return
        grid = Grid(read_grid(self._file(values_of(volume))), to_world[:3, 3], to_world[0, 0], low, high)
        scene.add_volume(*self.grid_medium(grid, scale, albedo))

    def _fill(self, scene, mesh, surface, matrix, sigma_t, albedo):
        scene.add(
            mesh, surface, (d.VolumeClosure(tuple(sigma_t * albedo), tuple(sigma_t * (1 - albedo))),), matrix
        )
