# SPDX-License-Identifier: GPL-3.0-or-later
"""Motion blur of objects, deforming meshes and the camera: closed forms, and one kind against another.

Time is uniform over the shutter, so what a pixel sees is the share of time for which something covers it.
Two renders that are compared have the same seed: where the motion is the same in another description, paths
are the same but for rounding.
"""

import numpy as np
import pytest
from nephele import description as d
from truth import (
    BOX_FILTER,
    Scene,
    assert_mean,
    box,
    constant_program,
    emission,
    finished,
    orthographic,
    perspective,
    placed,
)

SETTINGS = {**BOX_FILTER, "samples": 256, "seed": 3}
BLACK = constant_program(("diffuse", 0.0, 0.0, None))


def square(half=0.5, name="square"):
    """Returns a square around the origin in the plane z = 0."""
    corners = half * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], np.float32)
    return d.Mesh(name, corners, np.array([(0, 1, 2), (0, 2, 3)], np.int32))


def moving(mesh, matrices):
    """Returns a scene of a black mesh before a background of radiance 1, seen from above, 4 m wide."""
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), emission(1.0))
    motion = None if matrices is None else np.array(matrices)
    return scene.add(mesh, BLACK, motion=motion)


def along_x(positions):
    return [placed(x=x) for x in positions]


def columns(scene, **more):
    """Returns the mean radiance (64,) of the rows through the middle, by column, and the pixels' places."""
    image = scene.render(size=64, **(SETTINGS | more))["Combined"]
    return image[28:36].mean((0, 2)), (np.arange(64) + 0.5) / 16 - 2


def coverage(x, start, end, half):
    """Returns the share of time for which a square of that half width, moving from start to end, covers x."""
    if start == end:
        return np.clip(0.5 + 16 * (half - np.abs(x - start)), 0, 1)
    # Pixels have width 1/16: the mean over them of a piecewise linear function, by its integral.
    u = np.linspace(-0.5, 0.5, 401)[:, None] / 16 + x
    low, high = sorted(((u - half - start) / (end - start), (u + half - start) / (end - start)), key=np.mean)
    return (np.clip(high, 0, 1) - np.clip(low, 0, 1)).mean(0)


def test_a_square_in_uniform_motion_covers_by_its_share_of_time():
    values, x = columns(moving(square(), along_x((-1, 1))))
    expected = 1 - coverage(x, -1, 1, 0.5)
    assert expected.min() < 0.51
    assert np.abs(values - expected).max() < 0.02  # 2048 stratified times a column
    assert abs(values.mean() - expected.mean()) < 1e-3


def test_three_steps_are_two_motions():
    values, x = columns(moving(square(), along_x((-1, 0, 0))))
    expected = 1 - 0.5 * coverage(x, -1, 0, 0.5) - 0.5 * coverage(x, 0, 0, 0.5)
    assert np.abs(values - expected).max() < 0.03


def test_a_translated_mesh_and_a_translated_instance_are_the_same():
    mesh = square()
    shifted = np.stack([mesh.positions + np.array((x, 0, 0), np.float32) for x in (-1, 0.25, 1)])
    deforming = d.Mesh("square", mesh.positions, mesh.triangles, motion=shifted)
    images = [
        moving(*made).render(size=64, **SETTINGS)["Combined"]
        for made in ((deforming, None), (mesh, along_x((-1, 0.25, 1))))
    ]
    assert (images[0] != images[1]).mean() < 1e-3
    assert np.abs(images[0] - images[1]).max() < 0.02


@pytest.mark.parametrize("kind", ["orthographic", "perspective"])
def test_a_moving_camera_is_an_object_moving_the_other_way(kind):
    made = {"orthographic": orthographic, "perspective": perspective}[kind]
    still = made((0, 0, 5), (0, 0, 0), 4) if kind == "orthographic" else made((0, 0, 5), (0, 0, 0))
    steps = ((-1, 0.2, 0.1), (1, -0.2, -0.3))
    matrices = np.stack([placed(*step) @ still.world_from_camera for step in steps])
    camera = d.Camera(**(vars(still) | {"motion": matrices}))
    by_camera = Scene(camera, emission(1.0)).add(square(), BLACK)
    opposite = np.stack([placed(*(-np.array(step))) for step in steps])
    by_object = Scene(still, emission(1.0)).add(square(), BLACK, motion=opposite)
    images = [scene.render(size=48, **SETTINGS)["Combined"] for scene in (by_camera, by_object)]
    assert images[0].min() < 0.9
    assert np.abs(images[0] - images[1]).max() < 0.02
    assert abs(images[0].mean() - images[1].mean()) < 1e-4


def turned(angle):
    c, s = np.cos(angle), np.sin(angle)
    m = np.eye(4)
    m[:2, :2] = (c, -s), (s, c)
    return m


def test_a_turning_bar_covers_an_annulus_evenly():
    """A thin bar through a quarter turn given by its ends alone: each point of the quarter ring it sweeps is
    covered for the share of time that its width takes there. Straight interpolation of the matrices would cut
    the corner and never reach the outer ring in the middle of the turn."""
    bar = d.Mesh(
        "bar",
        np.array([(0.5, -0.1, 0), (1.5, -0.1, 0), (1.5, 0.1, 0), (0.5, 0.1, 0)], np.float32),
        np.array([(0, 1, 2), (0, 2, 3)], np.int32),
    )
    scene = moving(bar, (turned(0), turned(np.pi / 2)))
    image = scene.render(size=64, **SETTINGS)["Combined"][..., 0]
    x, y = np.meshgrid((np.arange(64) + 0.5) / 16 - 2, (np.arange(64) + 0.5) / 16 - 2)
    radius, angle = np.hypot(x, y), np.arctan2(y, x)
    inside = (radius > 0.7) & (radius < 1.4) & (angle > 0.25) & (angle < np.pi / 2 - 0.25)
    expected = 2 * np.arcsin(0.1 / radius[inside]) / (np.pi / 2)
    error = 1 - image[inside] - expected
    assert abs(error.mean()) < 5e-4
    assert np.abs(error).max() < 0.06


def test_shadows_move_with_their_objects():
    """A square far above a floor under parallel light from above casts a shadow of its own coverage; the
    camera is between them."""
    sun = d.Light("sun", "sun", np.eye(4), (np.pi,) * 3)
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), lights=(sun,))
    scene.add(square(10, "floor"), constant_program(("diffuse", 1.0, 0.0, None)))
    scene.add(square(), BLACK, motion=np.stack([placed(x=x, z=50) for x in (-1, 1)]))
    values, x = columns(scene, max_bounces=0)
    assert np.abs(values - (1 - coverage(x, -1, 1, 0.5))).max() < 0.03


def test_media_move_with_their_bounds():
    """A box of absorbing fog that moves: the mean of transmittances over time."""
    fog = d.VolumeClosure(sigma_a=(2.0, 2.0, 2.0))
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), emission(1.0))
    scene.add(box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), None, (fog,), motion=np.stack(along_x((-1, 1))))
    values, x = columns(scene)
    expected = 1 - coverage(x, -1, 1, 0.5) * (1 - np.exp(-2))
    assert np.abs(values - expected).max() < 0.03


def test_a_glowing_square_that_moves_lights_as_its_mean_over_time():
    """Its light is found by chance: the same as the mean of renders in which it stands still."""
    camera = orthographic((0, 0, 5), (0, 0, 0), 1)

    def made(**placement):
        scene = Scene(camera).add(square(5, "floor"), constant_program(("diffuse", 0.8, 0.0, None)))
        turned_over = square(0.5)
        return scene.add(turned_over, emission(5.0), visibility=~1 & 0b111111, **placement)

    still = [
        made(world_from_object=placed(x=x, z=1)).render(size=16, **SETTINGS)["Combined"].mean()
        for x in np.linspace(-1, 1, 21)
    ]
    weights = np.ones(21)
    weights[[0, -1]] = 0.5
    expected = float(np.average(still, weights=weights))
    image = made(motion=np.stack([placed(x=x, z=1) for x in (-1, 1)])).render(
        size=64, **(SETTINGS | {"samples": 128})
    )
    assert_mean(image["Combined"], expected, rounding=4e-3, most=0.01)


def test_the_plain_twin_moves_alike():
    scene = moving(square(), along_x((-1, 1)))
    values, x = columns(scene, integrator="plain")
    assert np.abs(values - (1 - coverage(x, -1, 1, 0.5))).max() < 0.03


def test_motion_is_deterministic_and_no_motion_takes_no_numbers():
    scene = moving(square(), along_x((-1, 1)))
    images = [
        scene.render(size=32, **(SETTINGS | {"samples": 16, "threads": threads}))["Combined"]
        for threads in (1, 2)
    ]
    assert np.array_equal(*images)
    standing = moving(square(), None)
    first = standing.render(size=32, **SETTINGS)["Combined"]
    second = finished(d.Scene(**(vars(standing.description(size=32, **SETTINGS)) | {"shutter": (-0.5, 0.5)})))
    assert np.array_equal(first, second["Combined"])


def test_faults_name_the_object():
    with pytest.raises(ValueError, match=r"square.*singular at some time"):
        moving(square(), (np.eye(4), np.zeros((4, 4)))).render(size=4, samples=1)
    with pytest.raises(ValueError, match=r"square.*1 steps"):
        moving(square(), (np.eye(4),)).render(size=4, samples=1)
    mesh = square()
    broken = d.Mesh("square", mesh.positions, mesh.triangles, motion=np.zeros((2, 3, 3), np.float32))
    with pytest.raises(ValueError, match=r"square.*number of vertices"):
        moving(broken, None).render(size=4, samples=1)


def test_a_cloud_moves_by_its_velocity(openvdb, tmp_path):
    """A block of absorbing density with one velocity everywhere: from where it is at the frame it moves
    forward and back, over the shutter's part of a frame."""
    density, velocity = openvdb.FloatGrid(), openvdb.Vec3SGrid()
    density.name, velocity.name = "density", "velocity"
    density.copyFromArray(np.ones((10, 10, 10), np.float32), ijk=(15, 15, 15))
    velocity.copyFromArray(np.broadcast_to(np.float32((4, 0, 0)), (40, 40, 40, 3)).copy())
    for grid in (density, velocity):
        grid.transform = openvdb.createLinearTransform(0.1)
    path = tmp_path / "block.vdb"
    openvdb.write(str(path), grids=[density, velocity])
    fog = d.VolumeClosure(sigma_a=(3.0, 3.0, 3.0), density_grid="density")
    scene = Scene(orthographic((0, 0, 5), (0, 0, 0), 4), emission(1.0))
    centred = placed(-1.95, -1.95, -1.95)  # of voxels 15 to 24
    scene.add_volume(path, fog, world_from_object=centred, velocity_grids=("velocity",), velocity_scale=0.5)
    still = scene.description(size=64, **SETTINGS)
    moving_cloud = d.Scene(**(vars(still) | {"shutter": (-0.5, 0.5)}))
    values = [finished(s)["Combined"][28:36].mean((0, 2)) for s in (still, moving_cloud)]
    # At time t the picture is that of the frame, moved by 2 t.
    x = (np.arange(64) + 0.5) / 16 - 2
    times = np.linspace(-0.5, 0.5, 801)
    expected = np.mean([np.interp(x - 2 * t, x, values[0], left=1, right=1) for t in times], axis=0)
    assert values[0].min() < 0.1
    assert expected.min() > 0.4
    assert np.abs(values[1] - expected).max() < 0.02
