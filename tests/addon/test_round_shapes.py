# SPDX-License-Identifier: GPL-3.0-or-later
"""Hair and points as tubes and balls: their shapes, and what the exporter makes of Blender's."""

import numpy as np
import pytest
from nephele.export.strands import balls, tubes


def areas(shape):
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def test_a_straight_tube_covers_what_a_cylinder_does():
    """A prism's mean width is its perimeter over pi: the lateral surface is that of the cylinder."""
    keys = np.array([(0, 0, z) for z in np.linspace(0, 2, 5)])
    shape = tubes(keys, np.full(5, 0.1), np.array([0, 5]), 4)
    assert areas(shape).sum() == pytest.approx(2 * np.pi * 0.1 * 2)
    assert np.allclose(shape.normals[:, 2], 0, atol=1e-6)
    assert np.allclose(np.linalg.norm(shape.normals, axis=1), 1)


def test_tubes_pass_through_their_keys_and_face_outwards():
    rng = np.random.default_rng(5)
    keys = np.cumsum(rng.normal((0.3, 0, 0.2), 0.1, (12, 3)), axis=0)
    shape = tubes(keys, np.full(12, 0.01), np.array([0, 4, 5, 12]), 4)  # the one of a single key is nothing
    assert set(shape.part) == {0, 2}
    for number in set(range(12)) - {4}:
        ring = shape.positions[(shape.key == number) & (shape.fraction == 0)]
        if len(ring):
            assert np.allclose(ring.mean(axis=0), keys[number], atol=1e-6)
    a, b, c = (shape.positions[shape.triangles[:, corner]] for corner in range(3))
    out = (np.cross(b - a, c - a) * shape.normals[shape.triangles].mean(axis=1)).sum(axis=1)
    assert (out > 0).mean() > 0.98  # but where the strand bends more than it is thick


@pytest.mark.parametrize("count", [10, 20001])
def test_balls_cover_what_round_ones_do(count):
    """A convex body covers a quarter of its surface, on average."""
    shape = balls(np.zeros((count, 3)), np.full(count, 2.0))
    assert areas(shape).sum() == pytest.approx(count * 4 * np.pi * 4)
    assert np.allclose(
        shape.positions / np.linalg.norm(shape.positions, axis=1)[:, None], shape.normals, atol=1e-6
    )


@pytest.fixture
def hair(bpy, link):
    """Returns an object of two straight strands, of 3 and 2 keys, 2 m and 1 m long."""
    data = bpy.data.hair_curves.new("Hair")
    data.add_curves([3, 2])
    keys = [(0, 0, 0), (0, 0, 1), (0, 0, 2), (1, 0, 0), (1, 0, 1)]
    data.attributes["position"].data.foreach_set("vector", np.ravel(keys).astype(np.float32))
    data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [0.1, 0.1, 0.1, 0.2, 0.2])
    data.attributes.new("tint", "FLOAT_COLOR", "CURVE").data.foreach_set("color", [1, 0, 0, 1, 0, 1, 0, 1])
    return link("Hair", data)


def shaded_by(bpy, item, node, output, **properties):
    material = bpy.data.materials.new("Hair")
    material.use_nodes = True
    tree = material.node_tree
    new = tree.nodes.new(f"ShaderNode{node}")
    for name, value in properties.items():
        setattr(new, name, value)
    tree.links.new(new.outputs[output], tree.nodes["Principled BSDF"].inputs["Base Color"])
    item.data.materials.append(material)


def test_hair_curves_are_tubes(hair, export):
    scene = export()
    (mesh,) = scene.meshes
    assert scene.warnings == ()
    assert mesh.positions[:, 2].max() == pytest.approx(2)
    assert mesh.corner_normals.shape == (len(mesh.triangles), 3, 3)


@pytest.mark.parametrize(
    ("output", "first", "second"),
    [
        ("Intercept", (0, 1), (0, 1)),
        ("Length", (2, 2), (1, 1)),
        ("Thickness", (0.2, 0.2), (0.4, 0.4)),
        ("Is Strand", (1, 1), (1, 1)),
    ],
)
def test_curves_info(bpy, hair, export, output, first, second):
    shaded_by(bpy, hair, "HairInfo", output)
    scene = export()
    (mesh,) = scene.meshes
    values = mesh.attributes[0][..., 0].ravel()
    strand = mesh.positions[mesh.triangles].reshape(-1, 3)[:, 0] > 0.5
    for chosen, expected in ((~strand, first), (strand, second)):
        assert (values[chosen].min(), values[chosen].max()) == pytest.approx(expected, abs=1e-5)
    assert scene.warnings == ()


def test_attributes_of_curves(bpy, hair, export):
    shaded_by(bpy, hair, "Attribute", "Color", attribute_name="tint")
    (mesh,) = export().meshes
    strand = mesh.positions[mesh.triangles].reshape(-1, 3)[:, 0] > 0.5
    values = mesh.attributes[0].reshape(-1, 4)
    assert np.allclose(values[strand], (0, 1, 0, 1))
    assert np.allclose(values[~strand], (1, 0, 0, 1))


def test_unchanged_curves_are_the_same_arrays(bpy, hair, camera):
    from nephele.export import ExportCache, export_scene

    cache = ExportCache()
    first, second = (export_scene(bpy.context.evaluated_depsgraph_get(), cache=cache) for _ in range(2))
    assert first.meshes[0].positions is second.meshes[0].positions
    assert first.meshes[0].corner_normals is second.meshes[0].corner_normals


def test_particle_hair(bpy, link, export):
    mesh = bpy.data.meshes.new("Skin")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="UVMap")
    item = link("Skin", mesh)
    item.modifiers.new("Fur", "PARTICLE_SYSTEM")
    settings = item.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length = "HAIR", 20, 0.5
    scene = export()
    assert [i.name for i in scene.instances] == ["Skin", "Skin"]
    fur = scene.meshes[scene.instances[1].mesh]
    assert fur.positions[:, 2].max() == pytest.approx(0.5, abs=0.02)
    assert scene.warnings == ()
    bpy.context.view_layer.use_strand = False
    assert len(export().instances) == 1
