# SPDX-License-Identifier: GPL-3.0-or-later
"""Camera: Blender's camera object to description.Camera."""

import numpy as np

from .. import description
from .context import ExportError
from .panorama import panorama
from .space import matrix4, viewplane, without_scale

KINDS = {"PERSP": "perspective", "ORTHO": "orthographic", "PANO": "panoramic"}


def export_camera(context, engine, width, height):
    """Returns the description.Camera of the frame (width, height in pixels).

    engine: RenderEngine that may override the camera, or None. Raises ExportError where there is no camera,
    or one with a lens that we do not have.
    """
    camera = (engine.camera_override if engine is not None else None) or context.scene.camera
    if camera is None:
        raise ExportError(
            f"scene '{context.scene.name}' has no camera; add one and make it the scene's camera"
        )
    camera = camera.evaluated_get(context.depsgraph)
    if camera.type != "CAMERA":
        raise ExportError(
            f"unsupported camera: object '{camera.name}' is a {camera.type.lower()}; use a camera object"
        )
    data = camera.data
    if data.type not in KINDS:
        raise ExportError(
            f"unsupported camera: '{camera.name}' is of type {data.type.title()}; use Perspective, "
            "Orthographic or Panoramic"
        )
    world_from_camera = without_scale(matrix4(camera.matrix_world))
    return description.Camera(
        name=camera.name,
        kind=KINDS[data.type],
        world_from_camera=world_from_camera,
        viewplane=_viewplane(context, camera, width, height),
        clip_start=data.clip_start,
        clip_end=data.clip_end,
        **(panorama(camera, width, height, context.scene.render) if data.type == "PANO" else {}),
        **_depth_of_field(context, camera, world_from_camera),
    )


def _viewplane(context, camera, width, height):
    """Returns (left, right, bottom, top), read off Blender's own projection matrix."""
    data = camera.data
    if data.type == "PANO":
        return (data.shift_x, 1.0 + data.shift_x, data.shift_y, 1.0 + data.shift_y)
    render = context.scene.render
    projection = camera.calc_matrix_camera(
        context.depsgraph, x=width, y=height, scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y
    )
    return viewplane(projection, camera.data.type == "PERSP")


def _depth_of_field(context, camera, world_from_camera):
    """Returns the lens fields of description.Camera; {} for a pinhole."""
    data, dof = camera.data, camera.data.dof
    if not dof.use_dof:
        return {}
    distance = dof.focus_distance
    if dof.focus_object is not None:
        target = _focus_point(dof, context.depsgraph)
        away = world_from_camera[:3, 3] - target
        around = data.type == "PANO"
        distance = float(np.linalg.norm(away)) if around else abs(float(world_from_camera[:3, 2] @ away))
    focal_length = 1.0 if data.type == "ORTHO" else data.lens * 1e-3
    return {
        "aperture_radius": focal_length / (2 * max(dof.aperture_fstop, 1e-5)),
        "blades": dof.aperture_blades if dof.aperture_blades >= 3 else 0,
        "blades_rotation": dof.aperture_rotation,
        "aperture_ratio": dof.aperture_ratio,
        "focus_distance": max(distance, 1e-5),
    }


def _focus_point(dof, depsgraph):
    """Returns the point (3,) in the world that the camera focuses on."""
    target = dof.focus_object.evaluated_get(depsgraph)
    matrix = matrix4(target.matrix_world)
    bone = (
        target.pose.bones.get(dof.focus_subtarget)
        if target.pose is not None and dof.focus_subtarget
        else None
    )
    return (matrix @ matrix4(bone.matrix) if bone is not None else matrix)[:3, 3]
