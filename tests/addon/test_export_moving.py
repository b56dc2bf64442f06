# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur of objects, shapes and the camera as the exporter reads it from Blender in a final render."""

import numpy as np
import pytest
from keyframes import animate
from nephele import blend_source

TRIANGLE = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]


@pytest.fixture
def final(bpy, camera):
    """Returns a function that exports the current scene as a final render does."""
    engine = blend_source.engine_class(bpy)
    bpy.utils.register_class(engine)
    render = bpy.context.scene.render
    render.use_motion_blur, render.motion_blur_shutter = True, 1.0
    render.use_compositing = render.use_sequencer = False
    bpy.context.scene.frame_set(5)

    def run():
        engine.outcome.clear()
        render.engine = blend_source.EXPORT_ENGINE
        bpy.ops.render.render()
        render.engine = "NEPHELE"
        result = engine.outcome["result"]
        if isinstance(result, BaseException):
            raise result
        return result

    yield run
    render.engine = "NEPHELE"
    bpy.utils.unregister_class(engine)


@pytest.fixture
def triangle(bpy, link):
    mesh = bpy.data.meshes.new("Triangle")
    mesh.from_pydata(TRIANGLE, [], [(0, 1, 2)])
    return link("Triangle", mesh)


def places(motion):
    return motion[:, :3, 3].round(5).tolist()


def test_an_object_on_its_way(bpy, triangle, final):
    animate(triangle, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    assert scene.shutter == (-0.5, 0.5)
    (instance,) = scene.instances
    assert places(instance.motion) == [[4.5, 0, 0], [5, 0, 0], [5.5, 0, 0]]
    assert instance.world_from_object[:3, 3].tolist() == [5, 0, 0]
    assert scene.camera.motion is None and scene.meshes[0].motion is None
    assert scene.warnings == ()
    assert bpy.context.scene.frame_current == 5


@pytest.mark.parametrize(("position", "first"), [("START", 5), ("END", 4), ("CENTER", 4.5)])
def test_shutter_position(bpy, triangle, final, position, first):
    bpy.context.scene.render.motion_blur_position = position
    animate(triangle, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    (instance,) = final().instances
    assert places(instance.motion) == [[first, 0, 0], [first + 0.5, 0, 0], [first + 1, 0, 0]]


def test_nothing_moves(triangle, final):
    scene = final()
    assert scene.instances[0].motion is None and scene.camera.motion is None


def test_without_blur_everything_stands_still(bpy, triangle, final):
    bpy.context.scene.render.use_motion_blur = False
    animate(triangle, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    assert scene.shutter == (0, 0) and scene.instances[0].motion is None


def test_steps_are_each_objects_own(triangle, camera, final):
    if not hasattr(triangle, "cycles"):
        pytest.skip("Cycles, which owns the setting, is absent")
    triangle.cycles.motion_steps = 2
    animate(triangle, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    animate(camera, "location", {0: (0, 0, 5), 10: (0, 10, 5)})
    scene = final()
    assert places(scene.instances[0].motion) == [[x, 0, 0] for x in (4.5, 4.75, 5, 5.25, 5.5)]
    assert places(scene.camera.motion) == [[0, y, 5] for y in (4.5, 5, 5.5)]
    triangle.cycles.use_motion_blur = camera.cycles.use_motion_blur = False
    scene = final()
    assert scene.instances[0].motion is None and scene.camera.motion is None


def test_a_shape_key(triangle, final):
    triangle.shape_key_add(name="Basis")
    key = triangle.shape_key_add(name="Up")
    key.data[0].co = (0, 0, 10)
    animate(key, "value", {0: 0.0, 10: 1.0})
    (mesh,) = final().meshes
    assert mesh.motion.shape == (3, 3, 3) and mesh.motion.dtype == np.float32
    assert mesh.motion[:, 0, 2].tolist() == pytest.approx([4.5, 5, 5.5])
    assert mesh.motion_normals is None  # flat


def test_normals_of_a_smooth_shape_turn(triangle, final):
    triangle.data.polygons[0].use_smooth = True
    triangle.shape_key_add(name="Basis")
    key = triangle.shape_key_add(name="Up")
    key.data[1].co = (1, 0, 10)
    animate(key, "value", {0: 0.0, 10: 1.0})
    (mesh,) = final().meshes
    assert mesh.motion_normals.shape == (3, 1, 3, 3)
    slopes = np.array([4.5, 5, 5.5])
    expected = -slopes / np.sqrt(1 + slopes**2)
    assert mesh.motion_normals[:, 0, 0, 0].tolist() == pytest.approx(expected.tolist(), abs=1e-5)


def test_a_shape_of_changing_vertices_keeps_its_shape(triangle, final):
    build = triangle.modifiers.new("Build", "ARRAY")
    build.use_relative_offset = True
    animate(build, "count", {4: 1, 5: 2, 6: 4})
    scene = final()
    assert scene.meshes[0].motion is None
    assert scene.warnings == (
        "object 'Triangle': its number of vertices changes while the shutter is open; its shape is not "
        "blurred",
    )


def test_instances_of_a_collection_move_apart(bpy, triangle, link, final):
    collection = bpy.data.collections.new("Group")
    collection.objects.link(triangle)
    bpy.context.scene.collection.objects.unlink(triangle)
    for number in range(2):
        empty = link(f"Empty {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        animate(empty, "location", {0: (0, number, 0), 10: (10 * number, number, 0)})
    motions = [instance.motion for instance in final().instances]
    assert [m is not None for m in motions].count(True) == 1
    (moving,) = (m for m in motions if m is not None)
    assert places(moving) == [[4.5, 1, 0], [5, 1, 0], [5.5, 1, 0]]


def test_lamps_that_move_are_named(bpy, triangle, link, final):
    lamp = link("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    animate(lamp, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    assert scene.warnings == (
        "light 'Lamp': it moves while the shutter is open; it is shown as it stands at the frame",
    )
