# SPDX-License-Identifier: GPL-3.0-or-later
"""Volume node trees made at random, on meshes and files: whatever artists wire together is exported and
rendered without a crash, a sample that is no number or an extinction above its bound. What has no bound is
refused in one sentence that names the object.

Every tree comes from a seed of its own; a failure names it.
"""

import random
import sys
from dataclasses import replace
from pathlib import Path

import pytest
from nephele import parameters
from nephele.bridge import create_renderer
from truth import box

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from blend_scenes.nodes import ShaderNodes  # noqa: E402  the project's root is on the path only now

PHASES = {
    "HENYEY_GREENSTEIN": ("Anisotropy",),
    "RAYLEIGH": (),
    "DRAINE": ("Anisotropy", "Alpha"),
    "FOURNIER_FORAND": ("IOR", "Backscatter"),
    "MIE": ("Diameter",),
}
UNARY = ("SQRT", "INVERSE_SQRT", "ABSOLUTE", "EXPONENT", "SIGN", "ROUND", "FLOOR", "FRACT", "SINE", "COSINE",
         "TANGENT", "ARCSINE", "ARCTANGENT", "SINH", "TANH", "RADIANS")  # fmt: skip
BINARY = ("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "POWER", "LOGARITHM", "MINIMUM", "MAXIMUM", "LESS_THAN",
          "GREATER_THAN", "MODULO", "FLOORED_MODULO", "SNAP", "PINGPONG", "ARCTAN2")  # fmt: skip
TERNARY = ("MULTIPLY_ADD", "COMPARE", "SMOOTH_MIN", "SMOOTH_MAX", "WRAP")
VECTOR = ("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "CROSS_PRODUCT", "NORMALIZE", "ABSOLUTE", "MINIMUM",
          "MAXIMUM", "FLOOR", "FRACTION", "MODULO", "SINE")  # fmt: skip
BLENDS = (
    "MIX",
    "DARKEN",
    "MULTIPLY",
    "BURN",
    "SCREEN",
    "DODGE",
    "OVERLAY",
    "DIFFERENCE",
    "DIVIDE",
    "HUE",
    "VALUE",
)
NUMBERS = (0.0, 0.5, 1.0, 3.0, -1.0, 0.01, 20.0, 1e4)
GRIDS = ("density", "heat", "temperature", "color")
COORDINATES = ("Generated", "Object", "Camera", "Window")
NO_BOUND = "its volume shader has no upper bound of its density"


class Wild:
    """Grows a tree. bounded: densities, colours and light end in clamps."""

    def __init__(self, seed, bounded):
        self.any, self.bounded = random.Random(seed), bounded
        self.nodes = ShaderNodes(f"wild {seed}")

    def number(self, depth=3):
        n, pick = self.nodes, self.any
        kind = pick.randrange(4 if depth == 0 else 11)
        if kind == 0:
            return pick.choice(NUMBERS)
        if kind == 1:
            return n.grid(pick.choice(GRIDS))
        if kind == 2:
            return n.axis(self.vector(0), pick.choice("XYZ"))
        if kind == 3:
            info = ("ObjectInfo", "Random"), ("LightPath", "Is Shadow Ray"), ("LayerWeight", "Facing")
            node, output = pick.choice(info)
            return n.node(node, output=output)
        if kind == 4:
            return n.math(pick.choice(UNARY), self.number(depth - 1))
        if kind in (5, 6):
            return n.math(pick.choice(BINARY), self.number(depth - 1), self.number(depth - 1))
        if kind == 7:
            return n.math(pick.choice(TERNARY), *(self.number(depth - 1) for _ in range(3)))
        if kind == 8:
            limits = {name: pick.choice(NUMBERS) for name in ("From_Min", "From_Max", "To_Min", "To_Max")}
            ways = {
                "clamp": pick.random() < 0.5,
                "interpolation_type": pick.choice(("LINEAR", "SMOOTHSTEP", "SMOOTHERSTEP")),
            }
            return n.node("MapRange", ways, Value=self.number(depth - 1), **limits)
        if kind == 9:
            return n.vector(
                pick.choice(("LENGTH", "DOT_PRODUCT")), self.vector(depth - 1), self.vector(0), output=1
            )
        return self.texture(depth)

    def texture(self, depth, output=0):
        n, pick = self.nodes, self.any
        if pick.random() < 0.3:
            kinds = ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL")
            return n.node("TexGradient", {"gradient_type": pick.choice(kinds)}, Vector=self.vector(depth - 1))
        if pick.random() < 0.2:
            return n.node(
                "TexChecker", output=1 - output, Vector=self.vector(depth - 1), Scale=self.number(0)
            )
        settings = {name: self.number(0) for name in ("Scale", "Detail", "Roughness", "Distortion")}
        return n.node("TexNoise", output=output, Vector=self.vector(depth - 1), **settings)

    def vector(self, depth=2):
        n, pick = self.nodes, self.any
        kind = pick.randrange(2 if depth == 0 else 6)
        if kind == 0:
            return n.coordinate(pick.choice(COORDINATES))
        if kind == 1:
            return n.node("NewGeometry", output=pick.choice(("Position", "Incoming", "Normal")))
        if kind in (2, 3):
            return n.vector(pick.choice(VECTOR), self.vector(depth - 1), self.vector(depth - 1))
        if kind == 4:
            turn = [tuple(pick.uniform(-2, 2) for _ in range(3)) for _ in range(3)]
            return n.node("Mapping", {}, (self.vector(depth - 1), *turn))
        return n.node("CombineXYZ", {}, [self.number(depth - 1) for _ in range(3)])

    def color(self, depth=2):
        n, pick = self.nodes, self.any
        kind = pick.randrange(2 if depth == 0 else 9)
        if kind == 0:
            return tuple(pick.choice((0.0, 0.2, 0.9, 1.0, 2.0)) for _ in range(3))
        if kind == 1:
            return n.grid(pick.choice(GRIDS), "Color")
        if kind == 2:
            stops = [(k / 3, tuple(pick.random() for _ in range(3))) for k in range(pick.randrange(2, 5))]
            return n.ramp(self.number(depth - 1), *stops)
        if kind == 3:
            return self.vector(depth - 1)
        if kind == 4:
            kinds = {"data_type": "RGBA", "blend_type": pick.choice(BLENDS)}
            socket = n.node("Mix", kinds, output=2)
            for k, value in (
                (0, self.number(depth - 1)),
                (6, self.color(depth - 1)),
                (7, self.color(depth - 1)),
            ):
                n.connect(socket.node, k, value)
            return socket
        if kind == 5:
            values = {name: self.number(0) for name in ("Hue", "Saturation", "Value")}
            return n.node("HueSaturation", Color=self.color(depth - 1), **values)
        if kind == 6:
            return n.node("Blackbody", Temperature=self.number(depth - 1))
        if kind == 7:
            return n.node(pick.choice(("Gamma", "Invert", "RGBCurve")), Color=self.color(depth - 1))
        return self.texture(depth, 1)

    def amount(self, most=30.0):
        value = self.number()
        return self.nodes.node("Clamp", Value=value, Max=most) if self.bounded else value

    def tint(self):
        value = self.color()
        if not self.bounded:
            return value
        low = self.nodes.vector("MAXIMUM", value, (0.0,) * 3)
        return self.nodes.vector("MINIMUM", low, (1.0,) * 3)

    def shader(self, depth=2):
        n, pick = self.nodes, self.any
        kind = pick.randrange(5 if depth == 0 else 8)
        phase = pick.choice(list(PHASES))
        if kind == 0:
            tints = {name: self.tint() for name in ("Color", "Absorption_Color", "Emission_Color")}
            limits = {"Density": 30.0, "Emission_Strength": 5.0, "Blackbody_Intensity": 1.0}
            amounts = {name: self.amount(most) for name, most in (limits | {"Temperature": 4e3}).items()}
            grids = {"Color": pick.choice(("", "color", "density")), "Temperature": pick.choice(("", "heat"))}
            names = {f"{name}_Attribute": grid for name, grid in grids.items()}
            return n.node("VolumePrincipled", Anisotropy=self.number(1), **tints, **amounts, **names)
        if kind == 1:
            inputs = {name: self.number(1) for name in PHASES[phase]}
            return n.node(
                "VolumeScatter", {"phase": phase}, Color=self.tint(), Density=self.amount(), **inputs
            )
        if kind == 2:
            return n.node("VolumeAbsorption", Color=self.tint(), Density=self.amount())
        if kind == 3:
            return n.node("Emission", Color=self.tint(), Strength=self.amount(5.0))
        if kind == 4:
            names = ("Scatter", "Absorption", "Emission")
            inputs = {f"{name}_Coefficients": self.tint() for name in names}
            inputs |= {name: self.number(1) for name in PHASES[phase]}
            return n.node("VolumeCoefficients", {"phase": phase}, **inputs)
        if kind in (5, 6):
            return n.mix(self.number(), self.shader(depth - 1), self.shader(depth - 1))
        return n.add(self.shader(depth - 1), self.shader(depth - 1))


@pytest.fixture
def body(bpy, link):
    """Returns a function (kind, material) that puts a volume there: a mesh, a file or the world."""

    def make(kind, material):
        if kind == "mesh":
            mesh, shape = bpy.data.meshes.new("Body"), box((-0.6, -0.5, -0.6), (0.6, 0.5, 0.4))
            mesh.from_pydata(shape.positions.tolist(), [], shape.triangles.tolist())
            mesh.materials.append(material)
            item = link("Body", mesh)
        else:
            data = bpy.data.volumes.new("Body")
            data.filepath = str(ROOT / "blend_scenes" / "media" / "media.vdb")
            data.materials.append(material)
            item = link("Body", data)
        item.rotation_euler, item.scale = (0.3, 0.5, 0.2), (1.2, 0.8, 1.0)

    return make


def choose(pick, name):
    (setting,) = (p for p in parameters.PARAMETERS if p.name == name)
    return pick.choice([item[0] for item in setting.items])


@pytest.mark.parametrize("bounded", [True, False], ids=["bounded", "wild"])
@pytest.mark.parametrize("seed", range(100))
def test_random_trees_render(seed, bounded, bpy, body, link, export):
    pick = random.Random(seed)
    kind = pick.choice(("mesh", "file"))
    wild = Wild(seed, bounded)
    body(kind, wild.nodes.finish(wild.shader()))
    lamp = bpy.data.lights.new("Lamp", "POINT")
    lamp.energy = 50.0
    link("Lamp", lamp).location = (1, -1, 2)
    scene = export()
    settings = {
        name: choose(pick, name) for name in ("tracking", "transmittance", "majorant", "interpolation")
    }
    film = replace(scene.film, width=8, height=8)
    small = {"samples": 2, "max_bounces": 4, "threads": 1, "time_limit": 20.0}
    scene = replace(scene, film=film, settings=scene.settings | settings | small)
    if not bounded:  # a bound may be too large to render in a lifetime, but there is one or a sentence
        try:
            create_renderer(scene)
        except ValueError as refused:
            assert NO_BOUND in str(refused) and "'Body'" in str(refused) and "\n" not in str(refused)
        return
    renderer = create_renderer(scene)
    renderer.start()
    assert renderer.wait(60)
    statistics = renderer.statistics()
    assert (statistics["nonfinite_samples"], statistics["bound_violations"]) == (0, 0)
