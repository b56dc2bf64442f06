# SPDX-License-Identifier: GPL-3.0-or-later
"""Exports that follow one another: after each kind of edit the description is that of a fresh export, array
by array and bit by bit, its pictures too, and what did not change is the same object as before."""

import numpy as np
import pytest
from keyframes import animate
from nephele import description_file
from nephele.bridge import create_renderer
from nephele.export import ExportCache, export_scene
from nephele.session import Session
from programs import with_nodes

SIZE, SAMPLES = 12, 2


@pytest.fixture
def states(bpy, camera):
    """Returns a function that exports the current scene with a session, and freshly, as final renders do
    whose depsgraph Blender keeps, and checks that both are the same. It returns the description."""

    class Follower(bpy.types.RenderEngine):
        bl_idname = "FOLLOWER"
        bl_label = "Follower"
        outcome = {}  # noqa: RUF012 - of the class, for the test

        def render(self, depsgraph):
            try:
                known = self.outcome.get("session")
                session = Session() if known is None else known
                self.outcome["session"] = session
                self.outcome["scene"] = session.export(depsgraph, engine=self)
                self.outcome["fresh"] = export_scene(depsgraph, engine=self)
            except BaseException as error:  # noqa: BLE001 - raised again by the test
                self.outcome["fault"] = error

    bpy.utils.register_class(Follower)
    scene = bpy.context.scene
    render = scene.render
    render.resolution_x = render.resolution_y = SIZE
    render.use_persistent_data, render.use_compositing = True, False
    scene.nephele.samples = SAMPLES

    def state(pictures=True):
        scene = bpy.context.scene
        if scene.render.engine != "FOLLOWER":  # setting it makes Blender let go of the depsgraph
            scene.render.engine = "FOLLOWER"
        for key in ("scene", "fresh", "fault"):
            Follower.outcome.pop(key, None)
        bpy.ops.render.render(scene=scene.name)
        if "fault" in Follower.outcome:
            raise Follower.outcome["fault"]
        found, fresh = Follower.outcome["scene"], Follower.outcome["fresh"]
        assert content(found) == content(fresh)
        if pictures:
            built = picture(Follower.outcome["session"].build(found))
            np.testing.assert_array_equal(built, picture(create_renderer(fresh)))
        return found

    yield state
    bpy.context.scene.render.engine = "NEPHELE"
    bpy.context.scene.render.use_persistent_data = False
    bpy.utils.unregister_class(Follower)


def content(scene):
    """Returns all that a description holds, its arrays as bytes; temporary files by their content's size."""
    numbered = {}
    tree = description_file.encoded(scene, numbered)
    arrays = dict(numbered.values())

    def plain(value):
        if isinstance(value, dict) and "array" in value:
            array = arrays[value["array"]]
            return (str(array.dtype), array.shape, array.tobytes())
        if isinstance(value, dict):
            return {k: "temporary" if k == "path" and "nephele_" in v else plain(v) for k, v in value.items()}
        return [plain(v) for v in value] if isinstance(value, list) else value

    return plain(tree)


def picture(renderer):
    """Returns the finished Combined."""
    renderer.start()
    while not renderer.wait(1.0):
        pass
    return renderer.read_pass("Combined")


def by_name(items):
    return {item.name: item for item in items}


def grid_mesh(bpy, name, size=4):
    """Returns a mesh of size x size quads in the unit square, with a UV map and a colour attribute."""
    mesh = bpy.data.meshes.new(name)
    points = [(x / size, y / size, 0) for y in range(size + 1) for x in range(size + 1)]
    corner = [y * (size + 1) + x for y in range(size) for x in range(size)]
    mesh.from_pydata(points, [], [(i, i + 1, i + size + 2, i + size + 1) for i in corner])
    mesh.uv_layers.new(name="map")
    mesh.color_attributes.new("tint", "FLOAT_COLOR", "POINT")
    return mesh


def write_grey(bpy, path, value):
    """Writes a PNG file of one grey."""
    image = bpy.data.images.new("Other", 4, 4)
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.pixels[:] = [value] * 64
    image.save()
    bpy.data.images.remove(image)


def material_of(bpy, name, kind, output, **properties):
    """Returns (material, node): its colour is what a new node gives."""
    material = with_nodes(bpy.data.materials.new(name))
    node = material.node_tree.nodes.new(kind)
    for key, value in properties.items():
        setattr(node, key, value)
    color = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    material.node_tree.links.new(node.outputs[output], color)
    return material, node


def add_numbered_images(bpy, items, folder):
    """Gives one object an image sequence and another a tiled image."""
    for number in range(1, 7):
        write_grey(bpy, folder / f"shot_{number:04}.png", number / 10)
    for number in (1001, 1002):
        write_grey(bpy, folder / f"skin.{number}.png", number % 10 / 4)
    shot = bpy.data.images.load(str(folder / "shot_0001.png"))
    shot.source = "SEQUENCE"
    skin = bpy.data.images.load(str(folder / "skin.1001.png"))
    skin.source, skin.filepath = "TILED", str(folder / "skin.<UDIM>.png")
    for tile in [tile for tile in skin.tiles if tile.number != 1001]:
        skin.tiles.remove(tile)
    skin.tiles.new(1002)
    material, items["shot"] = material_of(bpy, "Shot", "ShaderNodeTexImage", "Color", image=shot)
    items["shot"].image_user.frame_duration = 3
    items["keyed"].data.materials.append(material)
    material, items["skin"] = material_of(bpy, "Skin", "ShaderNodeTexImage", "Color", image=skin)
    items["arrayed"].data.materials.append(material)


def add_properties(bpy, items):
    """Has materials read properties of objects and of the view layer."""
    items["a"]["heat"] = items["text"]["heat"] = 0.5
    bpy.context.view_layer["mood"] = 0.25
    for item, kind, name in (("text", "OBJECT", "heat"), ("facing", "VIEW_LAYER", "mood")):
        material, _ = material_of(
            bpy, name, "ShaderNodeAttribute", "Color", attribute_type=kind, attribute_name=name
        )
        items[item].data.materials.append(material)


def grouped_material(bpy, empty):
    """Returns a material whose colour comes from within two groups, from coordinates of an object."""
    inner, outer = (bpy.data.node_groups.new(name, "ShaderNodeTree") for name in ("Inner", "Outer"))
    for group in (inner, outer):
        group.interface.new_socket("Value", in_out="OUTPUT", socket_type="NodeSocketVector")
    where, add = inner.nodes.new("ShaderNodeTexCoord"), inner.nodes.new("ShaderNodeVectorMath")
    where.object = empty
    inner.links.new(where.outputs["Object"], add.inputs[0])
    inner.links.new(add.outputs[0], inner.nodes.new("NodeGroupOutput").inputs[0])
    use = outer.nodes.new("ShaderNodeGroup")
    use.node_tree = inner
    outer.links.new(use.outputs[0], outer.nodes.new("NodeGroupOutput").inputs[0])
    material = with_nodes(bpy.data.materials.new("Grouped"))
    use = material.node_tree.nodes.new("ShaderNodeGroup")
    use.node_tree = outer
    material.node_tree.links.new(
        use.outputs[0], material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]
    )
    return material


@pytest.fixture
def stage(bpy, camera, link, tmp_path, openvdb):
    """Returns a scene with one of each kind of thing that may change, and the VDB sequence that it shows."""
    world = bpy.data.worlds.new("World")
    bpy.context.scene.world = with_nodes(world)
    camera.location.z = 3
    plain, shared = grid_mesh(bpy, "Plain"), grid_mesh(bpy, "Shared")
    items = {"plain": link("Plain", plain), "a": link("A", shared), "b": link("B", shared)}
    items["b"].location.x = 0.5
    items["bent"] = link("Bent", grid_mesh(bpy, "Bent"))
    items["bent"].modifiers.new("Subdivision", "SUBSURF").levels = 1
    items["keyed"] = link("Keyed", grid_mesh(bpy, "Keyed"))
    items["keyed"].shape_key_add(name="Basis")
    items["keyed"].shape_key_add(name="Up").data[0].co.z = 1
    items["arrayed"] = link("Arrayed", grid_mesh(bpy, "Arrayed"))
    items["arrayed"].modifiers.new("Array", "ARRAY").use_object_offset = True
    items["empty"] = link("Empty", None)
    items["arrayed"].modifiers["Array"].offset_object = items["empty"]
    items["text"] = link("Text", bpy.data.curves.new("Text", "FONT"))
    items["text"].data.body = "a"
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy = 50
    items["lamp"] = link("Lamp", lamp)
    items["lamp"].location.z = 2
    write_grey(bpy, tmp_path / "painted.png", 0.5)
    material = with_nodes(bpy.data.materials.new("Textured"))
    nodes, shader = material.node_tree.nodes, material.node_tree.nodes["Principled BSDF"]
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.load(str(tmp_path / "painted.png"))
    material.node_tree.links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    tint = nodes.new("ShaderNodeAttribute")
    tint.attribute_name = "tint"
    material.node_tree.links.new(tint.outputs["Fac"], shader.inputs["Roughness"])
    for mesh in (plain, shared):
        mesh.materials.append(material)
    items["bent"].data.materials.append(grouped_material(bpy, items["empty"]))
    for frame in range(1, 4):
        grid = openvdb.FloatGrid()
        grid.name = "density"
        grid.copyFromArray(np.full((4, 4, 4), float(frame), np.float32))
        grid.transform = openvdb.createLinearTransform(0.1)
        openvdb.write(str(tmp_path / f"smoke_{frame:04}.vdb"), grids=[grid])
    data = bpy.data.volumes.new("Smoke")
    data.filepath = str(tmp_path / "smoke_0001.vdb")
    data.is_sequence, data.frame_duration = True, 3
    items["smoke"] = link("Smoke", data)
    items["smoke"].location.z = 0.3
    items["material"], items["texture"] = material, texture
    items["facing"] = link("Facing", grid_mesh(bpy, "Facing", 1))
    add_numbered_images(bpy, items, tmp_path)
    add_properties(bpy, items)
    return items


def same_shapes(before, after):
    """Returns the names of meshes whose arrays are the same objects in two descriptions."""
    old = by_name(before.meshes)
    return {
        m.name
        for m in after.meshes
        if m.name in old and m.positions is old[m.name].positions and m.triangles is old[m.name].triangles
    }


SUBDIVIDED = "Mesh"  # as Blender names what the modifier makes
ALL = {"Plain", "Shared", SUBDIVIDED, "Keyed", "Arrayed", "Text", "Facing"}


def same_pictures(before, after):
    """Returns whether images that hold the same are the same arrays."""
    old = {(i.name, i.srgb, i.pixels.tobytes()): i.pixels for i in before.images}
    return all(old.get((i.name, i.srgb, i.pixels.tobytes()), i.pixels) is i.pixels for i in after.images)


def vertices_moved(bpy, s):
    s["plain"].data.vertices[0].co.z = 0.4
    s["plain"].data.update()


def vertices_of_shared_mesh(bpy, s):
    s["a"].data.vertices[0].co.z = 0.4
    s["a"].data.update()


def shape_key(bpy, s):
    s["keyed"].data.shape_keys.key_blocks["Up"].value = 0.5


def modifier_target(bpy, s):
    s["empty"].location.x = 1.5


def modifier_value(bpy, s):
    """One of those for renders only, of which Blender takes no notice."""
    s["bent"].modifiers[0].render_levels = 1


def modifier_toggled(bpy, s):
    s["bent"].modifiers[0].show_render = False


def modifier_toggled_back(bpy, s):
    s["bent"].modifiers[0].show_render = True


def simplify(bpy, s):
    """No subdivision any more: Blender shows the object's own mesh."""
    bpy.context.scene.render.use_simplify = True
    bpy.context.scene.render.simplify_subdivision_render = 0


def text_body(bpy, s):
    s["text"].data.body = "b"


def uv_changed(bpy, s):
    s["plain"].data.uv_layers["map"].uv[0].vector = (0.25, 0.75)
    s["plain"].data.update()


def attribute_changed(bpy, s):
    s["plain"].data.attributes["tint"].data[3].color = (1, 0, 0, 1)
    s["plain"].data.update()


def attribute_asked_for(bpy, s):
    s["plain"].data.attributes.new("other", "FLOAT", "FACE").data[2].value = 0.5
    s["material"].node_tree.nodes["Attribute"].attribute_name = "other"


def material_value(bpy, s):
    s["material"].node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1


def group_value(bpy, s):
    bpy.data.node_groups["Inner"].nodes["Vector Math"].inputs[1].default_value[0] = 0.5


def coordinates_moved(bpy, s):
    s["arrayed"].modifiers["Array"].offset_object = None
    s["empty"].location.y = 0.5


def material_renamed(bpy, s):
    bpy.data.materials["Grouped"].name = "Renamed"


def material_animated(bpy, s):
    value = bpy.data.materials["Renamed"].node_tree.nodes["Principled BSDF"].inputs["Roughness"]
    value.driver_add("default_value").driver.expression = "frame / 10"


def material_reassigned(bpy, s):
    s["a"].material_slots[0].link = "OBJECT"
    s["a"].material_slots[0].material = with_nodes(bpy.data.materials.new("Other"))


def faces_reassigned(bpy, s):
    s["plain"].data.materials.append(with_nodes(bpy.data.materials.new("Other")))
    s["plain"].data.polygons[0].material_index = 1
    s["plain"].data.update()


def pixels_set(bpy, s):
    s["texture"].image.pixels[0] = 1.0


def image_reloaded(bpy, s):
    """A file that another program wrote anew."""
    write_grey(bpy, s["texture"].image.filepath, 0.9)
    s["texture"].image.reload()


def color_space(bpy, s):
    s["texture"].image.colorspace_settings.name = "Non-Color"


def sequence_shifted(bpy, s):
    s["shot"].image_user.frame_offset = 1


def sequence_rewritten(bpy, s):
    """A file of a sequence that another program wrote anew, of which Blender is told nothing."""
    write_grey(bpy, bpy.path.abspath(s["shot"].image.filepath).replace("_0001", "_0002"), 0.9)


def tile_reloaded(bpy, s):
    write_grey(bpy, s["skin"].image.filepath.replace("<UDIM>", "1002"), 0.9)
    s["skin"].image.reload()


def tile_added(bpy, s):
    write_grey(bpy, s["skin"].image.filepath.replace("<UDIM>", "1011"), 0.75)
    s["skin"].image.tiles.new(1011)


def sky_added(bpy, s):
    tree = bpy.context.scene.world.node_tree
    s["sky"] = tree.nodes.new("ShaderNodeTexSky")
    s["sky"].sun_disc = False
    tree.links.new(s["sky"].outputs[0], tree.nodes["Background"].inputs["Color"])


def sky_parameter(bpy, s):
    s["sky"].sun_elevation = 0.2


def property_of_object(bpy, s):
    s["text"]["heat"] = 0.75
    s["text"].update_tag()


def property_of_view_layer(bpy, s):
    bpy.context.view_layer["mood"] = 0.75
    bpy.context.scene.update_tag()


def lamp_energy(bpy, s):
    s["lamp"].data.energy = 80


def world_strength(bpy, s):
    bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 3


def camera_moved(bpy, s):
    bpy.context.scene.camera.location.x = 0.25


def object_moved(bpy, s):
    s["plain"].location.z = 0.2


def object_mirrored(bpy, s):
    s["b"].scale.x = -1


def object_removed(bpy, s):
    bpy.data.objects.remove(s["a"])


def object_added(bpy, s):
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("New", s["plain"].data))


def object_replaced(bpy, s):
    """Another mesh under the old name, perhaps where the old one was in memory."""
    old = s["plain"].data
    mesh = old.copy()
    mesh.vertices[0].co.z = 0.7
    s["plain"].data = mesh
    bpy.data.meshes.remove(old)
    mesh.name = "Plain"


def object_hidden(bpy, s):
    s["plain"].hide_render = True


def volume_moved(bpy, s):
    s["smoke"].location.x = 0.2


def next_frame(bpy, s):
    bpy.context.scene.frame_set(2)


def glows(bpy, s):
    s["material"].node_tree.nodes["Principled BSDF"].inputs["Emission Strength"].default_value = 1


EDITS = {  # edit -> meshes whose shape changes
    vertices_moved: {"Plain"},
    vertices_of_shared_mesh: {"Shared"},
    shape_key: {"Keyed"},
    modifier_target: {"Arrayed"},
    modifier_value: {SUBDIVIDED},
    modifier_toggled: set(),
    modifier_toggled_back: set(),
    simplify: set(),
    text_body: {"Text"},
    uv_changed: set(),
    attribute_changed: set(),
    attribute_asked_for: set(),
    material_value: set(),
    group_value: set(),
    coordinates_moved: {"Arrayed"},
    material_renamed: set(),
    material_animated: set(),
    material_reassigned: set(),
    faces_reassigned: set(),
    pixels_set: set(),
    image_reloaded: set(),
    color_space: set(),
    sequence_shifted: set(),
    sequence_rewritten: set(),
    tile_reloaded: set(),
    tile_added: set(),
    property_of_object: set(),
    property_of_view_layer: set(),
    lamp_energy: set(),
    world_strength: set(),
    camera_moved: set(),
    object_moved: set(),
    object_mirrored: set(),
    object_removed: set(),
    object_added: set(),
    object_replaced: {"Plain"},
    object_hidden: set(),
    volume_moved: set(),
    next_frame: set(),
    glows: set(),
    sky_added: set(),
    sky_parameter: set(),
}


@pytest.mark.parametrize("layout", ["whole", "by_mesh"])
def test_after_each_edit_the_scene_is_that_of_a_fresh_export(bpy, stage, states, layout):
    """One edit after the other, so that each meets what those before it left."""
    bpy.context.scene.nephele.hierarchy = layout
    before = states()
    assert set(by_name(before.meshes)) == ALL
    for edit, changed in EDITS.items():
        edit(bpy, stage)
        after = states()
        assert content(after) != content(before), f"{edit.__name__} changes nothing"
        in_both = by_name(before.meshes).keys() & by_name(after.meshes).keys()
        assert same_shapes(before, after) == in_both - changed, edit.__name__
        assert same_pictures(before, after), edit.__name__
        before = after
    again = states()  # nothing changed
    assert content(again) == content(before)
    assert same_shapes(before, again) == by_name(before.meshes).keys()


def test_frames_with_motion_blur(bpy, stage, states, link):
    """Everything that moves by itself from frame to frame: objects, shapes by drivers, keys and bones, the
    camera. Going back to a frame gives its picture again."""
    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    animate(stage["plain"], "location", {1: (0, 0, 0), 4: (0.3, 0, 0)})
    animate(scene.camera, "location", {1: (0, 0, 3), 4: (0.2, 0, 3)})
    shader = stage["material"].node_tree.nodes["Principled BSDF"]
    animate(shader.inputs["Roughness"], "default_value", {1: 0, 4: 1})
    stage["keyed"].data.shape_keys.key_blocks["Up"].driver_add("value").driver.expression = "frame / 4"
    bones = bpy.data.armatures.new("Bones")
    rig = link("Rig", bones)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = bones.edit_bones.new("Bone")
    bone.head, bone.tail = (0, 0, 0), (0, 1, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    bent = stage["bent"]
    bent.modifiers.new("Armature", "ARMATURE").object = rig
    bent.vertex_groups.new(name="Bone").add(range(10), 1.0, "ADD")
    animate(rig.pose.bones["Bone"], "location", {1: (0, 0, 0), 4: (0, 0, 1)})
    pictures = {}
    for frame in (1, 2, 3, 3, 2):
        scene.frame_set(frame)
        found = states()
        assert {m.name for m in found.meshes if m.motion is not None} >= {"Keyed", "Bent"}
        assert pictures.setdefault(frame, content(found)) == content(found)
    scene.render.use_motion_blur = False
    assert all(m.motion is None for m in states().meshes)


def test_undo_and_redo(bpy, stage, states):
    bpy.ops.ed.undo_push(message="before")
    before = states()
    bpy.data.objects["Plain"].data.vertices[0].co.z = 0.5
    bpy.data.objects["Lamp"].data.energy = 10
    bpy.ops.ed.undo_push(message="after")
    after = states()
    for step, expected in ((bpy.ops.ed.undo, before), (bpy.ops.ed.redo, after), (bpy.ops.ed.undo, before)):
        step()
        bpy.context.scene.nephele.samples = SAMPLES
        assert content(states()) == content(expected)


def test_instances_of_geometry_nodes(bpy, stage, states, link):
    """Geometry that belongs to no object of its own, and depends on others."""
    group = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    group.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    info, cube, instances, join = (
        group.nodes.new(f"GeometryNode{kind}")
        for kind in ("ObjectInfo", "MeshCube", "GeometryToInstance", "JoinGeometry")
    )
    info.inputs["Object"].default_value = stage["plain"]
    group.links.new(cube.outputs["Mesh"], instances.inputs[0])
    group.links.new(instances.outputs[0], join.inputs[0])
    group.links.new(info.outputs["Geometry"], join.inputs[0])
    group.links.new(join.outputs[0], group.nodes.new("NodeGroupOutput").inputs[0])
    link("Scattered", grid_mesh(bpy, "Ground")).modifiers.new("Nodes", "NODES").node_group = group
    before = states()
    camera_moved(bpy, stage)
    after = states()
    assert all(a.positions is b.positions for a, b in zip(after.meshes, before.meshes, strict=True))
    cube.inputs["Size"].default_value = (2, 1, 1)
    resized = states()
    assert content(resized) != content(after)
    vertices_moved(bpy, stage)
    assert content(states()) != content(resized)


def test_a_volume_that_a_modifier_changes(bpy, stage, states):
    stage["smoke"].data.is_sequence = False
    stage["smoke"].modifiers.new("Displace", "VOLUME_DISPLACE").strength = 0.0
    before = states()
    camera_moved(bpy, stage)
    after = states()
    assert after.volumes[0].path is before.volumes[0].path
    stage["smoke"].modifiers[0].strength = 0.5
    assert states().volumes[0].path != after.volumes[0].path


def test_an_export_that_fails_in_between(bpy, stage, states):
    """What Blender said had changed then is gone for good."""
    before = states()
    vertices_moved(bpy, stage)
    camera = bpy.context.scene.camera
    camera.data.type = "CUSTOM"
    with pytest.raises(ValueError, match="unsupported camera"):
        states()
    camera.data.type = "PERSP"
    assert same_shapes(before, states()) == ALL - {"Plain"}


def test_updates_are_not_believed_without_an_engine(bpy, stage):
    """Whoever asks for the depsgraph of the view layer sees the updates of its last evaluation only."""
    cache = ExportCache()
    export_scene(bpy.context.evaluated_depsgraph_get(), cache=cache)
    vertices_moved(bpy, stage)
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    assert content(export_scene(depsgraph, cache=cache)) == content(export_scene(depsgraph))


def test_arrays_cannot_be_written_to(bpy, stage, states):
    mesh = by_name(states().meshes)["Plain"]
    with pytest.raises(ValueError, match="read-only"):
        mesh.positions[0] = 1


def test_what_blender_did_not_evaluate_is_not_read(bpy, stage, states, monkeypatch):
    stage["smoke"].data.is_sequence = False
    states()
    read = []
    monkeypatch.setattr("nephele.export.mesh.read", lambda *_: read.append("mesh"))
    monkeypatch.setattr("nephele.export.images._read", lambda *_: read.append("image"))
    monkeypatch.setattr("test_updates.export_scene", lambda *_, **__: None)  # the fresh one
    monkeypatch.setattr("test_updates.content", lambda _: None)
    for edit in (camera_moved, lamp_energy, world_strength, object_moved, volume_moved):
        edit(bpy, stage)
        states(pictures=False)
        assert read == [], edit.__name__
