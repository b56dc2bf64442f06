# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes built from numbers, rendered straight by the native module, and statistics over their pixels.

Shared by the truth tests of the renderer. World space in metres; images are (height, width, channels), first
row at the bottom.
"""

import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.stats
from nephele import description as d
from nephele import opcodes, parameters

NO_LIMIT = {"max_bounces": 4096, "surface_bounces": 4096, "volume_bounces": 4096}
BOX_FILTER = {"pixel_filter": "box"}
SCENES = Path(__file__).resolve().parents[2] / "blend_scenes"
ROUGH_BALL = SCENES / "furnace" / "furnace.vdb"  # its grid density, of radius 0.9
RAY = {name: 1 << i for i, name in enumerate(opcodes.RAY_KINDS)}


# --- Shading programs


def constant_program(*closures):
    """Returns a program of constant closures, each (kind, *inputs), an input a number, an RGB or None (no
    normal)."""
    registers, rows = [(1.0, 1.0, 1.0)], []
    for kind, *inputs in closures:
        numbers = []
        for value in inputs:
            numbers.append(-1 if value is None else len(registers))
            if value is not None:
                registers.append(np.broadcast_to(np.asarray(value, float), 3))
        rows.append(d.Closure(kind, 0, tuple(numbers), mode=0))
    return d.Program(registers=np.array(registers, np.float32), closures=tuple(rows))


def emission(radiance):
    return constant_program(("emission", radiance, 1.0))


def diffuse(albedo):
    return constant_program(("diffuse", albedo, 0.0, None))


def glass(ior, roughness=0.0):
    return constant_program(("glass", 1.0, roughness, ior, None))


def half_world(up, down=0.0):
    """Returns a background of radiance `up` where a direction's z is positive, and `down` elsewhere."""
    rows = [
        (1, 1, 1),
        (0, 0, 0),
        np.broadcast_to(up, 3),
        np.broadcast_to(down, 3),
        (0, 0, 0),
        (0, 0, 0),
        (0, 0, 0),
    ]
    op = {name: i for i, name in enumerate(opcodes.OPCODES)}
    code = [
        (op["object_coordinate"], 4, 0, 0, 0, 0, 0, 0),
        (op["channel"], 4, 4, 0, 0, 0, 0, 2),
        (op["greater_than"], 5, 4, 1, 0, 0, 0, 0),
        (op["mix"], 6, 3, 2, 5, 0, 0, 0),
    ]
    return d.Program(
        registers=np.array(rows, np.float32),
        code=np.array(code, np.int32),
        closures=(d.Closure("emission", 0, (6, 0)),),
    )


# --- Media


def medium(sigma_s, sigma_a=0.0, g=0.0, **more):
    """Returns a VolumeClosure; sigma_s, sigma_a: 1/m, one number or three; g: Henyey-Greenstein cosine."""
    three = [tuple(np.broadcast_to(np.asarray(v, float), 3).tolist()) for v in (sigma_s, sigma_a)]
    return d.VolumeClosure(*three, phase=d.Phase(a=g), **more)


# --- Geometry


def placed(x=0.0, y=0.0, z=0.0):
    """Returns the 4x4 matrix of a translation."""
    m = np.eye(4)
    m[:3, 3] = x, y, z
    return m


def facing(position, target):
    """Returns the 4x4 matrix of a camera or lamp at `position` whose local -z points at `target`."""
    back = np.asarray(position, float) - np.asarray(target, float)
    back /= np.linalg.norm(back)
    helper = (0.0, 1.0, 0.0) if abs(back[1]) < 0.9 else (1.0, 0.0, 0.0)
    right = np.cross(helper, back)
    right /= np.linalg.norm(right)
    m = np.eye(4)
    m[:3, 0], m[:3, 1], m[:3, 2], m[:3, 3] = right, np.cross(back, right), back, position
    return m


def box(low, high, name="box"):
    """Returns a closed box mesh, faces outwards."""
    corners = np.array([[(low, high)[i >> a & 1][a] for a in range(3)] for i in range(8)], np.float32)
    quads = [(0, 4, 6, 2), (1, 3, 7, 5), (0, 1, 5, 4), (2, 6, 7, 3), (0, 2, 3, 1), (4, 5, 7, 6)]
    triangles = [t for a, b, c, e in quads for t in ((a, b, c), (a, c, e))]
    return d.Mesh(name, corners, np.array(triangles, np.int32))


def sphere(radius, subdivisions, name="sphere", inwards=False):
    """Returns an icosphere whose vertices lie on the sphere; faces outwards unless `inwards`."""
    phi = (1 + 5**0.5) / 2
    points = [(s, t * phi, 0) for s in (-1, 1) for t in (-1, 1)]
    points = np.array([np.roll(p, k) for k in range(3) for p in points], float)
    points /= np.linalg.norm(points[0])
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if all(np.linalg.norm(points[a] - points[b]) < 1.1 for a, b in ((i, j), (j, k), (i, k)))
    ]
    for _ in range(subdivisions):
        a, b, c = (points[[f[m] for f in faces]] for m in range(3))
        n, m = len(points), len(faces)
        points = np.concatenate([points, a + b, b + c, c + a])
        ab, bc, ca = (n + k * m + np.arange(m) for k in range(3))
        i, j, k = np.array(faces).T
        faces = np.concatenate(
            [np.stack(f, 1) for f in ((i, ab, ca), (j, bc, ab), (k, ca, bc), (ab, bc, ca))]
        )
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        points, unique = np.unique(points.round(12), axis=0, return_inverse=True)
        faces = unique.reshape(-1)[faces]
    faces = np.array(faces)
    a, b, c = (points[faces[:, m]] for m in range(3))
    turned = np.einsum("ij,ij->i", np.cross(b - a, c - a), a) < 0
    faces[turned != inwards] = faces[turned != inwards][:, ::-1]
    return d.Mesh(name, (radius * points).astype(np.float32), faces.astype(np.int32))


def joined(*meshes):
    """Returns one mesh of several."""
    offsets = np.cumsum([0] + [len(m.positions) for m in meshes[:-1]])
    return d.Mesh(
        "joined",
        np.concatenate([m.positions for m in meshes]),
        np.concatenate([m.triangles + o for m, o in zip(meshes, offsets, strict=True)]).astype(np.int32),
    )


def volume_of(mesh):
    """Returns the volume that a closed mesh encloses, m^3."""
    a, b, c = (mesh.positions.astype(float)[mesh.triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


# --- Scenes


def orthographic(position, target, size=1e-3):
    """Returns a camera of parallel rays, `size` m wide and high."""
    h = size / 2
    return d.Camera("camera", "orthographic", facing(position, target), (-h, h, -h, h))


def perspective(position, target, half=0.5, **more):
    """Returns a camera whose picture is 2 `half` wide and high at distance 1."""
    return d.Camera("camera", "perspective", facing(position, target), (-half, half, -half, half), **more)


class Scene:
    """Collects a scene. `add` takes a mesh with its materials, `add_volume` a VDB file."""

    def __init__(self, camera, world=None, world_volume=(), lights=()):
        self.camera, self.lights = camera, tuple(lights)
        self.world = d.World(world, tuple(world_volume))
        self.meshes, self.instances, self.volumes, self.materials = [], [], [], []

    def _material(self, surface, volume):
        self.materials.append(d.Material(f"material {len(self.materials)}", surface, tuple(volume)))
        return len(self.materials) - 1

    def add(self, mesh, surface=None, volume=(), world_from_object=None, **more):
        """Adds a mesh; surface: a program or None; volume: closures."""
        material = self._material(surface, volume)
        self.meshes.append(mesh)
        matrix = np.eye(4) if world_from_object is None else world_from_object
        self.instances.append(d.Instance(mesh.name, len(self.meshes) - 1, matrix, (material,), **more))
        return self

    def add_volume(self, path, *closures, world_from_object=None, **more):
        matrix = np.eye(4) if world_from_object is None else world_from_object
        self.volumes.append(d.Volume("volume", str(path), matrix, self._material(None, closures), **more))
        return self

    def description(self, size=32, passes=("Combined",), crop=None, transparent=False, **settings):
        """Returns the description.Scene. size: of the square film in pixels, or (width, height)."""
        width, height = (size, size) if isinstance(size, int) else size
        return d.Scene(
            self.camera,
            d.Film(width, height, crop, transparent, passes),
            parameters.checked(settings),
            tuple(self.meshes),
            tuple(self.instances),
            tuple(self.volumes),
            tuple(self.materials),
            (),
            self.lights,
            self.world,
        )

    def render(self, passes=("Combined",), **film_and_settings):
        """Returns pass name -> (height, width, channels) float64, Combined without alpha. No sample may be
        non-finite."""
        return finished(self.description(passes=passes, **film_and_settings))


def finished_after_interruption(scene, after):
    """Returns Combined of a description.Scene, (height, width, 3) float32, rendered in two parts: cancelled
    once every pixel has `after` samples, then taken up from its checkpoint by another renderer."""
    import nephele_native

    first = nephele_native.Renderer(scene)
    first.start()
    while first.progress()["samples_done"] < after:
        time.sleep(0.001)
    first.cancel()
    assert first.wait(10)
    assert first.progress()["state"] == "cancelled", "it was too fast to be cancelled; take more samples"
    rest = nephele_native.Renderer(scene)
    rest.restore(first.checkpoint())
    rest.start()
    assert rest.wait(100)
    return rest.read_pass("Combined")[..., :3]


def finished(scene, **also):
    """Returns the passes of a description.Scene rendered to its end, as Scene.render does."""
    import nephele_native

    renderer = nephele_native.Renderer(scene)
    renderer.start()
    assert renderer.wait(600), "the render did not finish in 10 minutes"
    statistics = renderer.statistics()
    assert statistics["nonfinite_samples"] == 0
    assert statistics["bound_violations"] == 0
    images = {name: renderer.read_pass(name).astype(np.float64) for name in scene.film.passes}
    if "Combined" in images:
        images["Combined"] = images["Combined"][..., :3]
    return images


# --- Statistics


@dataclass(frozen=True)
class Estimate:
    """Mean and its standard error, per channel."""

    mean: np.ndarray
    error: np.ndarray

    def __str__(self):
        return " ".join(f"{m:.6g}+-{e:.2g}" for m, e in zip(self.mean, self.error, strict=True))


def estimate(image):
    """Returns the Estimate of an image whose pixels are independent estimates of one number per channel."""
    pixels = image.reshape(-1, image.shape[-1])
    return Estimate(pixels.mean(0), pixels.std(0, ddof=1) / np.sqrt(len(pixels)))


def assert_mean(image, expected, sigmas=5.0, rounding=0.0, most=None):
    """Asserts that the pixels' mean is `expected` (per channel), within `sigmas` standard errors and
    `rounding` (relative: digits that the reference lacks). False alarm of 5 standard errors: 6e-7 per
    number.

    most: the largest standard error allowed, relative to what is expected (or to 0.01 where that is darker),
    so that the test cannot pass by being too noisy.
    """
    e = estimate(image)
    expected = np.broadcast_to(np.asarray(expected, float), e.mean.shape)
    off = np.abs(e.mean - expected)
    allowed = sigmas * e.error + rounding * np.abs(expected)
    assert np.all(off <= allowed), (
        f"got {e}, expected {expected}: off by {off / np.maximum(e.error, 1e-30)} sigma"
    )
    if most is not None:
        assert np.all(e.error <= most * np.maximum(np.abs(expected), 0.01)), f"too noisy to tell: {e}"


def assert_blocks(image, expected, size=4, false_alarm=1e-4, rounding=0.0):
    """Asserts that the mean of every block of size x size pixels is `expected` (per channel): Student's t
    of the block's pixels, all blocks and channels together failing by chance with probability
    `false_alarm` (Sidak).

    The pixels of a block must be independent with the same expectation.
    """
    height, width, channels = image.shape
    blocks = image.reshape(height // size, size, width // size, size, channels).transpose(0, 2, 4, 1, 3)
    blocks = blocks.reshape(height // size, width // size, channels, size * size)
    n = size * size
    error = blocks.std(-1, ddof=1) / np.sqrt(n)
    off = np.abs(blocks.mean(-1) - expected) - rounding * np.abs(expected)
    t = np.where(off > 0, off / np.maximum(error, 1e-30), 0)
    limit = scipy.stats.t.isf((1 - (1 - false_alarm) ** (1 / t.size)) / 2, n - 1)
    worst = np.unravel_index(t.argmax(), t.shape)
    assert t.max() <= limit, (
        f"block (row, column, channel) {worst} is {blocks.mean(-1)[worst]:.6g} +- {error[worst]:.2g}, "
        f"expected {expected}: t = {t.max():.1f}, allowed {limit:.1f}"
    )
