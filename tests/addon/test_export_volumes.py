# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects: which file, where it stands, how dense it is, how it is read."""

import gc
from pathlib import Path

import numpy as np
import pytest
from nephele.export import ExportError
from programs import with_nodes


@pytest.fixture
def make_vdb(openvdb, tmp_path):
    """Returns a function (name) -> path of a VDB file with a block of density 2 in voxels 0 to 3."""

    def make(name, voxel=0.5):
        grid = openvdb.FloatGrid()
        grid.name = "density"
        grid.copyFromArray(np.full((4, 4, 4), 2.0, np.float32))
        grid.transform = openvdb.createLinearTransform(voxel)
        openvdb.write(str(tmp_path / name), grids=[grid])
        return tmp_path / name

    return make


@pytest.fixture
def volume(bpy, link, make_vdb):
    """Returns a Volume object that shows a file."""
    data = bpy.data.volumes.new("Smoke")
    data.filepath = str(make_vdb("smoke.vdb"))
    return link("Smoke", data)


def test_file_is_used_directly(volume, export):
    volume.location = (1, 2, 3)
    scene = export()
    (result,) = scene.volumes
    assert result.path == volume.data.filepath
    assert np.allclose(result.world_from_object[:3, 3], (1, 2, 3))
    assert scene.warnings == ()


def test_volume_without_material_gets_blenders_default(volume, export):
    scene = export()
    material = scene.materials[scene.volumes[0].material]
    (closure,) = material.volume
    assert material.surface is None
    assert (closure.sigma_s, closure.sigma_a, closure.density_grid) == ((0.5,) * 3, (0.5,) * 3, "density")


@pytest.mark.parametrize(
    ("scale", "expected"), [((2, 2, 2), 0.5), ((3, 1, 1), (11 / 3) ** -0.5), ((-1, 1, 1), 1.0)]
)
def test_object_space_density(volume, export, scale, expected):
    volume.scale = scale
    volume.data.render.space = "OBJECT"
    assert export().volumes[0].density_scale == pytest.approx(expected, rel=1e-6)
    volume.data.render.space = "WORLD"
    assert export().volumes[0].density_scale == 1.0


def test_missing_file_is_an_error_that_names_it(volume, export):
    volume.data.filepath = "/nowhere/smoke.vdb"
    with pytest.raises(ExportError, match=r"volume 'Smoke': .*/nowhere/smoke.vdb.*check"):
        export()


def test_empty_volume_warns(bpy, link, export):
    link("Void", bpy.data.volumes.new("Void"))
    scene = export()
    assert (scene.volumes, len(scene.warnings)) == ((), 1)
    assert "volume 'Void'" in scene.warnings[0]


def test_shaders_know_the_grids_of_the_file(bpy, volume, export, openvdb, tmp_path):
    """One material on two files: the tint of one is a colour, that of the other a number."""
    number, color = openvdb.FloatGrid(), openvdb.Vec3SGrid()
    for grid in (number, color):
        grid.name = "tint"
        grid.fill((0, 0, 0), (1, 1, 1), 0.5 if grid is number else (1.0, 0.5, 0.25))
    paths = [tmp_path / "number.vdb", tmp_path / "color.vdb"]
    for path, grid in zip(paths, (number, color), strict=True):
        openvdb.write(str(path), grids=[grid])
    material = with_nodes(bpy.data.materials.new("Tinted"))
    tree = material.node_tree
    shine, tint = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeAttribute")
    tint.attribute_name = "tint"
    tree.links.new(tint.outputs["Color"], shine.inputs["Color"])
    tree.links.new(shine.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    second = volume.copy()
    second.data = volume.data.copy()
    bpy.context.scene.collection.objects.link(second)
    for item, path in zip((volume, second), paths, strict=True):
        item.data.filepath = str(path)
        item.data.materials.append(material)
    scene = export()
    found = {Path(v.path).name: scene.materials[v.material].volume[0] for v in scene.volumes}
    assert (found["number.vdb"].emission_grid, found["number.vdb"].program) == ("tint", None)
    assert (found["color.vdb"].emission_grid, found["color.vdb"].grids) == (None, ("tint",))
    assert scene.warnings == ()


@pytest.mark.parametrize(
    ("mode", "offset", "expected"),  # the files shown at frames -1 to 8; the sequence stands at 2 to 4
    [
        ("CLIP", 0, (None, None, None, 1, 2, 3, None, None, None, None)),
        ("CLIP", 1, (None, None, None, 2, 3, 4, None, None, None, None)),
        ("EXTEND", 0, (1, 1, 1, 1, 2, 3, 3, 3, 3, 3)),
        ("EXTEND", 2, (3, 3, 3, 3, 4, 5, 5, 5, 5, 5)),
        ("REPEAT", 0, (1, 2, 3, 1, 2, 3, 1, 2, 3, 1)),
        ("REPEAT", 1, (2, 3, 4, 2, 3, 4, 2, 3, 4, 2)),
        ("PING_PONG", 0, (2, 3, 2, 1, 2, 3, 2, 1, 2, 3)),
    ],
)
def test_sequence(bpy, link, make_vdb, export, mode, offset, expected):
    paths = [make_vdb(f"seq_{k:03d}.vdb") for k in range(1, 6)]
    data = bpy.data.volumes.new("Sequence")
    data.filepath = str(paths[0])
    data.is_sequence, data.frame_start, data.frame_duration = True, 2, 3
    data.frame_offset, data.sequence_mode = offset, mode
    link("Sequence", data)
    found = []
    for frame in range(-1, 9):
        bpy.context.scene.frame_set(frame)
        found.append([int(Path(v.path).stem[-3:]) for v in export().volumes])
    assert found == [[] if k is None else [k] for k in expected]


def test_missing_frame_of_a_sequence_is_an_error(bpy, link, make_vdb, export):
    data = bpy.data.volumes.new("Sequence")
    data.filepath = str(make_vdb("seq_001.vdb"))
    data.is_sequence, data.frame_duration = True, 3
    link("Sequence", data)
    bpy.context.scene.frame_set(2)
    with pytest.raises(ExportError, match=r"volume 'Sequence': .*cannot be read .*seq_002.vdb.*the frame"):
        export()


@pytest.mark.parametrize(("choice", "expected"), [("FULL", "full"), ("HALF", "half"), ("VARIABLE", "file")])
def test_precision_and_clipping(volume, export, choice, expected):
    volume.data.render.precision, volume.data.render.clipping = choice, 0.25
    (result,) = export().volumes
    assert (result.precision, result.clipping) == (expected, 0.25)


def test_object_attributes(volume, export):
    volume.location, volume.color, volume.pass_index = (5, 0, 0), (0.25, 0.5, 0.75, 1), 7
    (result,) = export().volumes
    assert result.color == (0.25, 0.5, 0.75, 1)
    assert result.pass_index == 7
    assert 0 < result.random < 1
    # One leaf of 8^3 voxels of 0.5 m, whole cubes, as Blender has it; the object's place does not count.
    assert np.allclose(result.generated_min, -0.25)
    assert np.allclose(result.generated_size, 4)


def test_instances_of_one_file(bpy, volume, export):
    collection = bpy.data.collections.new("Clouds")
    bpy.context.scene.collection.objects.unlink(volume)
    collection.objects.link(volume)
    for x in (3, 8):
        empty = bpy.data.objects.new(f"At {x}", None)
        empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", collection, (x, 0, 0)
        bpy.context.scene.collection.objects.link(empty)
    results = export().volumes
    assert [result.path for result in results] == [volume.data.filepath] * 2
    assert sorted(result.world_from_object[0, 3] for result in results) == [3, 8]
    assert results[0].material == results[1].material
    assert results[0].random != results[1].random


def test_instances_made_by_geometry_nodes(bpy, link, volume, export):
    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata([(0, 0, 0), (4, 0, 0)], [], [])
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for direction in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    scatter, info = tree.nodes.new("GeometryNodeInstanceOnPoints"), tree.nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value, info.inputs["As Instance"].default_value = volume, True
    tree.links.new(tree.nodes.new("NodeGroupInput").outputs[0], scatter.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0])
    link("Scatter", mesh).modifiers.new("Nodes", "NODES").node_group = tree
    volume.location = (0, 9, 0)
    results = export().volumes
    assert {result.path for result in results} == {volume.data.filepath}
    places = sorted(tuple(result.world_from_object[:2, 3].tolist()) for result in results)
    assert places == [(0, 0), (0, 9), (4, 0)]  # the original is seen, too


def test_modified_volume_is_saved_and_cleaned_up(bpy, volume, export, openvdb):
    texture = bpy.data.textures.new("Noise", "CLOUDS")
    modifier = volume.modifiers.new("Displace", "VOLUME_DISPLACE")
    modifier.texture, modifier.strength = texture, 0.1
    scene = export()
    path = Path(scene.volumes[0].path)
    assert path != Path(volume.data.filepath)
    assert [grid.name for grid in openvdb.readAllGridMetadata(str(path))] == ["density"]
    del scene
    gc.collect()
    assert not path.exists()


def test_volume_from_geometry_nodes(bpy, link, export, openvdb):
    mesh = bpy.data.meshes.new("Point")
    mesh.from_pydata([(0, 0, 0)], [], [])
    item = link("Maker", mesh)
    tree = bpy.data.node_groups.new("Cube", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    cube = tree.nodes.new("GeometryNodeVolumeCube")
    tree.links.new(cube.outputs[0], tree.nodes.new("NodeGroupOutput").inputs[0])
    item.modifiers.new("Nodes", "NODES").node_group = tree
    item.scale = (2, 2, 2)
    scene = export()
    (result,) = scene.volumes
    assert openvdb.readAllGridMetadata(result.path)[0].name == "density"
    assert np.allclose(np.diag(result.world_from_object), (2, 2, 2, 1))
