# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur of objects, shapes and the camera: Blender evaluates the scene at steps of the shutter.

How many steps an object has, and whether it is blurred at all, are settings that Cycles adds to objects:
motion_steps n stands for 2^n + 1 steps. Where Cycles is absent there are three. All objects' steps are among
those of the finest, so that each moment is evaluated once.
"""

import dataclasses
import math

import numpy as np

from .motion import is_blurred
from .space import matrix4

DEFAULT_STEPS, MOST_STEPS = 1, 6  # as exponents: 3 and 65 steps
STILL = 1e-6  # m, or without unit: matrices that differ by less are the same


def identity(instance):
    """Returns what tells a depsgraph instance from others, the same at all times."""
    parent = instance.parent.original.as_pointer() if instance.parent is not None else 0
    number = tuple(instance.persistent_id) if instance.is_instance else ()
    return instance.object.original.as_pointer(), parent, number


def step_exponent(item):
    """Returns n of an object's 2^n + 1 steps."""
    steps = getattr(getattr(item, "cycles", None), "motion_steps", DEFAULT_STEPS)
    return min(max(int(steps), 1), MOST_STEPS)


@dataclasses.dataclass
class Track:
    """One object on its way. exponent: of its steps. kind: "instance", "volume" or "light"; number: place in
    the list of such. record: the MeshRecord to read at every step, or None where the shape is kept.
    object_from_data: from the space that the description places to the object's own."""

    kind: str
    number: int
    name: str
    exponent: int
    record: object = None
    mesh: int = -1
    object_from_data: np.ndarray = dataclasses.field(default_factory=lambda: np.eye(4))
    matrices: list = dataclasses.field(default_factory=list)


class Tracks:
    """The objects that may move, by identity."""

    def __init__(self, context):
        self._context = context
        self._parts = {""}
        self._tracks = {}  # (identity, part) -> Track, None where several instances have the same
        self._records = {}  # mesh number -> MeshRecord, of those that may change their shape
        self._shapes = {}  # mesh number -> lists of positions and normals by step, None where it cannot be

    def add(self, kind, number, instance, *, record=None, mesh=-1, world_from_data=None, part=""):
        """Takes note of an instance that the walk found. record, mesh: of a mesh and its number.
        part: tells what moves with the same instance apart; none but "" changes its shape. world_from_data:
        where the description places something else than the object's own space."""
        if not is_blurred(self._context, instance):
            return
        track = Track(kind, number, instance.object.name, step_exponent(instance.object), mesh=mesh)
        if record is not None and "velocity" in getattr(instance.object.data, "attributes", ()):
            self._context.warn(
                f"object '{instance.object.name}': the velocities of its vertices are not read; they blur "
                "where modifiers or shape keys move them"
            )
        if world_from_data is not None:
            track.object_from_data = np.linalg.pinv(matrix4(instance.matrix_world)) @ world_from_data
        self._follow(track, instance, record, part)

    def is_wanted(self, scene):
        """Tells whether export() has anything to do for a description.Scene."""
        return scene.shutter[0] != scene.shutter[1]

    def _follow(self, track, instance, record, part=""):
        """Takes a track up, the shape of its mesh with it where that may change. record, part: see add()."""
        if record is not None and part == "" and _deforms(instance, self._context.scene):
            track.record = self._records[track.mesh] = record
            record.corners  # noqa: B018 - read while the mesh is there, for shape_of()
        self._parts.add(part)
        key = identity(instance), part
        self._tracks[key] = None if key in self._tracks else track

    def export(self, engine, scene):
        """Returns `scene`, a description.Scene with its shutter, in motion. engine: the RenderEngine that
        renders it; it evaluates each step and in the end the frame itself again."""
        blender_scene = self._context.scene
        frame, subframe = blender_scene.frame_current, blender_scene.frame_subframe
        camera = _Camera(engine, self._context)
        times = self._times(scene, camera)
        steps = len(times)
        try:
            for step, time in enumerate(times):
                whole = math.floor(frame + subframe + time)
                engine.frame_set(whole, float(frame + subframe + time - whole))
                camera.read()
                self._read_step(step, steps)
        finally:
            engine.frame_set(frame, subframe)
            self._context.cache.history.doubt(self._context.depsgraph)
        return self._applied(scene, camera, steps)

    def _times(self, scene, camera):
        """Returns when everything is read, in frames from this one."""
        exponents = [track.exponent for track in self._tracks.values() if track is not None]
        return np.linspace(*scene.shutter, 2 ** max([camera.exponent, *exponents]) + 1)

    def _read_step(self, step, steps):
        read_shapes = set()
        for instance in self._context.depsgraph.object_instances:
            key = identity(instance)
            for track in filter(None, [self._tracks.get((key, part)) for part in self._parts]):
                self._read_track(track, instance, step, steps, read_shapes)

    def _read_track(self, track, instance, step, steps, read_shapes):
        if len(track.matrices) != step:
            return
        track.matrices.append(matrix4(instance.matrix_world))
        if track.record is None or track.mesh in read_shapes or step % _stride(track, steps) != 0:
            return
        read_shapes.add(track.mesh)
        self._read_shape(track, instance.object)

    def _read_shape(self, track, item):
        shape = self._shapes.setdefault(track.mesh, ([], []))
        if shape is None:
            return
        read_now = track.record.shape_of(item.data)
        if read_now is None:
            self._shapes[track.mesh] = None
            self._context.warn(
                f"object '{item.name}': its number of vertices changes while the shutter is open; its shape "
                "is not blurred"
            )
            return
        for values, more in zip(shape, read_now, strict=True):
            values.append(more)

    def _applied(self, scene, camera, steps):
        placed = {
            "instance": list(scene.instances),
            "volume": list(scene.volumes),
            "light": list(scene.lights),
        }
        meshes = list(scene.meshes)
        for track in filter(None, self._tracks.values()):
            moves = len(track.matrices) == steps and _differ(track.matrices)
            if moves:
                if track.kind == "light" and _changes_scale(track.matrices):
                    self._context.warn(
                        f"light '{track.name}': its scale changes while the shutter is open; it keeps "
                        "its size at the frame"
                    )
                items = placed[track.kind]
                matrices = np.stack(track.matrices[:: _stride(track, steps)]) @ track.object_from_data
                items[track.number] = dataclasses.replace(items[track.number], motion=matrices)
        for number, shape in self._shapes.items():
            if shape is not None and _differ(shape[0]):
                normals = None if any(n is None for n in shape[1]) else np.stack(shape[1])
                motion, normals = self._records[number].moving(np.stack(shape[0]), normals)
                meshes[number] = dataclasses.replace(meshes[number], motion=motion, motion_normals=normals)
        return dataclasses.replace(
            scene,
            instances=tuple(placed["instance"]),
            volumes=tuple(placed["volume"]),
            lights=tuple(placed["light"]),
            meshes=tuple(meshes),
            camera=camera.applied(scene.camera, steps),
            warnings=tuple(self._context.warnings),
        )


class _Camera:
    """The camera on its way."""

    def __init__(self, engine, context):
        self._context = context
        self._item = engine.camera_override or context.scene.camera
        settings = getattr(self._item, "cycles", None)
        self._blurred = getattr(settings, "use_motion_blur", True)
        self.exponent = step_exponent(self._item) if self._blurred else 1
        self.matrices = []

    def read(self):
        camera = self._item.evaluated_get(self._context.depsgraph)
        self.matrices.append(matrix4(camera.matrix_world))

    def applied(self, camera, steps):
        """Returns the description.Camera in motion."""
        if not self._blurred or not _differ(self.matrices):
            return camera
        stride = (steps - 1) // 2**self.exponent
        return dataclasses.replace(camera, motion=np.stack(self.matrices[::stride]))


def _stride(track, steps):
    """Returns how many of the finest steps make one of the track's."""
    return (steps - 1) // 2**track.exponent


def _changes_scale(matrices):
    return _differ([np.linalg.norm(m[:3, :3], axis=0) for m in matrices])


def _differ(values):
    """Returns whether arrays differ by more than rounding."""
    return any(np.abs(value - values[0]).max(initial=0) > STILL for value in values[1:])


def _deforms(instance, scene):
    """Returns whether an instance's shape may change: an object that shows its own mesh through modifiers
    or shape keys."""
    item = instance.object
    if item.type in ("CURVES", "POINTCLOUD"):
        return getattr(getattr(item, "cycles", None), "use_deform_motion", True)
    if item.type != "MESH" or not getattr(getattr(item, "cycles", None), "use_deform_motion", True):
        return False
    original = item.original
    if original.type != "MESH" or (instance.is_instance and instance.parent is not None):
        return False
    return original.is_deform_modified(scene, "RENDER") or original.is_modified(scene, "RENDER")
