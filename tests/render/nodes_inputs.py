# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of node_cases.py: what nodes read of the point, the object and the ray, and what they make of
normals."""

CASES = {}


def case(name):
    """Adds the decorated function (Tile) as a case."""

    def add(function):
        CASES[name] = function
        return function

    return add


def reads(name, kind, output, inputs=(), **properties):
    """Adds the case of one output of a node."""
    CASES[name] = lambda tile: tile.out(kind, output, inputs, **properties)


for output in (
    "Position",
    "Normal",
    "Tangent",
    "True Normal",
    "Incoming",
    "Parametric",
    "Backfacing",
    "Pointiness",
):
    reads(f"geometry {output}", "NewGeometry", output)
for output in ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection"):
    reads(f"texture coordinate {output}", "TexCoord", output)
for output in ("View Vector", "View Z Depth", "View Distance"):
    reads(f"camera data {output}", "CameraData", output)
for output in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random"):
    reads(f"object info {output}", "ObjectInfo", output)
for output in ("Color", "Vector", "Fac", "Alpha"):
    reads(f"attribute {output}", "Attribute", output, attribute_name="Paint")
reads("attribute number", "Attribute", "Fac", attribute_name="weight")
reads("attribute of the object", "Attribute", "Fac", attribute_name="strength", attribute_type="OBJECT")
reads("attribute of the instancer", "Attribute", "Fac", attribute_name="strength", attribute_type="INSTANCER")
reads("attribute of the view layer", "Attribute", "Color", attribute_name="tint", attribute_type="VIEW_LAYER")
reads("attribute that is absent", "Attribute", "Color", attribute_name="nowhere", attribute_type="OBJECT")
reads("color attribute", "VertexColor", "Color", layer_name="Paint")
reads("color attribute alpha", "VertexColor", "Alpha", layer_name="Paint")
reads("uv map", "UVMap", "UV", uv_map="Other")
for output in ("Index", "Random", "Age", "Location"):
    reads(f"particle info {output}", "ParticleInfo", output)
for output in ("Is Strand", "Intercept", "Length", "Random"):
    reads(f"hair info {output}", "HairInfo", output)
for output in (
    "Is Camera Ray", "Is Shadow Ray", "Is Diffuse Ray", "Is Glossy Ray", "Is Singular Ray",
    "Is Reflection Ray", "Is Transmission Ray", "Is Volume Scatter Ray", "Ray Depth", "Diffuse Depth",
    "Glossy Depth", "Transparent Depth", "Transmission Depth", "Portal Depth",
):  # fmt: skip
    reads(f"light path {output}", "LightPath", output)
for output in ("Quadratic", "Linear"):
    reads(f"light falloff {output}", "LightFalloff", output, {"Strength": 0.05, "Smooth": 20.0})
for output in ("Fresnel", "Facing"):
    reads(f"layer weight {output}", "LayerWeight", output, {"Blend": 0.3})
reads("fresnel", "Fresnel", 0, {"IOR": 1.6})
for axis in "XYZ":
    reads(f"tangent {axis}", "Tangent", 0, direction_type="RADIAL", axis=axis)
reads("tangent of a uv map", "Tangent", 0, direction_type="UV_MAP", uv_map="Other")
reads("wireframe", "Wireframe", 0, {"Size": 0.2})
reads("wireframe in pixels", "Wireframe", 0, {"Size": 3.0}, use_pixel_size=True)


@case("light path Ray Length")
def _(tile):
    return tile.out("Math", 0, {0: tile.out("LightPath", "Ray Length"), 1: 60.0}, operation="SUBTRACT")


@case("normal")
def _(tile):
    return tile.out("Normal", "Dot", {"Normal": tile.out("NewGeometry", "Normal")})


for source in ("WORLD", "OBJECT", "CAMERA"):
    for target in ("WORLD", "OBJECT", "CAMERA"):

        def _transform(tile, source=source, target=target):
            kind = "VECTOR" if "CAMERA" in (source, target) else "POINT"
            settings = {"vector_type": kind, "convert_from": source, "convert_to": target}
            return tile.out("VectorTransform", 0, {0: tile.point}, **settings)

        CASES[f"vector transform {source} {target}"] = _transform
SPACES = {"vector_type": "NORMAL", "convert_from": "OBJECT", "convert_to": "WORLD"}
reads("vector transform of a normal", "VectorTransform", 0, {0: (0.3, 0.4, 0.5)}, **SPACES)

for space in ("TANGENT", "OBJECT", "WORLD", "BLENDER_OBJECT", "BLENDER_WORLD"):

    def _normal_map(tile, space=space):
        return tile.out("NormalMap", 0, {"Color": (0.6, 0.3, 0.9, 1), "Strength": 0.7}, space=space)

    CASES[f"normal map {space}"] = _normal_map


def _waves(tile, coordinate="Object"):
    """A smooth height."""
    point = tile.out("TexCoord", coordinate)
    return tile.out("Math", 0, {0: tile.out("SeparateXYZ", 0, {0: point}), 1: 3.0}, operation="MULTIPLY")


for coordinate in ("Object", "UV", "Generated"):

    def _bump(tile, coordinate=coordinate):
        height = tile.out("Math", 0, {0: _waves(tile, coordinate)}, operation="SINE")
        return tile.out("Bump", 0, {"Height": height, "Strength": 0.8, "Distance": 0.3})

    CASES[f"bump {coordinate}"] = _bump


@case("bump inverted")
def _(tile):
    height = tile.out("Math", 0, {0: _waves(tile)}, operation="COSINE")
    return tile.out("Bump", 0, {"Height": height, "Distance": 0.2}, invert=True)


@case("bump of an attribute on a normal map")
def _(tile):
    height = tile.out("Attribute", "Fac", attribute_name="weight")
    mapped = tile.out("NormalMap", 0, {"Color": (0.6, 0.5, 0.9, 1)})
    return tile.out("Bump", 0, {"Height": height, "Distance": 0.5, "Normal": mapped})


for space in ("OBJECT", "WORLD"):

    def _displacement(tile, space=space):
        height = tile.out("Math", 0, {0: tile.number}, operation="SINE")
        return tile.out("Displacement", 0, {"Height": height, "Midlevel": 0.2, "Scale": 0.7}, space=space)

    CASES[f"displacement {space}"] = _displacement
for space in ("TANGENT", "OBJECT", "WORLD"):

    def _vector_displacement(tile, space=space):
        return tile.out(
            "VectorDisplacement", 0, {"Vector": tile.color, "Midlevel": 0.3, "Scale": 0.6}, space=space
        )

    CASES[f"vector displacement {space}"] = _vector_displacement
