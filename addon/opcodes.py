# SPDX-License-Identifier: GPL-3.0-or-later
"""Operations of shading programs and kinds of closures, declared once.

A shading program is what the exporter makes of a Blender node tree: straight-line code over registers of
three floats, run per shading point by `native/shading/program.h`. A scalar fills all three channels.
The native enums are generated from these tables by `tools/generate_tables.py`. Knows neither bpy nor native.

An instruction is a row of 8 int32: (op, destination, a, b, c, d, parameter, mode). a to d are registers;
`parameter` is an offset into the program's float parameters; `mode` an integer whose meaning the op states.
"""

# name: (what it writes to the destination register)
OPCODES = {
    # -- inputs of the shading point
    "uv": "UV map number `mode` of the mesh, (u, v, 0); (0, 0, 0) where absent",
    "generated": "position in the object's bounding box, [0,1]^3 on the undeformed box; directions for the world",
    "object_coordinate": "position in object space; direction for the world",
    "camera_coordinate": "position in camera space, z forward",
    "window_coordinate": "(x, y, 0) in the image, [0,1]^2",
    "position": "position in world space",
    "normal": "shading normal in world space, on wo's side",
    "normal_object": "shading normal in object space",
    "geometric_normal": "face normal in world space, on wo's side",
    "incoming": "wo: unit direction towards the viewer, world space",
    "reflection": "wo mirrored at the shading normal, negated as Blender's Reflection coordinate",
    "backfacing": "1 when the face is seen from behind",
    "ray_is": "1 when the ray's kind has a bit of `mode` (see RAY_KINDS)",
    "object_location": "object's origin in world space",
    "object_color": "object's viewport colour",
    "object_random": "random number in [0,1] of the instance",
    "object_index": "object's pass index",
    "object_alpha": "alpha of the object's viewport colour",
    "object_attribute": "property number `mode` of the object, RGB; (0, 0, 0) where absent",
    "object_attribute_alpha": "property number `mode` of the object, alpha",
    "ray_history": "what led the ray here; mode: index into RAY_HISTORY",
    "parametric": "barycentric coordinates of the first two corners of the triangle, (u, v, 0)",
    "uv_tangent": "unit direction in which u of UV map number `mode` grows, world space; (0, 0, 0) where absent",
    "attribute": "mesh attribute number `mode`, RGB",
    "attribute_alpha": "mesh attribute number `mode`, alpha",
    # -- textures
    "image": "image number parameters[0] at a.xy; RGB. mode: bits 0-1 0 linear 1 closest 2 cubic, "
    "bits 2-3 extension 0 repeat 1 extend 2 clip 3 mirror",
    "image_alpha": "as image; the alpha channel",
    "environment": "image number parameters[0] seen in direction a, equirectangular; RGB",
    "environment_mirror_ball": "image number parameters[0] seen in direction a, mirror ball; RGB",
    "sphere_projection": "image coordinates of point a seen from the middle of the unit cube, by longitude and latitude",
    "tube_projection": "image coordinates of point a by longitude and height",
    "checker": "b where the checker of point a, scale d.x, is odd, else c",
    "checker_fac": "1 where the checker of point a, scale d.x, is odd, else 0",
    "grid": "volumes: grid number `mode` of the closure at point a, world space; a scalar grid fills all channels; 0 elsewhere",
    "noise": "Perlin fractal at point a, w b.y, both scaled by b.x; offset b.z; c = (detail, roughness, lacunarity); "
    "d = (distortion, gain); mode: bit 0 colour, bit 1 normalize, bits 2-3 dimensions 0 3D 1 2D 2 1D 3 4D, "
    "bits 4-6 index into NOISE_TYPES",
    "voronoi": "cells at point a, w b.y, both scaled by b.x; exponent b.z; c = (detail, roughness, lacunarity); "
    "d = (smoothness, randomness); mode: bits 0-1 output 0 distance or radius 1 colour 2 position 3 w, bits 2-3 "
    "dimensions as of noise, bits 4-5 index into VORONOI_METRICS, bit 6 normalize, bits 7-9 index into VORONOI_FEATURES",
    "white_noise": "hash of point a, w b.x; mode: bit 0 colour, bits 1-2 dimensions as of noise",
    "gabor": "Gabor noise at point a; b = (frequency, anisotropy, orientation in 2D); c orientation in 3D; "
    "mode: bits 0-1 output 0 value 1 phase 2 intensity, bit 2 3D",
    "brick": "(share of the second colour, mortar, 0) at point a; b = (mortar size, smoothness, bias); "
    "c = (brick width, row height); parameters offset, squash, and every how many rows each",
    "gradient": "gradient of point a; mode 0 linear 1 quadratic 2 easing 3 diagonal 4 spherical 5 quadratic sphere 6 radial",
    "ramp": "table of 3 x 257 RGB (mode entries minus one) at parameter, interpolated linearly at a.x in [0,1]",
    "ramp_alpha": "as ramp for a table of scalars",
    # -- arithmetic, each channel by itself
    "copy": "a",
    "add": "a + b",
    "subtract": "a - b",
    "multiply": "a * b",
    "divide": "a / b, 0 where b is 0",
    "multiply_add": "a * b + c",
    "power": "a ^ b, 0 where undefined",
    "logarithm": "log a to base b, 0 where undefined",
    "sqrt": "square root of max(a, 0)",
    "inverse_sqrt": "1 / sqrt(a), 0 where undefined",
    "absolute": "|a|",
    "exponent": "e ^ a",
    "minimum": "min(a, b)",
    "maximum": "max(a, b)",
    "less_than": "1 where a < b",
    "greater_than": "1 where a > b",
    "sign": "sign of a",
    "compare": "1 where |a - b| <= max(c, 1e-5)",
    "smooth_min": "polynomial smooth minimum of a and b with distance c",
    "smooth_max": "polynomial smooth maximum of a and b with distance c",
    "round": "floor(a + 0.5)",
    "floor": "largest integer <= a",
    "ceil": "smallest integer >= a",
    "truncate": "a without its fraction",
    "fraction": "a - floor(a)",
    "modulo": "truncated remainder of a / b, 0 where b is 0",
    "floored_modulo": "a - floor(a / b) * b, 0 where b is 0",
    "wrap": "a wrapped into [c, b)",
    "snap": "floor(a / b) * b, 0 where b is 0",
    "pingpong": "a bounced between 0 and b",
    "sine": "sin a",
    "cosine": "cos a",
    "tangent": "tan a",
    "arcsine": "asin a, argument clamped",
    "arccosine": "acos a, argument clamped",
    "arctangent": "atan a",
    "arctan2": "atan2(a, b)",
    "sinh": "sinh a",
    "cosh": "cosh a",
    "tanh": "tanh a",
    "clamp": "a clamped to [b, c]",
    "mix": "a + (b - a) * c",
    "map_range": "a from [b.x, b.y] to [c.x, c.y], unclamped; mode 0 linear 1 smoothstep 2 smootherstep",
    # -- blend modes of Mix Color: fac in c
    "blend": "a blended with b by c; mode: index into BLEND_MODES",
    # -- vectors and colours
    "dot": "a . b",
    "cross": "a x b",
    "length": "|a|",
    "normalize": "a / |a|, 0 where a is 0",
    "distance": "|a - b|",
    "transform": "3x4 row-major matrix at parameter applied to point a; mode 1: to vector (no translation)",
    "channel": "channel `mode` of a",
    "combine": "(a.x, b.x, c.x)",
    "average": "mean of a's channels (vector to value)",
    "luminance": "Rec. 709 luminance of a (colour to value)",
    "rgb_to_hsv": "HSV of a",
    "hsv_to_rgb": "RGB of a",
    "rgb_to_hsl": "HSL of a",
    "hsl_to_rgb": "RGB of a",
    "hue_saturation": "a with hue b.x, saturation b.y, value b.z, by factor c.x",
    "bright_contrast": "a with brightness b.x and contrast c.x",
    "gamma": "a ^ b.x where a > 0",
    "invert": "a mixed with 1 - a by b.x",
    "blackbody": "Rec. 709 colour of a blackbody at a.x kelvin, luminance 1",
    "fresnel": "dielectric Fresnel reflectance for ior a.x at normal b",
    "layer_weight": "mode 0 Fresnel, 1 facing; blend a.x, normal b",
    "convert_space": "a from one space to another; mode: bits 0-1 from, bits 2-3 to 0 world 1 object 2 camera, "
    "bits 4-5 0 point 1 vector 2 normal",
    "box_projection": "(u, v, weight) of an image on the faces of a cube across axis `mode` at point a with normal b, "
    "both in object space; the parameter blends faces",
    "bump": "normal c bent by the heights a = (here, one pixel along x, along y); b = (strength, distance, width of "
    "the step in pixels)",
    "wireframe": "1 within half of a.x of an edge of the triangle; mode 1: a.x counts pixels",
    "normal_map": "tangent-space colour a, strength b.x, UV map number `mode`; world normal",
}

NOISE_TYPES = ("fbm", "multifractal", "hybrid_multifractal", "ridged_multifractal", "hetero_terrain")
VORONOI_FEATURES = ("f1", "f2", "smooth_f1", "distance_to_edge", "n_sphere_radius")
VORONOI_METRICS = ("euclidean", "manhattan", "chebychev", "minkowski")

BLEND_MODES = (
    "mix", "darken", "multiply", "burn", "lighten", "screen", "dodge", "add", "overlay", "soft_light",
    "linear_light", "difference", "exclusion", "subtract", "divide", "hue", "saturation", "color", "value",
)  # fmt: skip

# Closures and the registers they read, in order. Every closure also has a weight register. All but the last
# are of surfaces and lights; "medium" is that of a volume (1/m, 1/m, W/(m^3 sr); the phase function's kind is
# its mode and its parameters are the last two). "plastic" is no node of Blender's: it is Mitsuba's (smooth, or
# with `roughness`), whose light that is caught below the coat takes up more colour where `nonlinear` is 1.
CLOSURES = {
    "diffuse": ("color", "roughness", "normal"),
    "glossy": ("color", "roughness", "normal"),
    "glass": ("color", "roughness", "ior", "normal"),
    "refraction": ("color", "roughness", "ior", "normal"),
    "translucent": ("color", "normal"),
    "transparent": ("color",),
    "emission": ("color", "strength"),
    "principled": (
        "base_color", "metallic", "roughness", "ior", "alpha", "normal", "specular_ior_level", "specular_tint",
        "transmission_weight", "coat_weight", "coat_roughness", "coat_ior", "coat_tint", "coat_normal",
        "sheen_weight", "sheen_roughness", "sheen_tint", "emission_color", "emission_strength",
        "diffuse_roughness", "anisotropic", "anisotropic_rotation", "tangent",
        "subsurface_weight", "subsurface_radius", "subsurface_scale", "subsurface_ior", "subsurface_anisotropy",
        "thin_film_thickness", "thin_film_ior",
    ),
    "brushed": ("color", "roughness", "anisotropy", "rotation", "normal", "tangent"),
    "metal": (
        "base_color", "edge_tint", "roughness", "anisotropy", "rotation", "normal", "tangent",
        "thin_film_thickness", "thin_film_ior",
    ),
    "conductor": (
        "ior", "extinction", "roughness", "anisotropy", "rotation", "normal", "tangent",
        "thin_film_thickness", "thin_film_ior",
    ),
    "filmed_glass": ("color", "roughness", "ior", "normal", "thin_film_thickness", "thin_film_ior"),
    "sheen": ("color", "roughness", "normal"),
    "velvet": ("color", "roughness", "normal"),
    "toon_diffuse": ("color", "size", "smooth", "normal"),
    "toon_glossy": ("color", "size", "smooth", "normal"),
    "holdout": (),
    "subsurface": ("color", "scale", "radius", "ior", "roughness", "anisotropy", "normal"),
    "plastic": ("color", "roughness", "ior", "nonlinear", "normal"),
    "medium": ("sigma_s", "sigma_a", "emission", "phase_a", "phase_b"),
}  # fmt: skip

# What "ray_history" tells, by mode: length since the last bounce in metres, numbers of bounces, and whether the last
# one was off a perfectly sharp lobe.
RAY_HISTORY = ("length", "depth", "diffuse", "glossy", "transmission", "transparent", "singular")

# Spaces of "convert_space".
SPACES = ("world", "object", "camera")

# Inputs that vary over a surface: their mode counts from SHIFT on where they are read a step beside the point, for
# bump: once SHIFT along the tangent plane's x, twice along its y. The step is the parameter, in pixels.
SHIFTABLE = {
    "uv", "generated", "object_coordinate", "camera_coordinate", "window_coordinate", "position", "attribute",
    "attribute_alpha", "parametric",
}  # fmt: skip
SHIFT = 1 << 16

# Operations that read more than their operands and the point, by what: images by the number parameters[0]; UV maps,
# mesh attributes and objects' properties by the number in the mode; and the camera, as all shifted ones do, too.
READS = {
    "image": ("image", "image_alpha", "environment", "environment_mirror_ball"),
    "uv": ("uv", "uv_tangent", "normal_map"),
    "attribute": ("attribute", "attribute_alpha"),
    "property": ("object_attribute", "object_attribute_alpha"),
    "camera": ("camera_coordinate", "window_coordinate", "convert_space", "bump", "wireframe"),
}

# Bits of a ray's kind, as "ray_is" tests them and as visibility masks count them.
RAY_KINDS = ("camera", "diffuse", "glossy", "transmission", "volume", "shadow")

# Microfacet distribution variants of the closures with microfacets: the closure row's mode.
DISTRIBUTIONS = ("ggx", "multi_ggx", "beckmann")

# How light enters what scatters below a surface, and what the radius means: the mode of subsurface; principled adds
# the index times the number of distributions to its own.
SUBSURFACE_METHODS = ("burley", "random_walk", "random_walk_skin")

# Phase functions and what their parameters a and b mean: a closure's mode is the index.
PHASES = {
    "henyey_greenstein": ("g",),
    "rayleigh": (),
    "draine": ("g", "alpha"),
    "fournier_forand": ("ior", "backscatter"),
    "mie": ("diameter",),  # of water droplets, micrometres
}
