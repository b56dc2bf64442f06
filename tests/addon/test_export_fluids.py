# SPDX-License-Identifier: GPL-3.0-or-later
"""Gas domains: which files of the cache, where they stand, how they move."""

import gc
import sys
from pathlib import Path

import numpy as np
import pytest
from nephele.export import ExportError
from nephele.export.blackbody import blackbody_rgb
from nephele.export.nodes_volume import BOLTZMANN
from programs import with_nodes
from volume_trees import evaluate


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


def test_frames_without_motion_blur_have_no_velocity(domain, export):
    cached(domain, 1)
    (result,) = export().volumes
    assert result.velocity_grids == ()


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


def test_velocity_is_in_cells_per_unit_of_mantaflows_time(bpy, domain, export):
    bpy.context.scene.render.use_motion_blur = True
    bpy.context.scene.render.fps = 50
    settings = domain.modifiers[0].domain_settings
    settings.time_scale, settings.velocity_scale = 2, 3
    domain.scale = (1, 1, 2)  # cells of 1 m
    cached(domain, 1)  # only now: a new setting empties the cache
    (result,) = export().volumes
    assert result.velocity_grids == ("velocity",)
    assert result.velocity_scale == pytest.approx(1 * 2.5 / 50 * 2 * 3)


def test_clipping_and_generated_box(domain, export):
    cached(domain, 1)
    domain.modifiers[0].domain_settings.clipping = 0.125
    domain.location, domain.scale = (7, 0, 0), (1, 3, 1)
    (result,) = export().volumes
    assert (result.clipping, result.precision) == (0.125, "file")
    low, size = np.array(result.generated_min), np.array(result.generated_size)
    corners = [(result.world_from_object @ (*corner, 1))[:3] for corner in (low, low + size)]
    assert np.allclose(corners, [(6, -3, 0), (8, 3, 4)])


def write_noise(domain, openvdb, noise_scale=2):
    """Writes the caches of frame 1 as Mantaflow names and places them: 4 x 4 x 8 cells of 0.5 m."""
    domain.modifiers[0].domain_settings.use_noise = True
    folder = Path(domain.modifiers[0].domain_settings.cache_directory)
    for kind in ("data", "noise"):
        (folder / kind).mkdir(parents=True, exist_ok=True)

    def grid(name, factor, value, kind=openvdb.FloatGrid):
        result = kind()
        result.name = name
        width = (3,) if kind is openvdb.Vec3SGrid else ()
        result.copyFromArray(np.full((4 * factor, 4 * factor, 8 * factor, *width), value, np.float32))
        result.transform = openvdb.createLinearTransform(0.5 / factor)
        return result

    coarse = [
        grid("density", 1, 1.0),
        grid("temperature", 1, 2.0),
        grid("velocity", 1, -3.0, openvdb.Vec3SGrid),
    ]
    fine = [grid("density_noise", noise_scale, 5.0), grid("flame_noise", noise_scale, 6.0)]
    openvdb.write(str(folder / "data" / "fluid_data_0001.vdb"), grids=coarse)
    openvdb.write(str(folder / "noise" / "fluid_noise_0001.vdb"), grids=fine)


def test_noise_refines_the_grids_it_has(domain, export, openvdb):
    write_noise(domain, openvdb)
    scene = export()
    (result,) = scene.volumes
    path = Path(result.path)
    grids = {grid.name: grid for grid in openvdb.readAll(str(path))[0]}
    assert set(grids) == {"density", "flame", "temperature", "velocity"}
    assert not any("noise" in text for text in scene.warnings)
    values = {name: grids[name].getConstAccessor().getValue((0, 0, 0)) for name in grids}
    assert values == {"density": 5, "flame": 6, "temperature": 2, "velocity": (-3, -3, -3)}
    corner = np.array((-1, -1, 0))  # of the domain: each grid's first cell stands half a voxel inside
    for name, voxel in (("density", 0.25), ("flame", 0.25), ("temperature", 0.5), ("velocity", 0.5)):
        first = result.world_from_object @ (*grids[name].transform.indexToWorld((0, 0, 0)), 1)
        assert np.allclose(first[:3], corner + voxel / 2)
        step = grids[name].transform.voxelSize()
        assert np.allclose(step, voxel)
    del scene, result
    gc.collect()
    assert not path.exists()


def test_absent_noise_leaves_the_base_with_a_warning(domain, export):
    path = cached(domain, 1)
    domain.modifiers[0].domain_settings.use_noise = True
    scene = export()
    assert scene.volumes[0].path == str(path)
    assert any("'Domain': no noise cache of frame 1" in text and "base" in text for text in scene.warnings)


def test_noise_is_an_error_where_blender_has_no_openvdb_for_python(domain, export, openvdb, monkeypatch):
    write_noise(domain, openvdb)
    monkeypatch.setitem(sys.modules, "openvdb", None)  # Debian's Blender and 4.2 bring none
    with pytest.raises(ExportError, match=r"fluid domain 'Domain': .*no OpenVDB for Python.*disable"):
        export()


def test_damaged_noise_is_an_error(domain, export, openvdb):
    write_noise(domain, openvdb)
    path = Path(domain.modifiers[0].domain_settings.cache_directory, "noise", "fluid_noise_0001.vdb")
    path.write_bytes(b"no VDB")
    with pytest.raises(ExportError, match=r"fluid domain 'Domain': .*fluid_noise_0001.vdb cannot be brought"):
        export()


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
