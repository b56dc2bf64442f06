# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene description: everything a render needs, as plain dataclasses of numbers and numpy arrays.

`export/` writes it from Blender, `bridge.py` reads it into the native module, `description_file.py` saves and
loads it. It knows neither bpy nor the native module. World space is Blender's (right-handed, z up), lengths
in metres (Blender units), colours scene-linear Rec. 709. Matrices are 4x4 float64, column vectors:
p_to = M @ p_from, named `to_from_from`. Images and films have their first row at the bottom, as in Blender.
"""

from dataclasses import dataclass, field, fields, is_dataclass

import numpy as np

Array = np.ndarray
ALL_RAYS = 0b111111  # every bit of opcodes.RAY_KINDS
ALL_SETS = (1 << 64) - 1  # every set of receivers or blockers, see Light


@dataclass(frozen=True)
class Image:
    """A texture. pixels: (height, width, 4) uint8 (sRGB-encoded or not, see `srgb`) or float32 (linear)."""

    name: str
    pixels: Array
    srgb: bool = False


@dataclass(frozen=True)
class Closure:
    """A closure of a shading program. kind: a key of opcodes.CLOSURES. weight, inputs: register numbers;
    input -1 means "not connected" (only for normals: use the shading normal). mode: distribution index for
    microfacets."""

    kind: str
    weight: int
    inputs: tuple
    mode: int = 0


@dataclass(frozen=True)
class Program:
    """A shading program (see opcodes.py). registers: (R, 3) float32 initial values, R <= 256, constants
    among them. code: (N, 8) int32. parameters: (P,) float32."""

    registers: Array = field(default_factory=lambda: np.ones((1, 3), np.float32))
    code: Array = field(default_factory=lambda: np.zeros((0, 8), np.int32))
    parameters: Array = field(default_factory=lambda: np.zeros(0, np.float32))
    closures: tuple = ()


@dataclass(frozen=True)
class Phase:
    """A phase function. kind: a key of opcodes.PHASES, which says what a and b mean."""

    kind: str = "henyey_greenstein"
    a: float = 0.0
    b: float = 0.0


@dataclass(frozen=True)
class VolumeClosure:
    """One volume shader. sigma_s, sigma_a: (3,) 1/m at density 1. emission: (3,) W/(m^3 sr). density_grid:
    name of the grid that multiplies sigma_s and sigma_a, or None for 1 everywhere. emission_grid: the same
    for emission.

    program: for what varies otherwise; run at each point, it has one closure "medium", which replaces all of
    the above. grids: names of the grids that its "grid" operations read, by number."""

    sigma_s: tuple = (0.0, 0.0, 0.0)
    sigma_a: tuple = (0.0, 0.0, 0.0)
    emission: tuple = (0.0, 0.0, 0.0)
    phase: Phase = Phase()
    density_grid: str | None = None
    emission_grid: str | None = None
    program: Program | None = None
    grids: tuple = ()


@dataclass(frozen=True)
class Material:
    """surface: None where the material has no surface shader (a pure volume boundary). volume: closures, ()
    for none. pass_index: of the pass Material Index."""

    name: str
    surface: Program | None = None
    volume: tuple = ()
    pass_index: int = 0


@dataclass(frozen=True)
class Mesh:
    """A triangle mesh in object space. positions (N, 3) float32; triangles (T, 3) int32; corner_normals (T,
    3, 3) float32 or None (flat); uvs: tuple of (T, 3, 2) float32 by number; attributes: tuple of (T, 3, 4)
    float32 by number; material_index (T,) int32 slot, or None for slot 0; generated_min, generated_size: box
    of generated coordinates.

    neighbours: positions (2, N, 3) at the frames before and after this one, for the pass Vector; None where
    it keeps its shape. motion, motion_normals: positions (S, N, 3) and, where there are corner normals,
    corner normals (S, T, 3, 3) at S >= 2 equally spaced times of the shutter; None where it keeps its
    shape."""

    name: str
    positions: Array
    triangles: Array
    corner_normals: Array | None = None
    uvs: tuple = ()
    attributes: tuple = ()
    material_index: Array | None = None
    generated_min: tuple = (-1.0, -1.0, -1.0)
    generated_size: tuple = (2.0, 2.0, 2.0)
    motion: Array | None = None
    motion_normals: Array | None = None
    neighbours: Array | None = None


@dataclass(frozen=True)
class Instance:
    """A mesh placed in the world. mesh: index. materials: material index by slot (at least one; -1 for
    none: a grey diffuse default). visibility: bits of opcodes.RAY_KINDS. random in [0,1]; color RGBA;
    pass_index: object's. asset: name of its topmost parent, "" where that is itself. dielectric_priority:
    where objects with one overlap, only that of the highest is there; 0 takes no part. properties: (N, 4)
    numbers by which shaders read attributes of the object. receiver_set, blocker_set: 0 to 63, see Light.
    receivers, blockers: as of a Light, for what its faces emit. holdout: the camera sees a hole of alpha 0
    where it is. motion: (S, 4, 4) float64, world_from_object at S >= 2 equally spaced times of the shutter;
    None where it stands still. neighbours: (2, 4, 4) float64, world_from_object at the frames before and
    after this one, for the pass Vector; None: the same."""

    name: str
    mesh: int
    world_from_object: Array
    materials: tuple = (-1,)
    visibility: int = ALL_RAYS
    random: float = 0.0
    color: tuple = (1.0, 1.0, 1.0, 1.0)
    pass_index: int = 0
    dielectric_priority: int = 0
    properties: tuple = ()
    receiver_set: int = 0
    blocker_set: int = 0
    receivers: int = ALL_SETS
    blockers: int = ALL_SETS
    holdout: bool = False
    motion: Array | None = None
    asset: str = ""
    neighbours: Array | None = None


@dataclass(frozen=True)
class Volume:
    """A VDB file placed in the world. path: absolute, of this frame. world_from_object: from the file's
    world space (its grids' own transforms applied) to ours. material: index. density_scale: multiplies
    sigma_s, sigma_a and emission (Blender's object-space density). visibility: bits of opcodes.RAY_KINDS.

    clipping: voxels of smaller value count as empty. precision: "full", "half" or "file" (as stored).
    velocity_grids: names of one vector grid or three scalar ones, () for no motion blur; their values times
    velocity_scale are metres of the file's space per frame. generated_min, generated_size: box of generated
    coordinates, file's space. random, color, pass_index, receiver_set, blocker_set, motion: see Instance."""

    name: str
    path: str
    world_from_object: Array
    material: int
    density_scale: float = 1.0
    visibility: int = ALL_RAYS
    clipping: float = 0.0
    precision: str = "file"
    velocity_grids: tuple = ()
    velocity_scale: float = 0.0
    generated_min: tuple = (-1.0, -1.0, -1.0)
    generated_size: tuple = (2.0, 2.0, 2.0)
    random: float = 0.0
    color: tuple = (1.0, 1.0, 1.0, 1.0)
    pass_index: int = 0
    receiver_set: int = 0
    blocker_set: int = 0
    motion: Array | None = None


@dataclass(frozen=True)
class Light:
    """A light without mesh. kind: "point", "sun", "spot" or "area". It shines along its local -z.

    power: (3,) RGB: W for point, spot, area; W/m^2 for sun (at normal incidence). normalize False: power per
    m^2 of the light's area. radius: m (point, spot). angle: full angle of the sun's disc, rad. spot_size:
    full cone angle, rad; spot_blend in [0,1]. shape: "rectangle" or "ellipse"; size: (x, y) m. spread: full
    angle of an area light, rad. visibility: rays that see it when they hit it. cast_shadow False: never
    blocked. max_bounces: paths longer than that do not see it. program: its emission closures scale the
    radiance (None: 1). random: see Instance.

    receivers: bit n says that it shines on objects whose receiver_set is n. blockers: bit n, that objects
    whose blocker_set is n cast its shadows. motion: see Instance; its size is that of the frame."""

    name: str
    kind: str
    world_from_light: Array
    power: tuple
    normalize: bool = True
    radius: float = 0.0
    soft_falloff: bool = False
    angle: float = 0.0
    spot_size: float = 0.785398
    spot_blend: float = 0.15
    shape: str = "rectangle"
    size: tuple = (1.0, 1.0)
    spread: float = 3.14159265
    visibility: int = ALL_RAYS & ~1
    cast_shadow: bool = True
    max_bounces: int = 1024
    program: Program | None = None
    random: float = 0.0
    receivers: int = ALL_SETS
    blockers: int = ALL_SETS
    motion: Array | None = None


@dataclass(frozen=True)
class World:
    """background: program with emission closures, evaluated by direction (None: black). volume: closures
    everywhere."""

    background: Program | None = None
    volume: tuple = ()
    visibility: int = ALL_RAYS


@dataclass(frozen=True)
class Camera:
    """kind: "perspective", "orthographic" or "panoramic". It looks along its local -z, y up. viewplane:
    (left, right, bottom, top) of the full frame at distance 1 (perspective), in metres (orthographic) or in
    the unit square that a panorama fills. clip_start, clip_end: along the view axis, of panoramas along the
    ray. aperture_radius: m, 0 for a pinhole; blades: 0 or >= 3; blades_rotation: rad; aperture_ratio:
    anamorphic. focus_distance: m, along the same. motion, neighbours: see Instance, of
    world_from_camera.

    lens: of a panorama, a name of native/scene/panorama.h, which says what lens_values mean."""

    name: str
    kind: str
    world_from_camera: Array
    viewplane: tuple
    clip_start: float = 0.0
    clip_end: float = 1e30
    aperture_radius: float = 0.0
    blades: int = 0
    blades_rotation: float = 0.0
    aperture_ratio: float = 1.0
    focus_distance: float = 1.0
    lens: str = "equirectangular"
    lens_values: tuple = ()
    motion: Array | None = None
    neighbours: Array | None = None


@dataclass(frozen=True)
class Film:
    """width, height: full frame in pixels. crop: (x0, y0, x1, y1) pixels rendered, x1 and y1 exclusive, row
    0 at the bottom; None for the full frame. transparent: the background counts as alpha 0 and adds nothing.
    passes: names of passes.PASSES. opaque_alpha: surfaces of less are not the first that Depth, Position,
    Normal, UV and the indices tell of. mist: (start, depth, falloff) with falloff "linear", "quadratic" or
    "inverse_quadratic"."""

    width: int
    height: int
    crop: tuple | None = None
    transparent: bool = False
    passes: tuple = ("Combined",)
    mist: tuple = (5.0, 25.0, "quadratic")
    opaque_alpha: float = 0.5


@dataclass(frozen=True)
class Scene:
    """The whole. settings: see parameters.py (missing names take their defaults). warnings: what the
    exporter left out, one sentence each, naming object and node. shutter: times at which it opens and closes,
    in frames from this one; equal without motion blur. shutter_curve: N >= 2 times in [0, 1] that divide the
    light which it lets in into N - 1 equal parts; () where it opens and closes at once."""

    camera: Camera
    film: Film
    settings: dict = field(default_factory=dict)
    meshes: tuple = ()
    instances: tuple = ()
    volumes: tuple = ()
    materials: tuple = ()
    images: tuple = ()
    lights: tuple = ()
    world: World = field(default_factory=World)
    warnings: tuple = ()
    shutter: tuple = (0.0, 0.0)
    shutter_curve: tuple = ()


def same(a, b):
    """Tells whether two descriptions, or parts of such, say the same; arrays that are one object are not
    looked at."""
    if a is b:
        return True
    if type(a) is not type(b):
        return False
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b)
    if is_dataclass(a):
        return all(same(getattr(a, f.name), getattr(b, f.name)) for f in fields(a))
    if isinstance(a, tuple | list):
        return len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(same(value, b[key]) for key, value in a.items())
    return a == b
