# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of node_cases.py: arithmetic, vectors and colours."""

CASES = {}


def case(name):
    """Adds the decorated function (Tile) as a case."""

    def add(function):
        CASES[name] = function
        return function

    return add


MATH = [
    "ADD",
    "SUBTRACT",
    "MULTIPLY",
    "DIVIDE",
    "MULTIPLY_ADD",
    "POWER",
    "LOGARITHM",
    "SQRT",
    "INVERSE_SQRT",
    "ABSOLUTE",
    "EXPONENT",
    "MINIMUM",
    "MAXIMUM",
    "LESS_THAN",
    "GREATER_THAN",
    "SIGN",
    "COMPARE",
    "SMOOTH_MIN",
    "SMOOTH_MAX",
    "ROUND",
    "FLOOR",
    "CEIL",
    "TRUNC",
    "FRACT",
    "MODULO",
    "FLOORED_MODULO",
    "WRAP",
    "SNAP",
    "PINGPONG",
    "SINE",
    "COSINE",
    "TANGENT",
    "ARCSINE",
    "ARCCOSINE",
    "ARCTANGENT",
    "ARCTAN2",
    "SINH",
    "COSH",
    "TANH",
    "RADIANS",
    "DEGREES",
]
VECTOR_MATH = [
    "ADD",
    "SUBTRACT",
    "MULTIPLY",
    "DIVIDE",
    "MULTIPLY_ADD",
    "CROSS_PRODUCT",
    "PROJECT",
    "REFLECT",
    "REFRACT",
    "FACEFORWARD",
    "DOT_PRODUCT",
    "DISTANCE",
    "LENGTH",
    "SCALE",
    "NORMALIZE",
    "ABSOLUTE",
    "POWER",
    "SIGN",
    "MINIMUM",
    "MAXIMUM",
    "FLOOR",
    "CEIL",
    "FRACTION",
    "MODULO",
    "WRAP",
    "SNAP",
    "SINE",
    "COSINE",
    "TANGENT",
]
BLENDS = [
    "MIX",
    "DARKEN",
    "MULTIPLY",
    "BURN",
    "LIGHTEN",
    "SCREEN",
    "DODGE",
    "ADD",
    "OVERLAY",
    "SOFT_LIGHT",
    "LINEAR_LIGHT",
    "DIFFERENCE",
    "EXCLUSION",
    "SUBTRACT",
    "DIVIDE",
    "HUE",
    "SATURATION",
    "COLOR",
    "VALUE",
]
ORANGE = (0.8, 0.45, 0.15, 1.0)


def _math(tile, operation):
    return tile.out("Math", 0, {0: tile.number, 1: 0.37, 2: 0.21}, operation=operation)


def _vector_math(tile, operation):
    inputs = {
        "Vector": tile.point,
        "Vector_001": (0.7, -0.4, 0.5),
        "Vector_002": (-0.3, 0.2, 0.9),
        "Scale": 0.8,
    }
    node = tile.node("VectorMath", inputs, operation=operation)
    return next(s for s in node.outputs if s.enabled)


def _blend(tile, mode):
    inputs = {"A_Color": tile.color, "B_Color": ORANGE, "Factor_Float": 0.7}
    return tile.out("Mix", "Result_Color", inputs, data_type="RGBA", blend_type=mode)


for operation in MATH:
    CASES[f"math {operation}"] = lambda tile, o=operation: _math(tile, o)
for operation in VECTOR_MATH:
    CASES[f"vector math {operation}"] = lambda tile, o=operation: _vector_math(tile, o)
for mode in BLENDS:
    CASES[f"blend {mode}"] = lambda tile, m=mode: _blend(tile, m)


@case("mix rgb clamped")
def _(tile):
    inputs = {"Color1": tile.color, "Color2": ORANGE, "Fac": 1.6}
    return tile.out("MixRGB", 0, inputs, blend_type="LINEAR_LIGHT", use_clamp=True)


@case("mix float")
def _(tile):
    inputs = {"A_Float": tile.number, "B_Float": 0.4, "Factor_Float": 1.4}
    return tile.out("Mix", "Result_Float", inputs, data_type="FLOAT", clamp_factor=False)


@case("mix vector by vector")
def _(tile):
    inputs = {"A_Vector": tile.point, "B_Vector": (0.4, 0.1, -0.3), "Factor_Vector": (0.2, 0.7, 1.3)}
    return tile.out("Mix", "Result_Vector", inputs, data_type="VECTOR", factor_mode="NON_UNIFORM")


for kind in ("LINEAR", "STEPPED", "SMOOTHSTEP", "SMOOTHERSTEP"):

    def _map_float(tile, kind=kind):
        inputs = {
            "Value": tile.number,
            "From Min": -0.4,
            "From Max": 0.5,
            "To Min": 1.2,
            "To Max": 0.1,
            "Steps": 3.0,
        }
        return tile.out("MapRange", "Result", inputs, interpolation_type=kind, clamp=kind == "LINEAR")

    def _map_vector(tile, kind=kind):
        ends = {
            "From_Min": (-0.5, -0.4, -0.6),
            "From_Max": (0.5, 0.6, 0.4),
            "To_Min": (0, 1, 0.2),
            "To_Max": (1, 0, 0.9),
        }
        inputs = {f"{k}_FLOAT3": v for k, v in ends.items()} | {
            "Vector": tile.point,
            "Steps_FLOAT3": (3, 4, 5),
        }
        settings = {"data_type": "FLOAT_VECTOR", "interpolation_type": kind, "clamp": False}
        return tile.out("MapRange", "Vector", inputs, **settings)

    CASES[f"map range {kind}"] = _map_float
    CASES[f"map range vector {kind}"] = _map_vector

for kind in ("MINMAX", "RANGE"):

    def _clamp(tile, kind=kind):
        return tile.out("Clamp", 0, {"Value": tile.number, "Min": 0.5, "Max": -0.2}, clamp_type=kind)

    CASES[f"clamp {kind}"] = _clamp

for kind in ("POINT", "TEXTURE", "VECTOR", "NORMAL"):

    def _mapping(tile, kind=kind):
        turn = {"Rotation": (0.3, -0.7, 1.1), "Location": (0.2, 0.5, -0.1), "Scale": (1.2, 0.7, -0.9)}
        return tile.out("Mapping", 0, {"Vector": tile.point} | turn, vector_type=kind)

    def _mapping_varied(tile, kind=kind):
        turn = {"Rotation": tile.point, "Location": (0.2, 0.5, -0.1), "Scale": (1.2, 0.7, -0.9)}
        return tile.out("Mapping", 0, {"Vector": (0.4, 0.5, 0.6)} | turn, vector_type=kind)

    CASES[f"mapping {kind}"] = _mapping
    CASES[f"mapping {kind} by a varying rotation"] = _mapping_varied

for kind in ("AXIS_ANGLE", "X_AXIS", "Y_AXIS", "Z_AXIS", "EULER_XYZ"):
    for invert in (False, True):

        def _rotate(tile, kind=kind, invert=invert):
            inputs = {"Vector": tile.point, "Center": (0.1, 0.2, 0.3)}
            inputs |= {"Rotation": (0.4, -0.8, 1.3)} if kind == "EULER_XYZ" else {"Angle": tile.number}
            if kind == "AXIS_ANGLE":
                inputs["Axis"] = (1.0, 0.5, -0.3)
            return tile.out("VectorRotate", 0, inputs, rotation_type=kind, invert=invert)

        CASES[f"vector rotate {kind} {invert}"] = _rotate

for mode in ("RGB", "HSV", "HSL"):

    def _separate(tile, mode=mode):
        parts = tile.node("SeparateColor", {0: tile.color}, mode=mode).outputs
        return tile.out("CombineXYZ", 0, {k: parts[k] for k in range(3)})

    def _combine(tile, mode=mode):
        parts = tile.node("SeparateColor", {0: tile.color}).outputs
        return tile.out("CombineColor", 0, {k: parts[k] for k in range(3)}, mode=mode)

    CASES[f"separate color {mode}"], CASES[f"combine color {mode}"] = _separate, _combine

for interpolation in ("LINEAR", "EASE", "CARDINAL", "B_SPLINE", "CONSTANT"):

    def _ramp(tile, interpolation=interpolation, mode="RGB", hue="NEAR"):
        node = tile.node("ValToRGB", {"Fac": tile.out("TexNoise", "Fac", {"Vector": tile.point})})
        ramp = node.color_ramp
        ramp.color_mode = mode
        ramp.elements[0].position, ramp.elements[0].color = 0.3, (0.9, 0.2, 0.1, 1)
        ramp.elements[1].position, ramp.elements[1].color = 0.7, (0.1, 0.4, 0.8, 0.5)
        ramp.elements.new(0.45).color = (0.2, 0.9, 0.3, 0.2)
        if mode == "RGB":
            ramp.interpolation = interpolation
        else:
            ramp.hue_interpolation = hue
        return node.outputs["Color"]

    CASES[f"color ramp {interpolation}"] = _ramp
for mode in ("HSV", "HSL"):
    for hue in ("NEAR", "FAR", "CW", "CCW"):
        CASES[f"color ramp {mode} {hue}"] = lambda tile, m=mode, h=hue: _ramp(tile, mode=m, hue=h)


def bend(mapping):
    """Gives every curve of a mapping a middle point off the diagonal."""
    for k, curve in enumerate(mapping.curves):
        curve.points.new(0.4, 0.2 + 0.15 * k)
    mapping.update()


@case("rgb curves")
def _(tile):
    node = tile.node("RGBCurve", {"Fac": 0.8, "Color": tile.color})
    bend(node.mapping)
    return node.outputs[0]


@case("vector curves")
def _(tile):
    node = tile.node("VectorCurve", {"Fac": 0.9, "Vector": tile.point})
    bend(node.mapping)
    return node.outputs[0]


@case("float curve")
def _(tile):
    node = tile.node("FloatCurve", {"Factor": 0.9, "Value": tile.number})
    bend(node.mapping)
    return node.outputs[0]


@case("hue saturation")
def _(tile):
    return tile.out(
        "HueSaturation", 0, {"Hue": 0.7, "Saturation": 1.4, "Value": 1.2, "Fac": 0.8, "Color": tile.color}
    )


@case("bright contrast")
def _(tile):
    return tile.out("BrightContrast", 0, {"Color": tile.color, "Bright": 0.1, "Contrast": 0.5})


@case("gamma")
def _(tile):
    return tile.out("Gamma", 0, {"Color": tile.color, "Gamma": 1.8})


@case("invert")
def _(tile):
    return tile.out("Invert", 0, {"Color": tile.color, "Fac": 0.7})


@case("rgb to bw")
def _(tile):
    return tile.out("RGBToBW", 0, {0: tile.color})


@case("blackbody")
def _(tile):
    return tile.out(
        "Blackbody",
        0,
        {0: tile.out("Math", 0, {0: tile.number, 1: 1500.0, 2: 3500.0}, operation="MULTIPLY_ADD")},
    )


@case("wavelength")
def _(tile):
    return tile.out(
        "Wavelength",
        0,
        {0: tile.out("Math", 0, {0: tile.number, 1: 250.0, 2: 570.0}, operation="MULTIPLY_ADD")},
    )


@case("value and rgb")
def _(tile):
    value, rgb = tile.node("Value"), tile.node("RGB")
    value.outputs[0].default_value, rgb.outputs[0].default_value = 0.7, ORANGE
    return tile.out("VectorMath", 0, {0: rgb.outputs[0], "Scale": value.outputs[0]}, operation="SCALE")


@case("muted node and reroute")
def _(tile):
    muted = tile.node("Gamma", {"Color": tile.color, "Gamma": 3.0})
    muted.mute = True
    reroute = tile.tree.nodes.new("NodeReroute")
    tile.tree.links.new(muted.outputs[0], reroute.inputs[0])
    return reroute.outputs[0]


@case("nested groups")
def _(tile):
    def group(inner):
        tree = tile.bpy.data.node_groups.new("Group", "ShaderNodeTree")
        for direction in ("INPUT", "OUTPUT"):
            tree.interface.new_socket("Vector", in_out=direction, socket_type="NodeSocketVector")
        start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
        middle = tree.nodes.new("ShaderNodeGroup" if inner else "ShaderNodeVectorMath")
        if inner:
            middle.node_tree = inner
        else:
            middle.operation = "SINE"
        tree.links.new(start.outputs[0], middle.inputs[0])
        tree.links.new(middle.outputs[0], end.inputs[0])
        return tree

    node = tile.tree.nodes.new("ShaderNodeGroup")
    node.node_tree = group(group(None))
    tile.tree.links.new(tile.point, node.inputs[0])
    return node.outputs[0]
