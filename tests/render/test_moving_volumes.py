# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur of volume objects and of media that vary inside moving meshes: closed forms, and the average of
renders in which they stand, over the shutter.

Such an average takes so many times that what it misses is far below the noise; both sides are rendered anew
for every seed and compared by Welch's t (comparison.py), false alarm 2e-4 a comparison.
"""

import numpy as np
import pytest
from assembler import Code
from comparison import assert_same
from nephele import description as d
from test_motion_blur import SETTINGS, columns, coverage, turned
from truth import BOX_FILTER, NO_LIMIT, Scene, box, emission, finished, half_world, orthographic, placed

SEEDS, TIMES = 8, 48
SKY = half_world((0.3, 0.5, 1.0), (0.2, 0.15, 0.1))
EDGE = 0.1  # m, of a voxel


@pytest.fixture
def block(openvdb, tmp_path):
    """Returns the path of a VDB file: a cube of constant density 1, its edge 1 m, around the origin, and one
    velocity (4, 0, 0) all over 8 m."""
    density, velocity = openvdb.FloatGrid(), openvdb.Vec3SGrid()
    density.name, velocity.name = "density", "velocity"
    density.copyFromArray(np.ones((10, 10, 10), np.float32), ijk=(35, 35, 35))
    velocity.copyFromArray(np.broadcast_to(np.float32((4, 0, 0)), (80, 80, 80, 3)).copy())
    for grid in (density, velocity):
        grid.transform = openvdb.createLinearTransform(EDGE)
        grid.transform.postTranslate((-39.5 * EDGE,) * 3)
    path = tmp_path / "block.vdb"
    openvdb.write(str(path), grids=[density, velocity])
    return path


@pytest.fixture
def cloud(openvdb, tmp_path):
    """Returns the path of a VDB file with a cloud without symmetry, 1.6 m long."""
    x, y, z = np.mgrid[0:16, 0:12, 0:10].astype(np.float32)
    density = np.clip(1.2 - (x - 8) ** 2 / 50 - (y - 6) ** 2 / 30 - (z - 5) ** 2 / 20, 0, 1) * (0.3 + x / 20)
    grid = openvdb.FloatGrid()
    grid.name = "density"
    grid.copyFromArray(density)
    grid.transform = openvdb.createLinearTransform(EDGE)
    grid.transform.postTranslate((-0.75, -0.55, -0.45))
    path = tmp_path / "cloud.vdb"
    openvdb.write(str(path), grids=[grid])
    return path


def fog(sigma_a=2.0):
    return d.VolumeClosure(sigma_a=(sigma_a,) * 3, density_grid="density")


def before_light(path, closure, **more):
    """Returns a scene of a volume before a background of radiance 1, seen from above, 4 m wide."""
    return Scene(orthographic((0, 0, 5), (0, 0, 0), 4), emission(1.0)).add_volume(path, closure, **more)


@pytest.mark.parametrize("integrator", ["path", "plain"])
def test_a_block_of_constant_density_dims_by_its_share_of_time(block, integrator):
    """The mean of transmittances over the shutter, pixel by pixel."""
    motion = np.stack([placed(x=x) for x in (-1, 0.6)])
    scene = before_light(block, fog(), world_from_object=placed(x=0.3), motion=motion)
    values, x = columns(scene, interpolation="nearest", integrator=integrator)
    expected = 1 - coverage(x, -1, 0.6, 0.5) * (1 - np.exp(-2))
    assert expected.min() < 0.5
    # 512 stratified times a pixel, 8 pixels a column; ratio tracking's own noise stays below.
    assert np.abs(values - expected).max() < 0.03
    assert abs(values.mean() - expected.mean()) < 3e-3


def test_constant_coefficients_fill_a_box_that_moves(block):
    """A closure that reads no grid: its box moves alike. Stretched along the way, the depth is the box's."""
    flat = np.stack([placed(x=x) @ np.diag((1, 1, s, 1)) for x, s in ((-1, 1), (1, 3))])
    closure = d.VolumeClosure(sigma_a=(1.0,) * 3)
    values, x = columns(before_light(block, closure, motion=flat), interpolation="nearest")
    times = np.linspace(0, 1, 2001)
    edge = 0.5 + EDGE * np.array((0, 1))  # the box reaches as far as interpolation would, above
    inside = (x[:, None] > 2 * times - 1 - edge[0]) & (x[:, None] < 2 * times - 1 + edge[1])
    depth = (1 + EDGE) * (1 + 2 * times)
    expected = np.where(inside, np.exp(-depth), 1).mean(1)
    assert expected.min() < 0.6
    assert np.abs(values - expected).max() < 0.03


def test_velocity_and_motion_of_the_object_add_up(block):
    """The velocity belongs to the object's space, which turns and stretches: here its x axis points along the
    world's -x, and is twice as long. What the velocity carries is then carried by the object."""
    about = np.diag((-2.0, -2, 1, 1))
    motion = np.stack([placed(x=x) @ about for x in (-1, 1)])
    scene = before_light(
        block, fog(), world_from_object=about, motion=motion, velocity_grids=("velocity",), velocity_scale=0.2
    )
    still = scene.description(size=64, interpolation="nearest", **SETTINGS)
    moving = finished(d.Scene(**(vars(still) | {"shutter": (-0.25, 0.25)})))["Combined"][28:36].mean((0, 2))
    x = (np.arange(64) + 0.5) / 16 - 2
    # Within half a frame the density goes 0.4 m of its object's space, the wrong way.
    expected = 1 - coverage(x, -1 + 0.4, 1 - 0.4, 1.0) * (1 - np.exp(-2))
    assert expected.min() < 0.4
    assert np.abs(moving - expected).max() < 0.03


def pose(time):
    """Returns a placement at a time in [0, 1]: moves, turns and grows."""
    grown = np.diag((1 + 0.5 * time, 1 - 0.3 * time, 1 + 0.2 * time, 1))
    lift = placed(x=1.2 * time - 0.6, y=0.4 * time, z=0.3 * time)
    tilt = np.eye(4)
    tilt[1:3, 1:3] = turned(0.6 * time)[:2, :2]
    return lift @ turned(1.4 * time) @ tilt @ grown


def steps(count=17):
    return np.stack([pose(t) for t in np.linspace(0, 1, count)])


def still_and_moving(make, **settings):
    """Asserts that a scene in motion is the average of scenes that stand. make(motion=..) and
    make(world_from_object=..) give the description to either."""
    # Between placements, 1/16 of the shutter apart, what moves goes nearly as pose() does.
    lengths = {**BOX_FILTER, **NO_LIMIT, "max_bounces": 8, **settings}
    moving, standing = [], []
    for seed in range(SEEDS):
        image = finished(make(motion=steps(), seed=seed, samples=256, **lengths))["Combined"]
        moving.append(blocks(image))
        image = np.mean(
            [
                finished(
                    make(
                        world_from_object=pose((k + 0.5) / TIMES),
                        seed=100 + TIMES * seed + k,
                        samples=8,
                        **lengths,
                    )
                )["Combined"]
                for k in range(TIMES)
            ],
            axis=0,
        )
        standing.append(blocks(image))
    assert_same(moments_of(moving), moments_of(standing), SEEDS)


def blocks(image):
    return image.reshape(6, 4, 6, 4, 3).mean((1, 3))


def moments_of(images):
    images = np.array(images)
    whole = images.mean((1, 2))
    return tuple((x.mean(0), x.var(0, ddof=1) / SEEDS) for x in (images, whole))


def stripes(code, place):
    """Returns the register of a pattern of the point that operation `place` gives, between 0 and 1."""
    phase = code.run("dot", code.run(place), code.constant((4.0, 2.8, 1.6)))
    return code.run("multiply_add", code.run("sine", phase), code.constant(0.5), code.constant(0.5))


def mixed(place):
    """Returns a closure whose density follows the grid and stripes."""
    code = Code()
    density = code.run("grid", code.run("position"), mode=0)
    thick = code.run("multiply", code.run("multiply", density, stripes(code, place)), code.constant(9))
    scattered = code.run("multiply", thick, code.constant((1.0, 0.8, 0.5)))
    absorbed = code.run("multiply", thick, code.constant((0.1, 0.1, 0.3)))
    none = code.constant(0)
    program = code.program(("medium", 0, scattered, absorbed, none, none, none))
    return d.VolumeClosure(program=program, grids=("density",))


GREY = d.VolumeClosure(
    sigma_s=(4.0, 3.0, 2.0), sigma_a=(0.1,) * 3, phase=d.Phase(a=0.4), density_grid="density"
)


@pytest.mark.parametrize(
    ("closure", "settings"),
    [
        (GREY, {}),
        (GREY, {"majorant": "kdtree", "tracking": "decomposition", "distance_sampling": "delta"}),
        (GREY, {"majorant": "global", "transmittance": "ray_marching", "distance_sampling": "delta"}),
        (GREY, {"interpolation": "tricubic", "transmittance": "residual_ratio"}),
        (mixed("position"), {}),
        (mixed("object_coordinate"), {"distance_sampling": "nds_plus"}),
    ],
    ids=["grid", "kdtree", "marching", "tricubic", "world", "object"],
)
def test_a_cloud_on_its_way_is_the_average_of_clouds_that_stand(cloud, closure, settings):
    def make(**given):
        place = {k: given.pop(k) for k in ("motion", "world_from_object") if k in given}
        scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), SKY)
        scene.add_volume(cloud, closure, **place)
        return scene.description(size=24, **given)

    still_and_moving(make, **settings)


def test_a_mesh_whose_medium_varies_is_the_average_of_meshes_that_stand():
    code = Code()
    scattered = code.run("multiply", stripes(code, "object_coordinate"), code.constant((12.0, 9.0, 6.0)))
    none = code.constant(0)
    striped = d.VolumeClosure(program=code.program(("medium", 0, scattered, none, none, none, none)))

    def make(**given):
        place = {k: given.pop(k) for k in ("motion", "world_from_object") if k in given}
        scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), SKY)
        scene.add(box((-0.8, -0.5, -0.4), (0.8, 0.5, 0.4)), None, (striped,), **place)
        return scene.description(size=24, **given)

    still_and_moving(make)


def test_faults_name_the_volume(block):
    with pytest.raises(ValueError, match=r"volume.*singular at some time"):
        before_light(block, fog(), motion=np.stack((np.eye(4), np.zeros((4, 4))))).render(size=4, samples=1)
