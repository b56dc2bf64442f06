# SPDX-License-Identifier: GPL-3.0-or-later
"""Where everything stands at the frame before and at the one after, for the pass Vector. As in Cycles there
is none with motion blur, which shows how things move by itself."""

import dataclasses

import numpy as np

from .moving import Track, Tracks
from .space import without_scale


def wants_vectors(context):
    """Tells whether an export is to read the frames beside its own."""
    return context.view_layer.use_pass_vector and not context.scene.render.use_motion_blur


class Neighbours(Tracks):
    """Objects with surfaces at both frames."""

    def add(self, kind, number, instance, *, record=None, mesh=-1, world_from_data=None, part=""):
        if kind == "instance":
            track = Track(kind, number, instance.object.name, 0, mesh=mesh)
            self._follow(track, instance, record, part)

    def is_wanted(self, scene):
        return True

    def _times(self, scene, camera):
        return np.array((-1.0, 1.0))

    def _applied(self, scene, camera, steps):
        instances, meshes = list(scene.instances), list(scene.meshes)
        for track in filter(None, self._tracks.values()):
            if len(track.matrices) == steps:
                instances[track.number] = dataclasses.replace(
                    instances[track.number], neighbours=np.stack(track.matrices)
                )
        for number, shape in self._shapes.items():
            if shape is not None:
                positions = np.stack(shape[0]).astype(np.float32)
                meshes[number] = dataclasses.replace(meshes[number], neighbours=positions)
        beside = np.stack([without_scale(matrix) for matrix in camera.matrices])
        return dataclasses.replace(
            scene,
            instances=tuple(instances),
            meshes=tuple(meshes),
            camera=dataclasses.replace(scene.camera, neighbours=beside),
            warnings=tuple(self._context.warnings),
        )
