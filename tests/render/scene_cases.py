# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, one for each thing that a lamp, a camera or an object may do, to be rendered by Cycles too.

Each case is a function (bpy) that changes the stage: a floor, a wall of rough metal, a red box and a point
lamp before a camera, without a world."""

import math

import numpy as np


def shader(bpy, kind, **inputs):
    """Returns a new material of one shader node."""
    material = bpy.data.materials.new(kind)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node, output = tree.nodes.new(f"ShaderNode{kind}"), tree.nodes.new("ShaderNodeOutputMaterial")
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return material


def link(bpy, name, data):
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


SIGNS = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def box(bpy, name, size, place, material):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([[s * e / 2 for s, e in zip(sign, size, strict=True)] for sign in SIGNS], [], FACES)
    mesh.materials.append(material)
    item = link(bpy, name, mesh)
    item.location = place
    return item


def stage(bpy):
    """Sets the stage."""
    box(bpy, "Floor", (8, 8, 0.2), (0, 0, -0.1), shader(bpy, "BsdfDiffuse", Color=(0.7, 0.7, 0.6, 1)))
    metal = shader(bpy, "BsdfGlossy", Color=(0.8, 0.8, 0.8, 1), Roughness=0.5)
    next(node for node in metal.node_tree.nodes if node.type == "BSDF_GLOSSY").distribution = "GGX"
    box(bpy, "Wall", (8, 0.2, 3), (0, 2.5, 1.5), metal)
    box(bpy, "Box", (1, 1, 1), (-1, 0.3, 0.5), shader(bpy, "BsdfDiffuse", Color=(0.8, 0.2, 0.1, 1)))
    camera = link(bpy, "Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -6, 3), (1.15, 0, 0)
    scene = bpy.context.scene
    scene.camera = camera
    lamp(bpy, "POINT", shadow_soft_size=0.3)


def lamp(bpy, kind, energy=400.0, place=(0.6, -0.4, 2.2), turn=(0.3, 0.35, 0.2), name="Lamp", **properties):
    """Puts a lamp in the place of the one of that name. Returns its object."""
    before = bpy.data.objects.get(name)
    if before is not None:
        bpy.data.objects.remove(before)
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    for key, value in properties.items():
        setattr(data, key, value)
    item = link(bpy, name, data)
    item.location, item.rotation_euler = place, turn
    return item


def light_nodes(item):
    """Returns (tree, Emission node) of a lamp's node tree."""
    item.data.use_nodes = True
    return item.data.node_tree, item.data.node_tree.nodes["Emission"]


def picture(bpy):
    """Returns an image that tells its sides apart."""
    image = bpy.data.images.new("Picture", 8, 6, float_buffer=True)
    pixels = np.ones((6, 8, 4), np.float32)
    y, x = np.mgrid[0:6, 0:8]
    pixels[..., 0], pixels[..., 1], pixels[..., 2] = x / 7, y / 5, (x + y) % 2
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def projected(bpy, item, output="UV"):
    """Links a picture to a lamp's colour, by one of the texture coordinates."""
    tree, emission = light_nodes(item)
    texture, place = tree.nodes.new("ShaderNodeTexImage"), tree.nodes.new("ShaderNodeTexCoord")
    texture.image, texture.interpolation = picture(bpy), "Linear"
    tree.links.new(place.outputs[output], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], emission.inputs["Color"])


def shown_coordinate(bpy, item, output):
    """Makes a texture coordinate the colour of a lamp."""
    tree, emission = light_nodes(item)
    place, shift = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
    shift.operation = "MULTIPLY_ADD"
    shift.inputs[1].default_value = shift.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(place.outputs[output], shift.inputs[0])
    tree.links.new(shift.outputs[0], emission.inputs["Color"])


# ------------------------------------------------------------------------------------------------ lamps


def soft_point(bpy):
    lamp(bpy, "POINT", shadow_soft_size=0.5, use_soft_falloff=True)


def spot(bpy):
    lamp(bpy, "SPOT", spot_size=1.2, spot_blend=0.6, shadow_soft_size=0.2, use_soft_falloff=False)


def sun(bpy):
    lamp(bpy, "SUN", energy=3.0, angle=0.3)


def ellipse(bpy):
    lamp(bpy, "AREA", shape="ELLIPSE", size=1.6, size_y=0.6, spread=2.0)


def exposed(bpy):
    lamp(
        bpy,
        "AREA",
        energy=50.0,
        size=0.8,
        use_temperature=True,
        temperature=3200.0,
        exposure=1.5,
        normalize=False,
    )


def seen_lamp(bpy):
    lamp(bpy, "AREA", size=0.8, turn=(0.9, 0, 0)).visible_camera = True
    lamp(
        bpy, "POINT", energy=50.0, place=(1.4, 0, 1.0), shadow_soft_size=0.3, name="Ball"
    ).visible_camera = True


def matt_lamp(bpy):
    lamp(bpy, "AREA", size=1.0).visible_glossy = False


def shiny_lamp(bpy):
    lamp(bpy, "AREA", size=1.0).visible_diffuse = False


def short_lamp(bpy):
    lit_world(bpy)
    lamp(bpy, "POINT", shadow_soft_size=0.3).data.cycles.max_bounces = 0


def shadowless(bpy):
    lamp(bpy, "AREA", size=0.5, use_shadow=False)


def area_picture(bpy):
    projected(bpy, lamp(bpy, "AREA", shape="RECTANGLE", size=1.6, size_y=1.0, place=(0.3, 0.3, 1.2)))


def spot_picture(bpy):
    projected(bpy, lamp(bpy, "SPOT", spot_size=1.4, spot_blend=0.1, shadow_soft_size=0.05))


def point_picture(bpy):
    projected(bpy, lamp(bpy, "POINT", shadow_soft_size=0.05))


def sharp_spot_normal(bpy):
    shown_coordinate(bpy, lamp(bpy, "SPOT", spot_size=2.0, shadow_soft_size=0.0), "Normal")


def point_normal(bpy):
    shown_coordinate(bpy, lamp(bpy, "POINT", shadow_soft_size=0.4, use_soft_falloff=False), "Normal")


def soft_point_normal(bpy):
    shown_coordinate(bpy, lamp(bpy, "POINT", shadow_soft_size=0.4, use_soft_falloff=True), "Normal")


def area_object(bpy):
    shown_coordinate(bpy, lamp(bpy, "AREA", size=1.5), "Object")


def scaled_area_object(bpy):
    item = lamp(bpy, "AREA", size=0.8)
    item.scale = (2.0, 1.0, 1.5)
    shown_coordinate(bpy, item, "Object")


def area_normal(bpy):
    shown_coordinate(bpy, lamp(bpy, "AREA", size=1.5), "Normal")


def linear_falloff(bpy):
    tree, emission = light_nodes(lamp(bpy, "POINT", shadow_soft_size=0.2))
    node = tree.nodes.new("ShaderNodeLightFalloff")
    node.inputs["Strength"].default_value = 0.5
    node.inputs["Smooth"].default_value = 0.7
    tree.links.new(node.outputs["Linear"], emission.inputs["Strength"])


# A beam of another width on every side. Where Cycles smooths next to 0 degrees, it takes the value there for
# those at 45 and 315; here they are the same.
BEAM = (100, 96, 85, 65, 40, 20, 10, 4, 0, 0)
WIDTHS = (1.0, 1.0, 0.6, 0.5, 0.5, 0.7, 0.9, 1.0, 1.0)
PROFILE = "\n".join(
    (
        "IESNA:LM-63-2002", "TILT=NONE", "1 -1 2.0 10 9 1 2 0 0 0", "1 1 0", "0 10 20 30 40 50 60 75 90 180",
        " ".join(str(45 * n) for n in range(9)),
        *(" ".join(str(100 + w * (c - 100) if n == 0 else w * c) for n, c in enumerate(BEAM)) for w in
        WIDTHS),
    )
)  # fmt: skip


def measured(bpy, item, wide):
    tree, emission = light_nodes(item)
    text = bpy.data.texts.new("Profile")
    text.write(PROFILE)
    node = tree.nodes.new("ShaderNodeTexIES")
    node.ies = text
    if wide:
        node.inputs["Strength"].default_value = 0.5
    tree.links.new(node.outputs[0], emission.inputs["Strength"])


def ies_point(bpy):
    measured(bpy, lamp(bpy, "POINT", energy=50.0, shadow_soft_size=0.0), False)


def ies_spot(bpy):
    measured(bpy, lamp(bpy, "SPOT", energy=50.0, spot_size=2.5, shadow_soft_size=0.1), True)


# ---------------------------------------------------------------------------------------------- linking


def collection(bpy, *names, state="INCLUDE"):
    result = bpy.data.collections.new("Linked")
    for name in names:
        result.objects.link(bpy.data.objects[name])
    for entry in result.collection_objects:
        entry.light_linking.link_state = state
    return result


def two_lamps(bpy):
    """Returns a red lamp and a blue one."""
    red = lamp(bpy, "AREA", size=0.8, color=(1, 0.1, 0.1))
    blue = lamp(bpy, "POINT", place=(-1.5, -1.5, 2), shadow_soft_size=0.2, color=(0.1, 0.2, 1), name="Blue")
    return red, blue


def received(bpy):
    red, blue = two_lamps(bpy)
    red.light_linking.receiver_collection = collection(bpy, "Floor", "Wall")
    blue.light_linking.receiver_collection = collection(bpy, "Floor", state="EXCLUDE")


def blocked(bpy):
    red, blue = two_lamps(bpy)
    red.light_linking.blocker_collection = collection(bpy, "Wall")
    blue.light_linking.blocker_collection = collection(bpy, "Box", state="EXCLUDE")


def linked_glow(bpy):
    glow = box(bpy, "Glow", (0.5, 0.5, 0.5), (1.2, -0.5, 1.0), shader(bpy, "Emission", Strength=20.0))
    glow.light_linking.receiver_collection = collection(bpy, "Box", "Wall")
    lamp(bpy, "POINT", energy=50.0, shadow_soft_size=0.3)


# ---------------------------------------------------------------------------------------------- cameras


def sky_of_directions(bpy):
    """Gives the world a colour for each direction."""
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    tree = world.node_tree
    place, shift = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeVectorMath")
    shift.operation = "MULTIPLY_ADD"
    shift.inputs[1].default_value = shift.inputs[2].default_value = (0.5, 0.5, 0.5)
    tree.links.new(place.outputs["Generated"], shift.inputs[0])
    tree.links.new(shift.outputs[0], tree.nodes["Background"].inputs["Color"])
    bpy.context.scene.world = world


def panorama(kind, **values):
    def case(bpy):
        sky_of_directions(bpy)
        data = bpy.context.scene.camera.data
        data.type, data.panorama_type = "PANO", kind
        for name, value in values.items():
            setattr(data, name, value)

    return case


def lens(bpy):
    data = bpy.context.scene.camera.data
    data.shift_x, data.shift_y = 0.1, -0.05
    dof = data.dof
    dof.use_dof, dof.aperture_fstop, dof.focus_object = True, 0.2, bpy.data.objects["Box"]
    dof.aperture_blades, dof.aperture_rotation, dof.aperture_ratio = 5, 0.4, 1.6


def panoramic_focus(bpy):
    panorama("EQUIRECTANGULAR", longitude_min=-0.8, longitude_max=0.8, latitude_min=-0.6, latitude_max=0.5)(
        bpy
    )
    dof = bpy.context.scene.camera.data.dof
    dof.use_dof, dof.aperture_fstop, dof.focus_distance = True, 0.1, 3.0


CAMERAS = {
    "equirectangular": panorama("EQUIRECTANGULAR"),
    "equirectangular part": panorama(
        "EQUIRECTANGULAR", longitude_min=-2.0, longitude_max=1.0, latitude_min=-0.6, latitude_max=1.2
    ),
    "equidistant": panorama("FISHEYE_EQUIDISTANT", fisheye_fov=math.radians(200)),
    "equisolid": panorama("FISHEYE_EQUISOLID", fisheye_lens=9.0, fisheye_fov=math.radians(190)),
    "equisolid fitted": panorama(
        "FISHEYE_EQUISOLID", fisheye_lens=12.0, sensor_fit="VERTICAL", sensor_height=18.0
    ),
    "polynomial": panorama(
        "FISHEYE_LENS_POLYNOMIAL",
        fisheye_fov=math.radians(150),
        fisheye_polynomial_k0=0.01,
        fisheye_polynomial_k1=-0.08,
        fisheye_polynomial_k2=1e-4,
        fisheye_polynomial_k3=-1e-5,
    ),
    "mirror ball": panorama("MIRRORBALL"),
    "cube map": panorama("EQUIANGULAR_CUBEMAP_FACE"),
    "cylinder": panorama(
        "CENTRAL_CYLINDRICAL",
        central_cylindrical_range_u_min=-1.5,
        central_cylindrical_range_u_max=2.0,
        central_cylindrical_range_v_min=-1.0,
        central_cylindrical_range_v_max=1.4,
        central_cylindrical_radius=1.2,
    ),
    "shifted panorama": panorama("EQUIRECTANGULAR", shift_x=0.1, shift_y=0.2),
    "panoramic focus": panoramic_focus,
    "lens": lens,
}
LAMPS = {
    case.__name__.replace("_", " "): case
    for case in (
        soft_point, spot, sun, ellipse, exposed, seen_lamp, matt_lamp, shiny_lamp, short_lamp, shadowless,
        area_picture, spot_picture, point_picture, sharp_spot_normal, point_normal, soft_point_normal,
        area_object, scaled_area_object, area_normal, linear_falloff, ies_point, ies_spot, received,
        blocked, linked_glow,
    )
}  # fmt: skip


# --------------------------------------------------------------------------------------------- geometry


def tuft(bpy):
    """Returns an object of 60 hair curves over the box, coloured by where they are along the strand."""
    rng = np.random.default_rng(3)
    data = bpy.data.hair_curves.new("Tuft")
    data.add_curves([5] * 60)
    keys = np.zeros((60, 5, 3), np.float32)
    keys[:, 0] = rng.uniform((-1.2, -1.0, 0), (1.2, 1.0, 0), (60, 3))
    for key in range(1, 5):
        keys[:, key] = keys[:, key - 1] + rng.normal((0.05, 0, 0.3), 0.1, (60, 3))
    data.attributes["position"].data.foreach_set("vector", keys.ravel())
    radius = data.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.tile(np.linspace(0.05, 0.015, 5, dtype=np.float32), 60))
    data.materials.append(strand_material(bpy))
    item = link(bpy, "Tuft", data)
    item.location = (0.8, -0.4, 0)
    return item


def strand_material(bpy):
    material = shader(bpy, "BsdfDiffuse")
    tree = material.node_tree
    info, combine = tree.nodes.new("ShaderNodeHairInfo"), tree.nodes.new("ShaderNodeCombineColor")
    tree.links.new(info.outputs["Intercept"], combine.inputs[0])
    tree.links.new(info.outputs["Is Strand"], combine.inputs[1])
    combine.inputs[2].default_value = 0.4
    tree.links.new(
        combine.outputs[0], next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").inputs["Color"]
    )
    return material


def thick_curves(bpy):
    tuft(bpy)
    bpy.context.scene.cycles_curves.shape = "THICK"


def ribbons(bpy):
    tuft(bpy)
    bpy.context.scene.cycles_curves.shape = "RIBBONS"


def particle_hair(bpy):
    item = bpy.data.objects["Box"]
    item.data.uv_layers.new(name="UVMap")
    item.modifiers.new("Hair", "PARTICLE_SYSTEM")
    settings = item.particle_systems[0].settings
    settings.type, settings.count, settings.hair_length, settings.hair_step = "HAIR", 80, 0.7, 4
    settings.render_step = settings.display_step = 3
    settings.root_radius, settings.tip_radius, settings.radius_scale = 1.0, 0.2, 0.08
    settings.brownian_factor = 0.2
    bpy.context.scene.cycles_curves.shape = "THICK"
    item.data.materials.append(shader(bpy, "BsdfDiffuse", Color=(0.2, 0.7, 0.3, 1)))
    settings.material = 2


def points_of(bpy, item, radius):
    """Makes a point cloud of an object's vertices, by Geometry Nodes."""
    group = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    start, end = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    points, paint = group.nodes.new("GeometryNodeMeshToPoints"), group.nodes.new("GeometryNodeSetMaterial")
    points.inputs["Radius"].default_value = radius
    material = shader(bpy, "BsdfDiffuse")
    tree = material.node_tree
    info = tree.nodes.new("ShaderNodePointInfo")
    tree.links.new(
        info.outputs["Position"], next(n for n in tree.nodes if n.type == "BSDF_DIFFUSE").inputs["Color"]
    )
    paint.inputs["Material"].default_value = material
    group.links.new(start.outputs[0], points.inputs[0])
    group.links.new(points.outputs[0], paint.inputs[0])
    group.links.new(paint.outputs[0], end.inputs[0])
    item.modifiers.new("Points", "NODES").node_group = group


def points(bpy):
    points_of(bpy, bpy.data.objects["Box"], 0.3)


def held_out(bpy):
    bpy.data.objects["Box"].is_holdout = True


def one_material(bpy):
    bpy.context.view_layer.material_override = shader(bpy, "BsdfDiffuse", Color=(0.2, 0.4, 0.8, 1))


def lit_world(bpy):
    """Returns a bright world in place of the lamp."""
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.7, 1.0, 1)
    bpy.context.scene.world = world
    bpy.data.objects["Lamp"].data.energy = 100
    return world


def matt_world(bpy):
    lit_world(bpy).cycles_visibility.glossy = False


def dark_world(bpy):
    lit_world(bpy).cycles_visibility.diffuse = False


def unseen_world(bpy):
    lit_world(bpy).cycles_visibility.camera = False
    bpy.data.objects["Wall"].hide_render = True


def without_sky(bpy):
    lit_world(bpy)
    bpy.context.view_layer.use_sky = False


def unseen_by(kind):
    def case(bpy):
        setattr(bpy.data.objects["Box"], f"visible_{kind}", False)

    return case


def indirect_only(bpy):
    group = bpy.data.collections.new("Indirect")
    bpy.context.scene.collection.children.link(group)
    item = bpy.data.objects["Box"]
    bpy.context.scene.collection.objects.unlink(item)
    group.objects.link(item)
    bpy.context.view_layer.layer_collection.children["Indirect"].indirect_only = True


# ----------------------------------------------------------------------------------------------- motion


def in_motion(bpy, item, **keyed):
    from keyframes import animate

    scene = bpy.context.scene
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 1.0
    for name, (start, end) in keyed.items():
        animate(item, name, {4: start, 6: end})
    scene.frame_set(5)


def shutter_curve(bpy):
    in_motion(bpy, bpy.data.objects["Box"], location=((-3, 0, 0.5), (3, 0, 0.5)))
    points = bpy.context.scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[-1].location = (0.0, 0.0), (1.0, 1.0)
    bpy.context.scene.render.motion_blur_shutter_curve.update()


def moving_curves(bpy):
    bpy.context.scene.cycles_curves.shape = "THICK"
    in_motion(bpy, tuft(bpy), location=((-0.5, -0.4, 0), (2.0, -0.4, 0.3)))


GEOMETRY = {
    case.__name__.replace("_", " "): case
    for case in (
        thick_curves,
        ribbons,
        particle_hair,
        points,
        held_out,
        one_material,
        indirect_only,
        matt_world,
        dark_world,
        unseen_world,
        without_sky,
    )
} | {f"unseen by {kind}": unseen_by(kind) for kind in ("camera", "diffuse", "glossy", "shadow")}
MOTION = {"shutter curve": shutter_curve, "moving curves": moving_curves}
CASES = LAMPS | CAMERAS | GEOMETRY | MOTION
