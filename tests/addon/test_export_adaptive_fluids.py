# SPDX-License-Identifier: GPL-3.0-or-later
"""Adaptive gas domains: where the part of the cells stands that a frame's cache holds.

`adaptive_cache` is frame 1 of a fire in a domain of 20 x 20 x 32 cells of 10 cm, as Blender 3.4.1 baked it;
its 15 x 13 x 10 cells begin at cell (2, 3, 0). The same fire baked without Adaptive Domain is the same to the
last bit at that frame; sums of its cache are what is expected here.
"""

import gzip
import shutil
from pathlib import Path

import numpy as np
import pytest
from nephele.export import ExportError
from nephele.export.fluid_cells import STATE
from test_export_fluids import cached, domain, write_noise

CACHE = Path(__file__).with_name("adaptive_cache")
TOTAL, CENTRE = 218.888671875, (0, 0, 0.45)  # of the density in the whole bake: sum, mean place in m

__all__ = ["domain"]  # a fixture


@pytest.fixture
def adaptive(domain):
    """Returns the domain, adaptive."""
    domain.modifiers[0].domain_settings.use_adaptive_domain = True
    return domain


def write_state(domain, scale, first, count, whole=(4, 4, 8), **changes):
    """Writes the state of frame 1 as Mantaflow does; the domain is that of test_export_fluids.py."""
    low, high = (-1, -1, 0), (1, 1, 4)
    end = np.add(first, count)
    values = {"res": count, "end": end} | changes
    state = STATE.pack(
        75, *values["res"], 1 / 8, 0.1, *low, *high, *low, 0, 0, 0, 0, 0, 0, *np.diag((*scale, 1)).ravel(),
        *whole, *first, *values["end"], 0, 0, 0, 1.0, b"C01\0",
    )  # fmt: skip
    folder = Path(domain.modifiers[0].domain_settings.cache_directory, "config")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "config_0001.uni"
    path.write_bytes(gzip.compress(state))
    return path


def test_a_baked_cache_stands_where_the_whole_domain_has_its_gas(adaptive, export, openvdb, tmp_path):
    shutil.copytree(CACHE, tmp_path / "cache", dirs_exist_ok=True)
    scene = export()
    (volume,) = scene.volumes
    assert scene.warnings == ()
    grid = openvdb.read(volume.path, "density")
    values = np.zeros((32, 32, 32), np.float32)
    grid.copyToArray(values)
    cells = np.argwhere(values > 0)
    density = values[tuple(cells.T)].astype(float)
    assert density.sum() == pytest.approx(TOTAL, rel=1e-6)
    in_file = cells * grid.transform.voxelSize()
    in_world = in_file @ volume.world_from_object[:3, :3].T + volume.world_from_object[:3, 3]
    assert np.allclose(density @ in_world / density.sum(), CENTRE, atol=1e-5)
    voxel = volume.world_from_object[:3, :3] @ grid.transform.voxelSize()
    assert np.allclose(voxel, 0.1)
    # Generated coordinates are those of the whole domain.
    low, size = np.array(volume.generated_min), np.array(volume.generated_size)
    corners = [(volume.world_from_object @ (*corner, 1))[:3] for corner in (low, low + size)]
    assert np.allclose(corners, [(-1, -1, 0), (1, 1, 3.2)], atol=1e-6)


@pytest.mark.parametrize("scale", [(1, 1, 1), (0.5, 0.5, 0.75), (1, 3, 1)])
def test_placement_of_a_part(bpy, adaptive, export, scale):
    cached(adaptive, 1)
    write_state(adaptive, scale, (1, 0, 2), (2, 3, 5))
    bpy.context.scene.render.use_motion_blur, bpy.context.scene.render.fps = True, 25
    adaptive.location, adaptive.scale = (10, 0, 0), scale
    (volume,) = export().volumes
    side = np.max(np.array((2, 2, 4)) * scale)
    voxel, file_voxel = side / 8, side / 5
    first = (volume.world_from_object @ (0, 0, 0, 1))[:3]
    corner = np.array((10, 0, 0)) + np.array((-1, -1, 0)) * scale
    assert np.allclose(first, corner + (np.array((1, 0, 2)) + 0.5) * voxel)
    assert np.allclose(volume.world_from_object[:3, :3] @ np.full(3, file_voxel), voxel)
    # A cell in a tenth of a second is what a value of 1 means.
    moved = volume.world_from_object[:3, :3] @ (volume.velocity_scale, 0, 0)
    assert np.allclose(moved, (voxel * 2.5 / 25, 0, 0))


def test_noise_of_a_part(adaptive, export, openvdb):
    """Its cells are halves of the base's, in the scale of the file."""
    write_noise(adaptive, openvdb)  # 4 x 4 x 8 cells of 0.5 m by the files
    write_state(adaptive, (1, 1, 1), (3, 2, 1), (4, 4, 8), whole=(8, 8, 16))
    (volume,) = export().volumes
    grids = {grid.name: grid for grid in openvdb.readAll(volume.path)[0]}
    corner = np.array((-1, -1, 0)) + 0.25 * np.array((3, 2, 1))
    for name, voxel in (("density", 0.125), ("velocity", 0.25)):
        first = volume.world_from_object @ (*grids[name].transform.indexToWorld((0, 0, 0)), 1)
        assert np.allclose(first[:3], corner + voxel / 2)


def test_a_part_that_is_not_told_is_an_error(adaptive, export):
    cached(adaptive, 1)
    with pytest.raises(ExportError, match=r"fluid domain 'Domain': .*config_0001.uni does not tell"):
        export()
    path = write_state(adaptive, (1, 1, 1), (1, 0, 2), (2, 3, 5))
    good = path.read_bytes()
    for damaged in (good[:20], b"", b"no gzip", gzip.compress(gzip.decompress(good)[:-8])):
        path.write_bytes(damaged)
        with pytest.raises(ExportError, match="bake the fluid again"):
            export()
    for wrong in ({"first": (3, 0, 2)}, {"first": (-1, 0, 0)}, {"res": (2, 3, 4)}, {"count": (0, 3, 5)}):
        write_state(adaptive, (1, 1, 1), **({"first": (1, 0, 2), "count": (2, 3, 5)} | wrong))
        with pytest.raises(ExportError, match="no part of the domain"):
            export()
