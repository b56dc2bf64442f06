# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of node_cases.py: images, packed into the file."""

import numpy as np

CASES = {}
SIZE = 8


def noise_image(tile, space="Non-Color", is_float=False, opaque=True, name="Noise"):
    """Returns an image of random texels, smooth enough that filters agree."""
    images = tile.bpy.data.images
    key = f"{name} {space} {is_float} {opaque}"
    if key in images:
        return images[key]
    image = images.new(key, SIZE, SIZE, alpha=True, float_buffer=is_float)
    image.colorspace_settings.name = space
    texels = np.random.default_rng(len(images)).uniform(0.1, 0.9, (SIZE, SIZE, 4)).astype(np.float32)
    if opaque:
        texels[..., 3] = 1
    image.pixels.foreach_set(texels.ravel())
    image.pack()
    return image


def image_case(name, output="Color", coordinate="Point", scale=1.0, make=noise_image, image=(), **properties):
    def case(tile):
        node = tile.node("TexImage", **properties)
        node.image = make(tile, **dict(image))
        point = tile.point if coordinate == "Point" else tile.out("TexCoord", coordinate)
        if scale != 1:
            point = tile.out("VectorMath", 0, {0: point, "Scale": scale}, operation="SCALE")
        tile.tree.links.new(point, node.inputs["Vector"])
        if name.endswith("beside alpha"):
            alpha = tile.out("Math", 0, {0: node.outputs["Alpha"], 1: 0.1}, operation="MULTIPLY")
            return tile.out("VectorMath", 0, {0: node.outputs["Color"], 1: alpha}, operation="ADD")
        return node.outputs[output]

    CASES[name] = case


for interpolation in ("Linear", "Closest", "Cubic", "Smart"):
    image_case(f"image {interpolation}", interpolation=interpolation)
for extension in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
    image_case(f"image {extension}", scale=2.3, interpolation="Closest", extension=extension)
for projection in ("SPHERE", "TUBE"):
    image_case(f"image {projection}", projection=projection)
for blend in (0.0, 0.4):
    image_case(f"image BOX {blend}", coordinate="Normal", projection="BOX", projection_blend=blend)
for space in ("sRGB", "Non-Color", "Linear Rec.709", "Linear Rec.2020", "AgX Base sRGB", "Filmic sRGB"):
    image_case(f"image {space}", image={"space": space}, interpolation="Closest")
image_case("image float", image={"space": "Linear Rec.709", "is_float": True}, interpolation="Closest")
for space in ("sRGB", "Non-Color"):
    translucent = {"space": space, "opaque": False}
    image_case(f"image {space} translucent", image=translucent, interpolation="Closest")
    image_case(f"image {space} alpha", output="Alpha", image=translucent, interpolation="Closest")
    image_case(f"image {space} beside alpha", image=translucent, interpolation="Closest")

for projection in ("EQUIRECTANGULAR", "MIRROR_BALL"):

    def _environment(tile, projection=projection):
        node = tile.node(
            "TexEnvironment", {"Vector": tile.point}, projection=projection, interpolation="Closest"
        )
        node.image = noise_image(tile)
        return node.outputs[0]

    CASES[f"environment {projection}"] = _environment
