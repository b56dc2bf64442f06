# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur of objects, shapes, volumes and the camera as the exporter reads it from Blender in a final
render."""

import gc
from pathlib import Path

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
        result = engine.outcome.pop("result")
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


def test_lamps_move(bpy, triangle, link, final):
    lamp = link("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    animate(lamp, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    assert scene.warnings == ()
    assert places(scene.lights[0].motion) == [[4.5, 0, 0], [5, 0, 0], [5.5, 0, 0]]


def test_lamps_that_grow_are_named(bpy, triangle, link, final):
    lamp = link("Lamp", bpy.data.lights.new("Lamp", "AREA"))
    animate(lamp, "scale", {0: (1, 1, 1), 10: (3, 3, 3)})
    assert any("light 'Lamp': its scale changes" in text for text in final().warnings)


def test_curves_deform(bpy, link, final):
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([2])
    data.attributes["position"].data.foreach_set("vector", [0, 0, 0, 0, 0, 1])
    item = link("Hair", data)
    animate(item, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    (instance,) = (i for i in final().instances if i.name == "Hair")
    assert places(instance.motion) == [[4.5, 0, 0], [5, 0, 0], [5.5, 0, 0]]


@pytest.fixture
def vdb(openvdb, tmp_path):
    """Returns the path of a VDB file with a block of density."""
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.copyFromArray(np.ones((4, 4, 4), np.float32))
    openvdb.write(str(tmp_path / "block.vdb"), grids=[grid])
    return tmp_path / "block.vdb"


def volume_object(bpy, link, name, path):
    data = bpy.data.volumes.new(name)
    data.filepath = str(path)
    return link(name, data)


def test_a_volume_on_its_way(bpy, link, vdb, final):
    """One that is left out, before it, does not take its place."""
    volume_object(bpy, link, "A", "")
    item = volume_object(bpy, link, "B", vdb)
    volume_object(bpy, link, "C", vdb)
    animate(item, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    moving, still = scene.volumes
    assert places(moving.motion) == [[4.5, 0, 0], [5, 0, 0], [5.5, 0, 0]]
    assert moving.world_from_object[:3, 3].tolist() == [5, 0, 0]
    assert (still.name, still.motion) == ("C", None)
    assert scene.warnings == ("volume 'A': it has no file; it is left out",)


def test_a_temporary_file_lives_as_long_as_the_scene(bpy, link, vdb, final):
    item = volume_object(bpy, link, "Displaced", vdb)
    item.modifiers.new("Displace", "VOLUME_DISPLACE")  # what it shows is in no file
    animate(item, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    gc.collect()
    path = Path(scene.volumes[0].path)
    assert scene.volumes[0].motion is not None
    assert path != vdb and path.is_file()
    del scene
    gc.collect()
    assert not path.exists()


def test_a_fluid_domain_on_its_way(bpy, link, final, tmp_path):
    """The cache's own place in the domain goes along."""
    mesh = bpy.data.meshes.new("Domain")
    mesh.from_pydata(
        [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (0, 4)], [], [(0, 1, 3, 2), (4, 6, 7, 5)]
    )
    item = link("Domain", mesh)
    modifier = item.modifiers.new("Fluid", "FLUID")
    modifier.show_viewport = modifier.show_render = False  # the solver of the bpy modules aborts when freed
    modifier.fluid_type = "DOMAIN"
    settings = modifier.domain_settings
    settings.domain_type, settings.resolution_max, settings.cache_type = "GAS", 8, "ALL"
    settings.cache_directory = str(tmp_path / "cache")
    (tmp_path / "cache" / "data").mkdir(parents=True)
    (tmp_path / "cache" / "data" / "fluid_data_0005.vdb").write_bytes(b"")
    animate(item, "location", {0: (0, 0, 0), 10: (10, 0, 0)})
    scene = final()
    (volume,) = scene.volumes
    low = np.array((-1, -1, 0)) + 0.25  # half a voxel inside
    assert places(volume.motion) == [np.add(low, (x, 0, 0)).tolist() for x in (4.5, 5, 5.5)]
    assert np.allclose(volume.motion[1], volume.world_from_object, atol=1e-9)
    assert scene.warnings == ()
