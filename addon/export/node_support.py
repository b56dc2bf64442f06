# SPDX-License-Identifier: GPL-3.0-or-later
"""What becomes of every shader node of Blender 5.0: docs/nodes.md is made of this table
(tools/generate_node_page.py). Knows neither bpy nor the compiler; tests hold it against both."""

from dataclasses import dataclass

SUPPORTED, APPROXIMATED, UNSUPPORTED = "supported", "approximated", "not supported"


@dataclass(frozen=True)
class Node:
    """label: as Blender shows it. note: how it is approximated, why it is not supported, or a restriction."""

    label: str
    state: str = SUPPORTED
    note: str = ""


def approximated(label, how):
    return Node(label, APPROXIMATED, how)


def unsupported(label, why):
    return Node(label, UNSUPPORTED, why)


IN_VOLUMES = "In volumes only."
STRANDS = "Random: other numbers than Cycles'. The tangent normal is the normal."

# Group of nodes -> identifier (bl_idname without "ShaderNode") -> Node.
NODES = {
    "Inputs": {
        "AmbientOcclusion": approximated("Ambient Occlusion", "Nothing counts as occluded."),
        "Attribute": Node(
            "Attribute", note="Of the mesh, a volume's grids, the object, its instancer or the view layer."
        ),
        "Bevel": approximated("Bevel", "The normal stays as it is."),
        "CameraData": Node("Camera Data"),
        "Fresnel": Node("Fresnel"),
        "HairInfo": approximated("Curves Info", STRANDS),
        "LayerWeight": Node("Layer Weight"),
        "LightPath": Node(
            "Light Path", note="In volumes the kind of ray only. There are no portals: their depth is 0."
        ),
        "NewGeometry": Node("Geometry", note="Random Per Island: other numbers than Cycles'."),
        "ObjectInfo": Node("Object Info"),
        "ParticleInfo": Node("Particle Info"),
        "PointInfo": Node("Point Info", note="Random: other numbers than Cycles'."),
        "RGB": Node("Color"),
        "Tangent": Node("Tangent"),
        "TexCoord": Node("Texture Coordinate"),
        "UVAlongStroke": unsupported("UV Along Stroke", "Freestyle only."),
        "UVMap": Node("UV Map"),
        "Value": Node("Value"),
        "VertexColor": Node("Color Attribute"),
        "VolumeInfo": Node("Volume Info", note=IN_VOLUMES),
        "Wireframe": Node("Wireframe"),
    },
    "Textures": {
        "TexBrick": Node("Brick Texture"),
        "TexChecker": Node("Checker Texture"),
        "TexEnvironment": Node("Environment Texture"),
        "TexGabor": Node("Gabor Texture"),
        "TexGradient": Node("Gradient Texture"),
        "TexIES": Node("IES Texture", note="On lamps."),
        "TexImage": Node("Image Texture", note="Of movies only the frame that Blender holds."),
        "TexMagic": Node("Magic Texture"),
        "TexNoise": Node("Noise Texture"),
        "TexSky": approximated(
            "Sky Texture",
            "A picture that Cycles makes when rendering starts; its sun is a lamp, unseen by the camera.",
        ),
        "TexVoronoi": Node("Voronoi Texture"),
        "TexWave": Node("Wave Texture"),
        "TexWhiteNoise": Node("White Noise Texture"),
    },
    "Colours": {
        "Blackbody": Node("Blackbody"),
        "BrightContrast": Node("Brightness/Contrast"),
        "CombineColor": Node("Combine Color"),
        "Gamma": Node("Gamma"),
        "HueSaturation": Node("Hue/Saturation/Value"),
        "Invert": Node("Invert Color"),
        "LightFalloff": Node("Light Falloff", note="On surfaces and lamps."),
        "Mix": Node("Mix"),
        "MixRGB": Node("Mix (Legacy)"),
        "RGBCurve": Node("RGB Curves"),
        "RGBToBW": Node("RGB to BW"),
        "SeparateColor": Node("Separate Color"),
        "ValToRGB": Node("Color Ramp"),
        "Wavelength": Node("Wavelength"),
    },
    "Vectors": {
        "Bump": Node("Bump", note="On surfaces."),
        "Displacement": approximated("Displacement", "True displacement is rendered as bump."),
        "Mapping": Node("Mapping"),
        "Normal": Node("Normal"),
        "NormalMap": Node("Normal Map"),
        "VectorCurve": Node("Vector Curves"),
        "VectorDisplacement": approximated("Vector Displacement", "Rendered as bump."),
        "VectorRotate": Node("Vector Rotate"),
        "VectorTransform": Node("Vector Transform"),
    },
    "Arithmetic": {
        "Clamp": Node("Clamp"),
        "CombineXYZ": Node("Combine XYZ"),
        "FloatCurve": Node("Float Curve"),
        "MapRange": Node("Map Range"),
        "Math": Node("Math"),
        "RadialTiling": unsupported("Radial Tiling", "Not written yet."),
        "SeparateXYZ": Node("Separate XYZ"),
        "Squeeze": unsupported("Squeeze Value (Legacy)", "Cycles does not know it either."),
        "VectorMath": Node("Vector Math"),
    },
    "Shaders": {
        "AddShader": Node("Add Shader"),
        "Background": Node("Background"),
        "BsdfAnisotropic": Node("Glossy BSDF", note="Ashikhmin-Shirley's distribution is taken for GGX."),
        "BsdfDiffuse": Node("Diffuse BSDF"),
        "BsdfGlass": Node("Glass BSDF"),
        "BsdfHair": unsupported("Hair BSDF", "Use a BSDF of surfaces: hair is rendered as tubes."),
        "BsdfHairPrincipled": unsupported(
            "Principled Hair BSDF", "Use a BSDF of surfaces: hair is rendered as tubes."
        ),
        "BsdfMetallic": Node("Metallic BSDF"),
        "BsdfPrincipled": Node(
            "Principled BSDF", note="Christensen-Burley's subsurface scattering is a random walk."
        ),
        "BsdfRayPortal": unsupported("Ray Portal BSDF", "Rays do not jump."),
        "BsdfRefraction": Node("Refraction BSDF"),
        "BsdfSheen": Node("Sheen BSDF"),
        "BsdfToon": Node("Toon BSDF"),
        "BsdfTranslucent": Node("Translucent BSDF"),
        "BsdfTransparent": Node("Transparent BSDF"),
        "EeveeSpecular": unsupported("Specular BSDF", "EEVEE only."),
        "Emission": Node("Emission"),
        "Holdout": Node("Holdout", note="A hole where the film is transparent, else black."),
        "MixShader": Node("Mix Shader"),
        "ShaderToRGB": unsupported("Shader to RGB", "EEVEE only."),
        "SubsurfaceScattering": Node("Subsurface Scattering", note="Christensen-Burley's is a random walk."),
        "VolumeAbsorption": Node("Volume Absorption"),
        "VolumeCoefficients": Node("Volume Coefficients"),
        "VolumePrincipled": Node("Principled Volume"),
        "VolumeScatter": Node("Volume Scatter"),
    },
    "Outputs and structure": {
        "Group": Node("Group", note="Nested to any depth."),
        "OutputAOV": unsupported("AOV Output", "There are no passes of shaders' making."),
        "OutputLight": Node("Light Output", note="Of shaders Emission alone counts."),
        "OutputLineStyle": unsupported("Line Style Output", "Freestyle only."),
        "OutputMaterial": Node("Material Output"),
        "OutputWorld": Node("World Output"),
        "Script": unsupported("Script", "Open Shading Language is not run."),
    },
}


def page():
    """Returns docs/nodes.md."""
    counts = dict.fromkeys((SUPPORTED, APPROXIMATED, UNSUPPORTED), 0)
    for nodes in NODES.values():
        for node in nodes.values():
            counts[node.state] += 1
    lines = [
        "# Shader nodes",
        "",
        "What becomes of the shader nodes of Blender 5.0: "
        + ", ".join(f"{count} are {state}" for state, count in counts.items())
        + ". What is not supported, or approximated, says so by name when a scene is rendered; an input"
        " that it feeds keeps its own value.",
        "",
        "Made from `addon/export/node_support.py` by `tools/generate_node_page.py`; edit that table instead.",
    ]
    for group, nodes in NODES.items():
        lines += ["", f"## {group}", "", "| Node | State | |", "|---|---|---|"]
        lines += [f"| {node.label} | {node.state} | {node.note} |" for node in nodes.values()]
    return "\n".join(lines) + "\n"
