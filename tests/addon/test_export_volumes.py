# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume objects and fluid domains: which file, where it stands, how dense it is."""

import gc
from pathlib import Path

import numpy as np
import pytest
from nephele.export import ExportError
from nephele.export.blackbody import blackbody_rgb
from nephele.export.nodes_volume import BOLTZMANN
from programs import with_nodes
from volume_trees import evaluate


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
    ("mode", "offset", "frame", "expected"),
    [
        ("CLIP", 0, 2, 2),
        ("CLIP", 0, 9, None),
        ("CLIP", 1, 1, 2),
        ("EXTEND", 0, 9, 3),
        ("REPEAT", 0, 4, 1),
    ],
)
def test_sequence(bpy, link, make_vdb, export, mode, offset, frame, expected):
    paths = [make_vdb(f"seq_{k:03d}.vdb") for k in (1, 2, 3)]
    data = bpy.data.volumes.new("Sequence")
    data.filepath = str(paths[0])
    data.is_sequence, data.frame_start, data.frame_duration = True, 1, 3
    data.frame_offset, data.sequence_mode = offset, mode
    link("Sequence", data)
    bpy.context.scene.frame_set(frame)
    found = [Path(v.path).name for v in export().volumes]
    assert found == ([] if expected is None else [f"seq_{expected:03d}.vdb"])


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


@pytest.fixture
def domain(bpy, link, tmp_path):
    """Returns a gas domain of 2 x 2 x 4 m (object space), 8 cells along z, with an empty cache folder.

    Its modifier is not evaluated: the fluid solver of the bpy modules aborts when it is freed.
    """
    mesh = bpy.data.meshes.new("Domain")
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (0, 4)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5)])
    item = link("Domain", mesh)
    modifier = item.modifiers.new("Fluid", "FLUID")
    modifier.show_viewport = False
    modifier.fluid_type = "DOMAIN"
    settings = modifier.domain_settings
    settings.domain_type, settings.resolution_max, settings.cache_type = "GAS", 8, "ALL"
    settings.cache_directory = str(tmp_path / "cache")
    (tmp_path / "cache" / "data").mkdir(parents=True)
    return item


def cached(domain, frame):
    folder = Path(domain.modifiers[0].domain_settings.cache_directory, "data")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"fluid_data_{frame:04d}.vdb"
    path.write_bytes(b"")
    return path


def test_missing_cache_frame_warns(domain, export):
    scene = export()
    assert (scene.volumes, scene.instances) == ((), ())
    assert any(
        "'Domain': no cache of frame 1" in text and "fluid_data_0001.vdb" in text for text in scene.warnings
    )


def test_fluid_frame_and_offset(bpy, domain, export):
    paths = [cached(domain, frame) for frame in (1, 2, 3)]
    bpy.context.scene.frame_set(3)
    assert export().volumes[0].path == str(paths[2])
    domain.modifiers[0].domain_settings.cache_frame_offset = 1
    domain.update_tag()
    assert export().volumes[0].path == str(paths[1])


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 2, 2), (1, 3, 1)])
def test_fluid_placement(domain, export, scale):
    """Cell (i, j, k) of the cache stands at its index times the voxel size; its centre must come out right.
    The voxel size counts the object's scale."""
    cached(domain, 1)
    domain.location, domain.scale = (10, 0, 0), scale
    scene = export()
    (result,) = scene.volumes
    size = np.array((2, 2, 4)) * scale
    voxel = size.max() / 8
    first = result.world_from_object @ (0, 0, 0, 1)
    assert np.allclose(first[:3], np.array((10, 0, 0)) + np.array((-1, -1, 0)) * scale + voxel / 2)
    step = result.world_from_object @ (voxel, voxel, voxel, 0)
    assert np.allclose(step[:3], voxel)  # cells are cubes in the world
    assert result.density_scale == 1.0
    assert scene.instances == ()  # the domain's box is no surface


def test_fluid_placement_in_a_parent(domain, link, export):
    """A parent's scale comes on top: the simulation knows the object's own only."""
    cached(domain, 1)
    domain.parent = link("Parent", None)
    domain.parent.scale = (3, 3, 3)
    step = export().volumes[0].world_from_object @ (0.5, 0, 0, 0)
    assert np.allclose(step[:3], (1.5, 0, 0))


def test_fluid_fire(bpy, domain, export):
    """Blender's temperature of a domain goes from ignition to the hottest flame, in thousands of kelvin."""
    settings = domain.modifiers[0].domain_settings
    settings.flame_ignition, settings.flame_max_temp = 1.25, 1.75
    cached(domain, 1)  # Blender deletes the cache when such a setting changes
    material = with_nodes(bpy.data.materials.new("Fire"))
    shader = material.node_tree.nodes.new("ShaderNodeVolumePrincipled")
    shader.inputs["Blackbody Intensity"].default_value = 1.0
    output = material.node_tree.nodes["Material Output"]
    material.node_tree.links.new(shader.outputs[0], output.inputs["Volume"])
    domain.data.materials.append(material)
    scene = export()
    smoke, fire = scene.materials[scene.volumes[0].material].volume
    assert (smoke.density_grid, fire.grids) == ("density", ("flame",))
    emission = evaluate(fire, {"flame": 0.5})["emission"]
    assert emission == pytest.approx(BOLTZMANN * 1500**4 * blackbody_rgb(1500), rel=1e-5)
    assert scene.warnings == ()
