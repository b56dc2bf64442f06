# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes and instances: what is shared, what is read, and how fast."""

import time

import numpy as np
import pytest
from programs import with_nodes

QUAD = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


@pytest.fixture
def quad(bpy, link):
    """Returns the object of a unit-normal square of two triangles."""
    mesh = bpy.data.meshes.new("Quad")
    mesh.from_pydata(QUAD, [], [(0, 1, 2, 3)])
    return link("Quad", mesh)


def material_with(bpy, *steps):
    """Returns a new material whose Base Color is fed by a node of type steps[0], set up by the dict
    steps[1]."""
    material = with_nodes(bpy.data.materials.new("Material"))
    tree = material.node_tree
    node = tree.nodes.new(steps[0])
    for name, value in steps[1].items():
        setattr(node, name, value)
    tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return material


def test_square(quad, export):
    scene = export()
    (mesh,), (instance,) = scene.meshes, scene.instances
    assert mesh.positions.dtype == np.float32
    assert mesh.positions.tolist() == [list(map(float, p)) for p in QUAD]
    assert sorted(set(mesh.triangles.ravel())) == [0, 1, 2, 3]
    a, b, c = mesh.positions[mesh.triangles].transpose(1, 0, 2)
    assert (np.cross(b - a, c - a)[:, 2] == 4).all()  # both face up, together the whole square
    assert mesh.corner_normals is None
    assert (mesh.uvs, mesh.attributes, mesh.material_index) == ((), (), None)
    assert (instance.mesh, instance.materials, instance.visibility) == (0, (-1,), 0b111111)


def test_dielectric_priority_is_the_objects(quad, link, export):
    other = link("Other", quad.data)
    other.nephele.dielectric_priority = 3
    assert {i.name: i.dielectric_priority for i in export().instances} == {"Quad": 0, "Other": 3}


def test_linked_duplicates_share_a_mesh(quad, link, export):
    other = link("Other", quad.data)
    other.location.x = 3
    scene = export()
    assert (len(scene.meshes), [i.mesh for i in scene.instances]) == (1, [0, 0])
    assert {i.world_from_object[0, 3] for i in scene.instances} == {0.0, 3.0}
    other.modifiers.new("Subdivide", "SUBSURF").levels = 1
    scene = export()
    assert len(scene.meshes) == 2
    assert sorted(len(mesh.triangles) for mesh in scene.meshes) == [2, 8]


def test_collection_instances_share_a_mesh(bpy, quad, link, export):
    collection = bpy.data.collections.new("Group")
    bpy.context.scene.collection.objects.unlink(quad)
    collection.objects.link(quad)
    for x in range(3):
        empty = link(f"Empty {x}", None)
        empty.instance_type, empty.instance_collection, empty.location.x = "COLLECTION", collection, x
    scene = export()
    assert (len(scene.meshes), len(scene.instances)) == (1, 3)
    assert [i.world_from_object[0, 3] for i in scene.instances] == [0, 1, 2]
    assert len({i.random for i in scene.instances}) == 3


def test_geometry_nodes_instances(bpy, quad, export):
    tree = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    grid, cube, scatter = (
        tree.nodes.new(f"GeometryNode{kind}") for kind in ("MeshGrid", "MeshCube", "InstanceOnPoints")
    )
    grid.inputs["Vertices X"].default_value = grid.inputs["Vertices Y"].default_value = 4
    tree.links.new(grid.outputs["Mesh"], scatter.inputs["Points"])
    tree.links.new(cube.outputs["Mesh"], scatter.inputs["Instance"])
    tree.links.new(scatter.outputs["Instances"], tree.nodes.new("NodeGroupOutput").inputs[0])
    quad.modifiers.new("Scatter", "NODES").node_group = tree
    scene = export()
    assert (len(scene.meshes), len(scene.instances)) == (1, 16)
    assert len(scene.meshes[0].triangles) == 12


@pytest.mark.parametrize("kind", ["CURVE", "FONT", "META"])
def test_other_geometry_becomes_a_mesh(bpy, link, export, kind):
    if kind == "CURVE":
        data = bpy.data.curves.new("Curve", "CURVE")
        data.splines.new("POLY").points.add(1)
        data.splines[0].points[1].co = (1, 0, 0, 1)
        data.bevel_depth = 0.1
    elif kind == "FONT":
        data = bpy.data.curves.new("Text", "FONT")
        data.body = "o"
    else:
        data = bpy.data.metaballs.new("Ball")
        data.elements.new()
    link("Thing", data)
    link("Twin", data).location.x = 9
    scene = export()
    assert len(scene.meshes[0].triangles) > 10
    assert len(scene.instances) == 2
    assert scene.warnings == ()


def test_metaballs_of_one_family_are_one_surface(bpy, link, export):
    data = bpy.data.metaballs.new("Ball")
    data.elements.new()
    link("Ball", data)
    link("Ball.001", data).location.x = 1
    assert len(export().instances) == 1


def test_wire_without_faces_is_left_out(bpy, link, export):
    data = bpy.data.curves.new("Wire", "CURVE")
    data.splines.new("POLY").points.add(1)
    link("Wire", data)
    assert export().instances == ()


def test_smooth_flat_and_custom_normals(bpy, quad, export):
    mesh = bpy.data.meshes.new("Roof")
    mesh.from_pydata(
        [(0, -1, 0), (0, 1, 0), (-1, -1, -1), (-1, 1, -1), (1, -1, -1), (1, 1, -1)],
        [],
        [(0, 1, 3, 2), (1, 0, 4, 5)],
    )
    quad.data = mesh
    assert export().meshes[0].corner_normals is None
    mesh.shade_smooth()
    smooth = export().meshes[0]
    ridge = np.isin(smooth.triangles, (0, 1))
    assert np.allclose(smooth.corner_normals[ridge], (0, 0, 1), atol=1e-5)
    mesh.normals_split_custom_set([(1, 0, 0)] * len(mesh.loops))
    assert np.allclose(export().meshes[0].corner_normals, (1, 0, 0), atol=2e-2)


def test_material_slots(bpy, export, link):
    mesh = bpy.data.meshes.new("Two")
    mesh.from_pydata([*QUAD, (3, -1, 0), (3, 1, 0)], [], [(0, 1, 2, 3), (1, 4, 5, 2)])
    red, blue = with_nodes(bpy.data.materials.new("Red")), with_nodes(bpy.data.materials.new("Blue"))
    mesh.materials.append(red)
    mesh.materials.append(None)
    mesh.materials.append(blue)
    mesh.polygons[1].material_index = 2
    item = link("Two", mesh)
    scene = export()
    names = [scene.materials[k].name for k in scene.instances[0].materials]
    assert names == ["Red", "Red", "Blue"]  # nothing shows what is in the middle
    assert scene.meshes[0].material_index.tolist() == [0, 0, 2, 2]
    item.material_slots[0].link = "OBJECT"
    item.material_slots[0].material = blue
    scene = export()
    assert [scene.materials[k].name for k in scene.instances[0].materials[::2]] == ["Blue", "Blue"]


def test_only_the_uv_maps_in_use_are_read(bpy, quad, export):
    first, second = quad.data.uv_layers.new(name="First"), quad.data.uv_layers.new(name="Second")
    first.uv.foreach_set("vector", np.arange(8, dtype=np.float32))
    second.uv.foreach_set("vector", np.arange(8, dtype=np.float32) + 100)
    assert export().meshes[0].uvs == ()
    quad.data.materials.append(material_with(bpy, "ShaderNodeUVMap", {"uv_map": "Second"}))
    scene = export()
    program = scene.materials[scene.instances[0].materials[0]].surface
    mode = int(program.code[0, 7])
    assert scene.meshes[0].uvs[mode].min() == 100
    assert scene.meshes[0].uvs[mode].shape == (2, 3, 2)


def test_active_uv_map_is_number_0(bpy, quad, export):
    quad.data.uv_layers.new(name="First")
    quad.data.uv_layers.new(name="Second")
    quad.data.uv_layers["Second"].uv.foreach_set("vector", np.full(8, 7, np.float32))
    quad.data.uv_layers["Second"].active_render = True
    material = with_nodes(bpy.data.materials.new("Material"))
    tree = material.node_tree
    tree.links.new(
        tree.nodes.new("ShaderNodeTexCoord").outputs["UV"], tree.nodes["Principled BSDF"].inputs["Base Color"]
    )
    quad.data.materials.append(material)
    assert (export().meshes[0].uvs[0] == 7).all()


@pytest.mark.parametrize(
    ("kind", "domain", "values", "expected"),
    [
        ("FLOAT_COLOR", "POINT", [0.1, 0.2, 0.3, 0.4] * 4, [0.1, 0.2, 0.3, 0.4]),
        ("FLOAT_COLOR", "CORNER", [0.1, 0.2, 0.3, 0.4] * 4, [0.1, 0.2, 0.3, 0.4]),
        ("FLOAT", "FACE", [2.5], [2.5, 2.5, 2.5, 1.0]),
        ("INT", "POINT", [3] * 4, [3, 3, 3, 1]),
        ("BOOLEAN", "FACE", [True], [1, 1, 1, 1]),
        ("FLOAT2", "CORNER", [1, 2] * 4, [1, 2, 0, 1]),
        ("FLOAT_VECTOR", "POINT", [1, 2, 3] * 4, [1, 2, 3, 1]),
    ],
)
def test_attributes(bpy, quad, export, kind, domain, values, expected):
    attribute = quad.data.attributes.new("Wear", kind, domain)
    name = "color" if "COLOR" in kind else "vector" if kind in ("FLOAT2", "FLOAT_VECTOR") else "value"
    attribute.data.foreach_set(name, values)
    quad.data.materials.append(material_with(bpy, "ShaderNodeAttribute", {"attribute_name": "Wear"}))
    (array,) = export().meshes[0].attributes
    assert array.shape == (2, 3, 4)
    assert np.allclose(array, expected)


def test_visibility_and_hiding(bpy, quad, link, export):
    quad.visible_camera, quad.visible_shadow = False, False
    assert export().instances[0].visibility == 0b011110
    quad.hide_render = True
    assert export().instances == ()


def test_indirect_only_collection_is_unseen_by_the_camera(bpy, quad, export):
    collection = bpy.data.collections.new("Group")
    bpy.context.scene.collection.children.link(collection)
    bpy.context.scene.collection.objects.unlink(quad)
    collection.objects.link(quad)
    layer = bpy.context.view_layer.layer_collection.children["Group"]
    layer.indirect_only = True
    assert export().instances[0].visibility == 0b111110


def test_empty_hair_curves_are_left_out(bpy, link, export):
    link("Fur", bpy.data.hair_curves.new("Fur"))
    scene = export()
    assert (scene.instances, scene.warnings) == ((), ())


def test_empty_mesh_is_left_out(bpy, link, export):
    link("Nothing", bpy.data.meshes.new("Nothing"))
    assert (export().meshes, export().instances) == ((), ())


def test_object_properties(bpy, quad, export):
    quad.color, quad.pass_index = (0.1, 0.2, 0.3, 0.4), 7
    instance = export().instances[0]
    assert (instance.color, instance.pass_index) == (pytest.approx((0.1, 0.2, 0.3, 0.4)), 7)
    assert 0 <= instance.random <= 1


def test_generated_box_is_the_bounding_box(quad, export):
    mesh = export().meshes[0]
    assert mesh.generated_min[:2] == (-1, -1)
    assert mesh.generated_size[:2] == (2, 2)


def test_a_million_triangles_in_a_second(bpy, link, export):
    """Wall time, best of three; about 0.15 s on a free core."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=708, y_subdivisions=708)
    mesh = bpy.context.object.data
    mesh.shade_smooth()
    mesh.uv_layers.new(name="Second")
    mesh.materials.append(material_with(bpy, "ShaderNodeUVMap", {"uv_map": "Second"}))
    depsgraph = bpy.context.evaluated_depsgraph_get()
    from nephele.export import export_scene

    seconds = []
    for _ in range(3):
        start = time.perf_counter()
        scene = export_scene(depsgraph)
        seconds.append(time.perf_counter() - start)
    assert len(scene.meshes[0].triangles) > 1_000_000
    assert scene.meshes[0].corner_normals is not None
    assert min(seconds) < 1.0
