# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking, holdouts, view layers and node trees of lamps: what the exporter makes of them."""

import numpy as np
import pytest
from nephele import description as d

SETS = {"receiver": "receivers", "blocker": "blockers"}


@pytest.fixture
def boxes(bpy, link):
    """Returns three objects A, B and C with a triangle each."""
    made = []
    for name in "ABC":
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
        made.append(link(name, mesh))
    return made


@pytest.fixture
def lamp(bpy, link):
    return link("Lamp", bpy.data.lights.new("Lamp", "AREA"))


def collection(bpy, included=(), excluded=(), children=()):
    result = bpy.data.collections.new("Linked")
    for item in (*included, *excluded):
        result.objects.link(item)
    for item, entry in zip(result.objects, result.collection_objects, strict=True):
        entry.light_linking.link_state = "EXCLUDE" if item in excluded else "INCLUDE"
    for child, state in children:
        result.children.link(child)
        result.collection_children[-1].light_linking.link_state = state
    return result


def reached(scene, kind):
    """Returns the names of the objects that the scene's light shines on, or that block it."""
    mask = getattr(scene.lights[0], SETS[kind])
    return {i.name for i in scene.instances if mask >> getattr(i, f"{kind}_set") & 1}


def test_without_linking_all_is_in_set_0(boxes, lamp, export):
    scene = export()
    assert {(i.receiver_set, i.blocker_set, i.receivers, i.blockers) for i in scene.instances} == {
        (0, 0, d.ALL_SETS, d.ALL_SETS)
    }
    assert (scene.lights[0].receivers, scene.lights[0].blockers) == (d.ALL_SETS, d.ALL_SETS)


@pytest.mark.parametrize("kind", SETS)
def test_included_objects_alone_or_all_but_the_excluded(bpy, boxes, lamp, export, kind):
    a, b, c = boxes
    cases = [
        (collection(bpy, included=[a]), {"A"}),
        (collection(bpy, excluded=[a]), {"B", "C"}),
        (collection(bpy, included=[a, b], excluded=[c]), {"A", "B"}),
        (collection(bpy, children=[(collection(bpy, included=[b, c]), "INCLUDE")]), {"B", "C"}),
        (collection(bpy, included=[b], children=[(collection(bpy, included=[b]), "EXCLUDE")]), {"A", "C"}),
        (collection(bpy), {"A", "B", "C"}),
    ]
    for group, expected in cases:
        setattr(lamp.light_linking, f"{kind}_collection", group)
        assert reached(export(), kind) == expected
    assert export().warnings == ()


def test_sets_are_shared_and_lamps_told_apart(bpy, boxes, lamp, link, export):
    a, b, _ = boxes
    other = link("Other", bpy.data.lights.new("Other", "POINT"))
    lamp.light_linking.receiver_collection = collection(bpy, included=[a, b])
    other.light_linking.receiver_collection = collection(bpy, excluded=[b])
    scene = export()
    assert len({i.receiver_set for i in scene.instances}) == 3
    masks = {light.name: light.receivers for light in scene.lights}
    sets = {i.name: i.receiver_set for i in scene.instances}
    assert [masks["Lamp"] >> sets[name] & 1 for name in "ABC"] == [1, 1, 0]
    assert [masks["Other"] >> sets[name] & 1 for name in "ABC"] == [1, 0, 1]


def test_objects_may_be_linked_lights_too(bpy, boxes, export):
    a, b, _ = boxes
    a.light_linking.receiver_collection = collection(bpy, included=[b])
    by_name = {i.name: i for i in export().instances}
    assert by_name["A"].receivers == 1 << by_name["B"].receiver_set
    assert by_name["B"].receivers == d.ALL_SETS


def test_more_kinds_of_objects_than_sets_warn(bpy, boxes, link, export):
    for number in range(7):
        lamp = link(f"Lamp {number}", bpy.data.lights.new("Lamp", "POINT"))
        members = []
        for bits in range(128):
            if bits >> number & 1:
                name = f"Object {bits}"
                members.append(bpy.data.objects.get(name) or link(name, boxes[0].data))
        lamp.light_linking.receiver_collection = collection(bpy, included=members)
    assert any("receiver collections" in text and "Share collections" in text for text in export().warnings)


def test_holdouts(bpy, boxes, export):
    boxes[0].is_holdout = True
    group = bpy.data.collections.new("Holes")
    bpy.context.scene.collection.children.link(group)
    bpy.context.scene.collection.objects.unlink(boxes[1])
    group.objects.link(boxes[1])
    bpy.context.view_layer.layer_collection.children["Holes"].holdout = True
    scene = export()
    assert {i.name for i in scene.instances if i.holdout} == {"A", "B"}
    assert scene.warnings == ()


def test_shadow_catchers_warn(boxes, export):
    boxes[2].is_shadow_catcher = True
    assert any(
        "object 'C': shadow catchers" in text and "with and without" in text for text in export().warnings
    )


def test_material_override(bpy, boxes, export):
    boxes[0].data.materials.append(bpy.data.materials.new("Own"))
    bpy.context.view_layer.material_override = bpy.data.materials.new("Clay")
    scene = export()
    assert [material.name for material in scene.materials] == ["Clay"]
    assert {i.materials for i in scene.instances} == {(0,)}
    assert scene.warnings == ()


def test_what_the_view_layer_includes(bpy, boxes, lamp, export):
    layer = bpy.context.view_layer
    layer.use_solid = False
    scene = export()
    assert (len(scene.instances), len(scene.lights)) == (0, 1)
    layer.use_solid = True
    layer.use_sky = False
    bpy.context.scene.world = bpy.data.worlds.new("World")
    assert export().world.background is None
    other = bpy.data.worlds.new("Other")
    other.use_nodes = True
    layer.use_sky, layer.world_override = True, other
    assert export().world.background is not None


def test_world_visibility(bpy, export):
    world = bpy.context.scene.world = bpy.data.worlds.new("World")
    assert export().world.visibility == d.ALL_RAYS
    world.cycles_visibility.glossy = world.cycles_visibility.scatter = False
    assert export().world.visibility == 0b101011


def test_light_groups_warn(bpy, export):
    bpy.context.view_layer.lightgroups.add(name="Key")
    assert any("light groups are not supported" in text for text in export().warnings)


def test_portals_are_left_out_with_a_warning(bpy, lamp, export):
    lamp.data.cycles.is_portal = True
    scene = export()
    assert scene.lights == ()
    assert any("light 'Lamp': it is a portal" in text for text in scene.warnings)


def test_bounces_of_a_light(lamp, export):
    assert lamp.data.cycles.max_bounces == 1024
    lamp.data.cycles.max_bounces = 3
    assert export().lights[0].max_bounces == 3


def test_an_image_on_a_light(bpy, lamp, export):
    lamp.data.use_nodes = True
    tree = lamp.data.node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("Slide", 4, 4)
    tree.links.new(texture.outputs["Color"], tree.nodes["Emission"].inputs["Color"])
    scene = export()
    assert [image.name for image in scene.images] == ["Slide"]
    assert [closure.kind for closure in scene.lights[0].program.closures] == ["emission"]
    assert scene.warnings == ()


def test_shaders_that_are_no_emission_are_left_out_of_lights(lamp, export):
    lamp.data.use_nodes = True
    tree = lamp.data.node_tree
    diffuse, mix = tree.nodes.new("ShaderNodeBsdfDiffuse"), tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(diffuse.outputs[0], mix.inputs[0])
    tree.links.new(tree.nodes["Emission"].outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], tree.nodes["Light Output"].inputs[0])
    scene = export()
    assert any("light 'Lamp': only Emission counts" in text for text in scene.warnings)
    assert np.allclose(scene.lights[0].power, lamp.data.energy)


def test_a_worlds_limit_of_bounces_is_not_read(bpy, export):
    world = bpy.context.scene.world = bpy.data.worlds.new("Sky")
    world.cycles.max_bounces = 3
    assert any(text.startswith("world 'Sky': its limit of bounces") for text in export().warnings)


def test_velocities_of_meshes_are_not_read(bpy, boxes, export):
    boxes[1].data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    assert export().warnings == ()
    bpy.context.scene.render.use_motion_blur = True
    (warning,) = export().warnings
    assert warning.startswith("object 'B': the velocities of its vertices")
