# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene of many small tiles, each of one surface shader: bent patches of flat triangles that cast no
shadow, under one camera far away. Under a sun without size, and without bounces, each pixel is the shader's
value for one pair of directions, without noise."""

import itertools
import math

from node_cases import patch
from tiles import look_down

PIXELS = 8  # along a tile's side
STEEP = 3.0  # tilts up to 58 degrees
COLOR, TINT = (0.9, 0.5, 0.2, 1), (0.2, 0.5, 1.0, 1)

CASES = {}  # name -> (node without "ShaderNodeBsdf", inputs, properties)


def case(name, kind, inputs=(), **properties):
    CASES[name] = (kind, dict(inputs), properties)


def principled(name, **inputs):
    case(
        f"principled {name}",
        "Principled",
        {k.replace("_", " ").title().replace("Ior", "IOR"): v for k, v in inputs.items()},
    )


def glossy(name, distribution="GGX", **inputs):
    case(f"glossy {name}", "Anisotropic", {"Color": COLOR} | inputs, distribution=distribution)


def metallic(name, **inputs):
    properties = {k: inputs.pop(k) for k in ("fresnel_type", "distribution") if k in inputs}
    inputs = {k.replace("_", " "): v for k, v in inputs.items()}
    case(
        f"metallic {name}",
        "Metallic",
        inputs,
        **({"fresnel_type": "F82", "distribution": "GGX"} | properties),
    )


principled("default")
principled("rough diffuse", base_color=COLOR, diffuse_roughness=0.7)
for amount, turn in ((0.5, 0.0), (1.0, 0.0), (0.9, 0.15)):
    principled(
        f"anisotropic metal {amount} {turn}",
        base_color=COLOR,
        metallic=1.0,
        roughness=0.4,
        anisotropic=amount,
        anisotropic_rotation=turn,
    )
principled("anisotropic dielectric", base_color=(0, 0, 0, 1), roughness=0.4, anisotropic=0.8)
principled("edge tint", base_color=COLOR, metallic=1.0, specular_tint=TINT, roughness=0.3)
principled("coat", base_color=COLOR, coat_weight=0.7, coat_roughness=0.3, coat_ior=1.8, coat_tint=TINT)
principled(
    "coat over metal", base_color=COLOR, metallic=1.0, roughness=0.6, coat_weight=1.0, coat_roughness=0.2
)
principled("level", base_color=COLOR, specular_ior_level=0.8, specular_tint=TINT, roughness=0.35)
principled("ior 1", base_color=COLOR, ior=1.0)
principled("ior 3", base_color=COLOR, ior=3.0, roughness=0.5)
principled("transmission", base_color=COLOR, transmission_weight=1.0, roughness=0.5)
principled("half transmission", base_color=COLOR, transmission_weight=0.5, roughness=0.6, metallic=0.3)
principled("roughness 1", base_color=COLOR, metallic=0.5, roughness=1.0)
for roughness in (0.2, 0.5, 1.0):
    principled(
        f"sheen {roughness}",
        base_color=(0, 0, 0, 1),
        specular_ior_level=0.0,
        sheen_weight=0.8,
        sheen_roughness=roughness,
        sheen_tint=TINT,
    )
    case(f"sheen {roughness}", "Sheen", {"Color": COLOR, "Roughness": roughness})
    case(f"velvet {roughness}", "Sheen", {"Color": COLOR, "Roughness": roughness}, distribution="ASHIKHMIN")
principled("sheen over diffuse", base_color=COLOR, sheen_weight=1.0, sheen_roughness=0.7)
for thickness in (100.0, 400.0, 1200.0):
    principled(
        f"film {thickness}",
        base_color=(0, 0, 0, 1),
        roughness=0.5,
        thin_film_thickness=thickness,
        thin_film_ior=1.8,
    )
principled(
    "film on metal",
    base_color=COLOR,
    metallic=1.0,
    roughness=0.5,
    thin_film_thickness=400.0,
    thin_film_ior=1.5,
)
principled(
    "film on glass",
    base_color=COLOR,
    transmission_weight=1.0,
    roughness=0.5,
    thin_film_thickness=500.0,
    thin_film_ior=1.7,
)
principled(
    "film on a tint",
    base_color=(0, 0, 0, 1),
    roughness=0.5,
    specular_tint=TINT,
    thin_film_thickness=400.0,
    thin_film_ior=1.6,
)
for amount in (-0.99, -0.5, 0.5, 0.99):
    glossy(f"anisotropy {amount}", Roughness=0.5, Anisotropy=amount)
glossy("beckmann anisotropy", "BECKMANN", Roughness=0.5, Anisotropy=0.6, Rotation=0.2)
glossy("multiscatter anisotropy", "MULTI_GGX", Roughness=0.8, Anisotropy=0.6, Rotation=0.7)
metallic("f82", Base_Color=COLOR, Edge_Tint=TINT, Roughness=0.4)
metallic("f82 anisotropy", Base_Color=COLOR, Edge_Tint=TINT, Roughness=0.4, Anisotropy=0.7, Rotation=0.3)
metallic("conductor", fresnel_type="PHYSICAL_CONDUCTOR", Roughness=0.4)
metallic(
    "gold",
    fresnel_type="PHYSICAL_CONDUCTOR",
    distribution="MULTI_GGX",
    Roughness=0.7,
    IOR=(0.18, 0.42, 1.37),
    Extinction=(3.42, 2.35, 1.77),
)
metallic(
    "film on f82",
    Base_Color=COLOR,
    Edge_Tint=(1, 1, 1, 1),
    Roughness=0.4,
    Thin_Film_Thickness=350.0,
    Thin_Film_IOR=1.5,
)
metallic(
    "film on a conductor",
    fresnel_type="PHYSICAL_CONDUCTOR",
    Roughness=0.4,
    Thin_Film_Thickness=350.0,
    Thin_Film_IOR=1.5,
)
case(
    "glass film",
    "Glass",
    {"Color": COLOR, "Roughness": 0.5, "Thin Film Thickness": 500.0, "Thin Film IOR": 1.7},
    distribution="GGX",
)
case("refraction", "Refraction", {"Color": COLOR, "Roughness": 0.5})
for size, smooth in ((0.3, 0.0), (0.5, 0.4), (0.9, 1.0)):
    for component in ("DIFFUSE", "GLOSSY"):
        case(
            f"toon {component.lower()} {size} {smooth}",
            "Toon",
            {"Color": COLOR, "Size": size, "Smooth": smooth},
            component=component,
        )
case("diffuse", "Diffuse", {"Color": COLOR})
case("rough diffuse", "Diffuse", {"Color": COLOR, "Roughness": 0.8})
case("translucent", "Translucent", {"Color": COLOR})


def add_shader(tree, kind, inputs, properties):
    """Adds a shader node and returns its output."""
    node = tree.nodes.new(f"ShaderNode{kind}" if kind == "SubsurfaceScattering" else f"ShaderNodeBsdf{kind}")
    for name, value in properties.items():
        setattr(node, name, value)
    for name, value in inputs.items():
        node.inputs[name].default_value = value
    return node.outputs[0]


def material(bpy, name, shader):
    """Returns a material of one shader of CASES."""
    made = bpy.data.materials.new(name)
    tree = made.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(add_shader(tree, *shader), output.inputs["Surface"])
    return made


def build(bpy, cases, sun):
    """Fills the open, empty file with a tile per case under a sun that shines along `sun`. Returns (columns,
    rows), as node_cases.build does."""
    columns = math.ceil(math.sqrt(len(cases)))
    rows = math.ceil(len(cases) / columns)
    mesh = patch(bpy)
    mesh.shade_flat()
    scene = bpy.context.scene
    for (row, column), (name, shader) in zip(
        itertools.product(range(rows), range(columns)), cases.items(), strict=False
    ):
        item = bpy.data.objects.new(name, mesh)
        item.location = (2 * column - columns + 1, 2 * row - rows + 1, 0)
        item.scale = (1, 1, STEEP)
        item.visible_shadow = False
        mesh.materials or mesh.materials.append(None)
        item.material_slots[0].link = "OBJECT"
        item.material_slots[0].material = material(bpy, name, shader)
        scene.collection.objects.link(item)
    look_down(bpy, scene, columns)
    lamp = bpy.data.lights.new("Sun", "SUN")
    lamp.energy, lamp.angle = math.pi, 0
    light = bpy.data.objects.new("Sun", lamp)
    import mathutils

    light.rotation_euler = (-mathutils.Vector(sun)).to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(light)
    scene.world = bpy.data.worlds.new("World")
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    scene.render.resolution_x, scene.render.resolution_y = columns * PIXELS, rows * PIXELS
    return columns, rows


def tile_of(image, number, columns):
    """Returns (PIXELS, PIXELS, 3): the pixels of one tile. image: (h, w, 3), top row first."""
    row, column = divmod(number, columns)
    upside = image[::-1]
    return upside[row * PIXELS : (row + 1) * PIXELS, column * PIXELS : (column + 1) * PIXELS]
