# SPDX-License-Identifier: GPL-3.0-or-later
"""Cases of node_cases.py: procedural textures."""

CASES = {}


def texture(name, kind, output, inputs=(), **properties):
    """Adds the case of a texture at the tile's point."""

    def case(tile):
        node = tile.node(kind, inputs, **properties)
        hashed = kind == "TexWhiteNoise"  # of the coordinates' very bits
        enabled = {s.identifier for s in node.inputs if s.enabled}
        if "Vector" in enabled:
            tile.tree.links.new(tile.lattice if hashed else tile.point, node.inputs["Vector"])
        if "W" in enabled:
            number = tile.out("SeparateXYZ", 1, {0: tile.lattice}) if hashed else tile.number
            tile.tree.links.new(number, node.inputs["W"])
        return next(s for s in node.outputs if s.identifier == output)

    CASES[name] = case


for dimensions in ("1D", "2D", "3D", "4D"):
    shape = {"noise_dimensions": dimensions}
    for kind in ("FBM", "MULTIFRACTAL", "HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN"):
        fractal = {
            "Scale": 1.7,
            "Detail": 2.4,
            "Roughness": 0.6,
            "Lacunarity": 2.1,
            "Offset": 0.4,
            "Gain": 1.3,
        }
        texture(f"noise {kind} {dimensions}", "TexNoise", "Fac", fractal, noise_type=kind, **shape)
    bent = {"Scale": 2.3, "Distortion": 0.8, "Detail": 1.0}
    texture(f"noise color {dimensions}", "TexNoise", "Color", bent, normalize=False, **shape)
    for output in ("Value", "Color"):
        name = f"white noise {output} {dimensions}"
        texture(name, "TexWhiteNoise", output, noise_dimensions=dimensions)
    for feature in ("F1", "F2", "SMOOTH_F1", "DISTANCE_TO_EDGE", "N_SPHERE_RADIUS"):
        output = "Radius" if feature == "N_SPHERE_RADIUS" else "Distance"
        cells = {"Scale": 1.9, "Randomness": 0.9, "Smoothness": 0.7}
        settings = {"feature": feature, "voronoi_dimensions": dimensions}
        texture(f"voronoi {feature} {dimensions}", "TexVoronoi", output, cells, **settings)
        if feature == "N_SPHERE_RADIUS":
            continue
        fractal = cells | {"Detail": 1.6, "Roughness": 0.7, "Lacunarity": 2.2}
        texture(
            f"voronoi {feature} {dimensions} fractal",
            "TexVoronoi",
            output,
            fractal,
            normalize=True,
            **settings,
        )
        if feature == "DISTANCE_TO_EDGE":
            continue
        for output in ("Color", "W" if dimensions == "1D" else "Position"):
            texture(f"voronoi {feature} {dimensions} {output}", "TexVoronoi", output, cells, **settings)
        texture(f"voronoi {feature} {dimensions} fractal Color", "TexVoronoi", "Color", fractal, **settings)

texture("voronoi W 4D", "TexVoronoi", "W", {"Scale": 1.9}, voronoi_dimensions="4D")
for metric in ("MANHATTAN", "CHEBYCHEV", "MINKOWSKI"):
    for feature in ("F1", "F2", "SMOOTH_F1"):
        settings = {"feature": feature, "distance": metric, "normalize": True}
        texture(
            f"voronoi {feature} {metric}",
            "TexVoronoi",
            "Distance",
            {"Scale": 1.9, "Exponent": 1.4},
            **settings,
        )

for profile in ("SIN", "SAW", "TRI"):
    for direction in ("X", "Y", "Z", "DIAGONAL"):
        settings = {"wave_profile": profile, "bands_direction": direction}
        texture(
            f"wave bands {profile} {direction}",
            "TexWave",
            "Fac",
            {"Scale": 0.3, "Phase Offset": 0.7},
            **settings,
        )
for direction in ("X", "Y", "Z", "SPHERICAL"):
    settings = {"wave_type": "RINGS", "rings_direction": direction}
    bent = {"Scale": 0.3, "Distortion": 1.5, "Detail": 1.4, "Detail Scale": 1.3, "Detail Roughness": 0.4}
    texture(f"wave rings {direction}", "TexWave", "Color", bent, **settings)
for depth in (0, 1, 2, 5, 10):
    texture(f"magic {depth}", "TexMagic", "Color", {"Scale": 0.7, "Distortion": 1.3}, turbulence_depth=depth)
texture("magic fac", "TexMagic", "Fac", {"Scale": 1.4, "Distortion": 0.0}, turbulence_depth=2)
for kind in ("LINEAR", "QUADRATIC", "EASING", "DIAGONAL", "SPHERICAL", "QUADRATIC_SPHERE", "RADIAL"):
    texture(f"gradient {kind}", "TexGradient", "Fac", gradient_type=kind)
texture(
    "checker",
    "TexChecker",
    "Color",
    {"Scale": 1.7, "Color1": (0.9, 0.1, 0.2, 1), "Color2": (0.1, 0.3, 0.8, 1)},
)
texture("checker fac", "TexChecker", "Fac", {"Scale": 2.3})
wall = {
    "Color1": (0.9, 0.1, 0.2, 1),
    "Color2": (0.1, 0.3, 0.8, 1),
    "Mortar": (0.3, 0.9, 0.4, 1),
    "Scale": 1.6,
}
texture("brick", "TexBrick", "Color", wall | {"Mortar Size": 0.06, "Mortar Smooth": 0.6, "Bias": 0.1})
texture("brick fac", "TexBrick", "Fac", {"Mortar Size": 0.05, "Mortar Smooth": 0.0, "Scale": 1.1})
texture(
    "brick shape", "TexBrick", "Color", wall, offset=0.3, offset_frequency=3, squash=0.7, squash_frequency=2
)
for kind in ("2D", "3D"):
    for output in ("Value", "Phase", "Intensity"):
        waves = {
            "Scale": 1.2,
            "Frequency": 1.7,
            "Anisotropy": 0.6,
            "Orientation 2D": 0.4,
            "Orientation 3D": (1, 0.5, -0.4),
        }
        texture(f"gabor {kind} {output}", "TexGabor", output, waves, gabor_type=kind)
