# SPDX-License-Identifier: GPL-3.0-or-later
"""What no render of the scene would read is not in the description: UV maps, attributes, normals, images,
materials and objects."""

import numpy as np
import pytest
from nephele.export import objects
from programs import NAMES, with_nodes

QUAD = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]


@pytest.fixture
def quads(bpy, link):
    """Returns the object of two smooth quads with a UV map and a colour attribute."""
    mesh = bpy.data.meshes.new("Quads")
    above = [(x, y, 1) for x, y, _ in QUAD]
    mesh.from_pydata(QUAD + above, [], [(0, 1, 2, 3), (4, 5, 6, 7)])
    mesh.shade_smooth()
    mesh.uv_layers.new(name="Map")
    mesh.color_attributes.new("Paint", "FLOAT_COLOR", "POINT")
    return link("Quads", mesh)


def image_of(bpy, name, value):
    """Returns a picture of one grey, another for each value."""
    image = bpy.data.images.new(name, 2, 1, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(np.tile((value, value, value, 1), 2).astype(np.float32))
    return image


def textured(bpy, name, *images, factor=0.5):
    """Returns a material whose colour is images[0], or the first two mixed by `factor`."""
    material = with_nodes(bpy.data.materials.new(name))
    tree = material.node_tree
    color = tree.nodes["Principled BSDF"].inputs["Base Color"]
    outputs = []
    for image in images:
        node = tree.nodes.new("ShaderNodeTexImage")
        node.image = image
        outputs.append(node.outputs["Color"])
    if len(outputs) == 1:
        tree.links.new(outputs[0], color)
        return material
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    mix.inputs[0].default_value = factor
    tree.links.new(outputs[0], mix.inputs[6])
    tree.links.new(outputs[1], mix.inputs[7])
    tree.links.new(mix.outputs[2], color)
    return material


def fog(bpy):
    """Returns a material that bounds a volume and has no surface."""
    material = with_nodes(bpy.data.materials.new("Fog"))
    tree = material.node_tree
    tree.nodes.remove(tree.nodes["Principled BSDF"])
    node = tree.nodes.new("ShaderNodeVolumeScatter")
    tree.links.new(node.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
    return material


def numbers_read(program):
    """Returns the numbers of the images that a program reads."""
    return [int(program.parameters[row[6]]) for row in program.code.tolist() if NAMES[row[0]] == "image"]


def test_what_a_branch_of_weight_0_reads_is_left_out(bpy, quads, export):
    first, second = image_of(bpy, "First", 0.25), image_of(bpy, "Second", 0.75)
    quads.data.materials.append(textured(bpy, "Mixed", first, second, factor=1.0))
    scene = export()
    (image,) = scene.images
    assert (image.name, image.pixels[0, 0, 0]) == ("Second", np.float32(0.75))
    assert numbers_read(scene.materials[0].surface) == [0]
    assert len(scene.meshes[0].uvs) == 1


def test_images_keep_their_materials(bpy, quads, export):
    pictures = [image_of(bpy, f"Picture {n}", n / 4) for n in range(4)]
    quads.data.materials.append(textured(bpy, "Dead", pictures[0], pictures[1], factor=1.0))
    quads.data.materials.append(textured(bpy, "Both", pictures[3], pictures[2]))
    quads.data.polygons[1].material_index = 1
    scene = export()
    read = [
        sorted(scene.images[n].name for n in numbers_read(material.surface)) for material in scene.materials
    ]
    assert read == [["Picture 1"], ["Picture 2", "Picture 3"]]
    assert len(scene.images) == 3


def test_uv_maps_and_attributes_of_a_branch_of_weight_0_are_not_read(bpy, quads, export):
    material = with_nodes(bpy.data.materials.new("Plain"))
    tree = material.node_tree
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type = "RGBA"
    mix.inputs[0].default_value = 0
    uv, paint = tree.nodes.new("ShaderNodeUVMap"), tree.nodes.new("ShaderNodeVertexColor")
    paint.layer_name = "Paint"
    add = tree.nodes.new("ShaderNodeVectorMath")
    tree.links.new(uv.outputs[0], add.inputs[0])
    tree.links.new(paint.outputs[0], add.inputs[1])
    tree.links.new(add.outputs[0], mix.inputs[7])
    tree.links.new(mix.outputs[2], tree.nodes["Principled BSDF"].inputs["Base Color"])
    quads.data.materials.append(material)
    (mesh,) = export().meshes
    assert (mesh.uvs, mesh.attributes) == ((), ())
    mix.inputs[0].default_value = 1
    (mesh,) = export().meshes
    assert (len(mesh.uvs), len(mesh.attributes)) == (1, 1)


def mixed_attributes(bpy, factor, *names):
    """Returns (material, mix): two attributes of the object, the second by `factor`."""
    material = with_nodes(bpy.data.materials.new("Attributes"))
    tree = material.node_tree
    mix = tree.nodes.new("ShaderNodeMix")
    mix.data_type, mix.inputs[0].default_value = "RGBA", factor
    for socket, name in zip(mix.inputs[6:8], names, strict=True):
        node = tree.nodes.new("ShaderNodeAttribute")
        node.attribute_type, node.attribute_name = "OBJECT", name
        tree.links.new(node.outputs["Color"], socket)
    tree.links.new(mix.outputs[2], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return material, mix


def test_properties_of_a_branch_of_weight_0_are_not_read(bpy, quads, export):
    quads["warm"], quads["cold"] = 0.25, 0.75
    material, mix = mixed_attributes(bpy, 1.0, "warm", "cold")
    quads.data.materials.append(material)
    absent, cold, warm = (0.0,) * 4, (0.75, 0.75, 0.75, 1.0), (0.25, 0.25, 0.25, 1.0)
    for factor, expected in ((1.0, (cold,)), (0.0, (absent, warm)), (0.5, (cold, warm))):
        mix.inputs[0].default_value = factor
        assert export().instances[0].properties == expected, factor


def test_a_sky_of_weight_0_is_left_out(bpy, export):
    world = with_nodes(bpy.data.worlds.new("World"))
    bpy.context.scene.world = world
    tree = world.node_tree
    sky, mix = tree.nodes.new("ShaderNodeTexSky"), tree.nodes.new("ShaderNodeMix")
    sky.sun_disc, mix.data_type, mix.inputs[0].default_value = False, "RGBA", 0
    tree.links.new(sky.outputs[0], mix.inputs[7])
    tree.links.new(mix.outputs[2], tree.nodes["Background"].inputs["Color"])
    assert export().images == ()
    mix.inputs[0].default_value = 0.5
    (image,) = export().images
    assert image.name == "Sky"


def test_a_material_on_no_object_is_left_out(bpy, quads, export):
    textured(bpy, "Nowhere", image_of(bpy, "Picture", 0.5)).use_fake_user = True
    scene = export()
    assert (scene.materials, scene.images) == ((), ())


def test_a_material_on_no_face_is_left_out(bpy, quads, export):
    unused = textured(bpy, "Unused", image_of(bpy, "Picture", 0.5))
    for material in (unused, fog(bpy), with_nodes(bpy.data.materials.new("Used")), unused):
        quads.data.materials.append(material)
    quads.data.polygons.foreach_set("material_index", [2, 2])
    scene = export()
    assert [material.name for material in scene.materials] == ["Used"]
    assert scene.instances[0].materials == (0, 0, 0, 0)
    assert (scene.images, scene.meshes[0].uvs) == ((), ())


def test_faces_beyond_the_last_slot_use_it(bpy, quads, export):
    for name in ("First", "Last"):
        quads.data.materials.append(with_nodes(bpy.data.materials.new(name)))
    quads.data.polygons.foreach_set("material_index", [7, 7])
    scene = export()
    assert [scene.materials[number].name for number in scene.instances[0].materials] == ["Last", "Last"]


def test_the_boundary_of_a_volume_has_no_normals(bpy, quads, link, export):
    quads.data.materials.append(fog(bpy))
    assert export().meshes[0].corner_normals is None
    other = link("Other", quads.data)
    other.material_slots[0].link = "OBJECT"
    other.material_slots[0].material = with_nodes(bpy.data.materials.new("Surface"))
    (mesh,) = export().meshes
    assert mesh.corner_normals.shape == (4, 3, 3)


def test_what_no_ray_meets_is_left_out(bpy, quads, link, export):
    hidden = link("Hidden", quads.data.copy())
    hidden.data.materials.append(textured(bpy, "Unseen", image_of(bpy, "Picture", 0.5)))
    for name in objects.VISIBILITY:
        setattr(hidden, name, False)
    scene = export()
    assert [instance.name for instance in scene.instances] == ["Quads"]
    assert (len(scene.meshes), scene.materials, scene.images) == (1, (), ())
    hidden.visible_shadow = True
    assert len(export().instances) == 2
