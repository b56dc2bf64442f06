# SPDX-License-Identifier: GPL-3.0-or-later
"""Every pass that we share with Cycles 5.0, on a scene of diffuse, glossy, translucent, transparent and glass
surfaces, emission and a fog that shines and scatters.

Light passes times their colours, colours, and coverage of cryptomattes: Welch's t over blocks and channels of
SEEDS renders of each, Sidak-corrected, a false alarm in 1e-3 a pass if both were exact. Passes of the first
sample alone: within what that of our seeds is, but for silhouettes, where seeds agree by chance.
Convention, not error, where the two part: Cycles lets volumes dim Normal, UV and Mist and hide Depth,
Position and indices at random; ours see through volumes. So these are compared beside the fog. Features for
denoisers are ours alone for emitters and mirrors; they are compared on the floor."""

import sys
from pathlib import Path

import numpy as np
import pytest
from test_against_cycles import FALSE_ALARM, blocks, welch

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
from bench import cycles, ours  # noqa: E402  the project's root is on the path only now

SEEDS, BOUNCES, SIZE = 8, 4, (80, 48)
SURFACES = ("Diffuse", "Glossy", "Transmission")
LIGHT = [f"{kind} {part}" for kind in SURFACES for part in ("Direct", "Indirect")]
COLORS = [f"{kind} Color" for kind in SURFACES]
WHOLE = ["Volume Direct", "Volume Indirect", "Emission", "Environment"]
MEANS = ["Normal", "UV", "Mist"]
FIRST = ["Depth", "Position", "Object Index", "Material Index"]
FEATURES = ["Denoising Albedo", "Denoising Normal", "Denoising Depth"]
MATTES = ["CryptoObject00", "CryptoMaterial00", "CryptoAsset00"]
ALL = ["Combined", *LIGHT, *COLORS, *WHOLE, *MEANS, *FIRST, *FEATURES, *MATTES]


def material(bpy, name, index, *closures, output="Surface"):
    """Returns a material that adds up closures, each (node type, inputs by name)."""
    new = bpy.data.materials.new(name)
    new.use_nodes, new.pass_index = True, index
    tree = new.node_tree
    tree.nodes.clear()
    total = None
    for kind, inputs in closures:
        node = tree.nodes.new(f"ShaderNode{kind}")
        for socket, value in inputs.items():
            node.inputs[socket].default_value = value
        if total is None:
            total = node.outputs[0]
            continue
        add = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(total, add.inputs[0])
        tree.links.new(node.outputs[0], add.inputs[1])
        total = add.outputs[0]
    tree.links.new(total, tree.nodes.new("ShaderNodeOutputMaterial").inputs[output])
    return new


def build(bpy, path):
    """Makes the scene and saves it."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    scene = bpy.context.scene
    grey = (0.5, 0.5, 0.5, 1)

    def add(kind, index, look, parent=None, **more):
        getattr(bpy.ops.mesh, f"primitive_{kind}_add")(**more)
        item = bpy.context.object
        item.data.materials.append(look)
        item.pass_index, item.parent = index, parent
        return item

    floor = material(
        bpy,
        "Floor",
        1,
        ("BsdfDiffuse", {"Color": (0.6, 0.4, 0.2, 1)}),
        ("BsdfGlossy", {"Color": (0.2, 0.2, 0.3, 1), "Roughness": 0.5}),
    )
    ground = add("plane", 1, floor, size=14)
    add("uv_sphere", 2, material(bpy, "Glass", 2, ("BsdfGlass", {"Roughness": 0.3, "IOR": 1.45})), ground,
        radius=0.8, location=(-2.2, 0.5, 0.8), segments=64, ring_count=32)  # fmt: skip
    veil = (
        ("BsdfDiffuse", {"Color": (0.3, 0.1, 0.1, 1)}),
        ("BsdfTransparent", {"Color": (0.6, 0.6, 0.6, 1)}),
    )
    add(
        "plane",
        3,
        material(bpy, "Veil", 3, *veil),
        size=1.4,
        location=(-0.4, -1.5, 0.9),
        rotation=(1.4, 0, 0),
    )
    sheet = ("BsdfRefraction", {"Color": (0.4, 0.4, 0.4, 1), "Roughness": 0.3, "IOR": 1.2})
    leaf = (
        sheet,
        ("BsdfTranslucent", {"Color": (0.2, 0.5, 0.1, 1)}),
        ("BsdfGlossy", {"Color": grey, "Roughness": 0.3}),
    )
    add(
        "plane", 4, material(bpy, "Leaf", 4, *leaf), size=1.4, location=(-0.3, 1.5, 1), rotation=(1.2, 0.3, 0)
    )
    glow = material(bpy, "Glow", 5, ("Emission", {"Color": (1, 0.6, 0.2, 1), "Strength": 3.0}))
    add("cube", 5, glow, size=0.6, location=(-1, -0.6, 0.31))
    fog = (
        ("VolumeScatter", {"Color": (0.8, 0.8, 0.9, 1), "Density": 0.5}),
        ("Emission", {"Color": (0.1, 0.2, 0.4, 1), "Strength": 0.1}),
    )
    add("cube", 6, material(bpy, "Fog", 6, *fog, output="Volume"), size=2.2, location=(2.2, 0, 1.2))
    principled = {"Base Color": (0.2, 0.5, 0.7, 1), "Roughness": 0.4, "Coat Weight": 0.5}
    behind = add(
        "cube", 7, material(bpy, "Behind", 7, ("BsdfPrincipled", principled)), size=1, location=(2.2, 2, 0.6)
    )
    behind.rotation_euler = (0, 0, 0.5)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.data.angle, sun.rotation_euler = 2.0, 0.1, (0.6, 0.3, 0)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -8, 3), (1.27, 0, 0)
    for item in (sun, camera):
        scene.collection.objects.link(item)
    scene.camera = camera
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.6, 1)
    mist = scene.world.mist_settings
    mist.start, mist.depth, mist.falloff = 4.0, 12.0, "QUADRATIC"
    layer = bpy.context.view_layer
    layer.use_pass_uv = True  # else the maps are left out
    bpy.ops.wm.save_as_mainfile(filepath=str(path), copy=True)
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


@pytest.fixture(scope="module")
def renders(addon, tmp_path_factory):
    """Returns (Cycles' passes, ours), each name -> (seeds, height, width, channels), top row first."""
    import bpy

    folder = tmp_path_factory.mktemp("passes")
    path = folder / "passes.blend"
    build(bpy, path)
    seeds = tuple(range(1, SEEDS + 1))
    job = cycles.Job(str(path), SIZE, 24, seeds, BOUNCES, pixel_filter="BOX", passes=tuple(ALL))
    theirs = cycles.render(job).passes
    limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), BOUNCES)
    scene = ours.export(path, folder, SIZE)
    assert scene.warnings == ()
    passes = (*ALL, "Transmittance")
    mine, _ = ours.render(scene, seeds, passes, samples=64, pixel_filter="box", threads=2, **limits)
    return theirs, mine


def product(images, name):
    """Returns a light pass times its colour; others as they are."""
    kind = name.split()[0]
    image = images[name].astype(np.float64)
    return image * images[f"{kind} Color"] if name in LIGHT else image


def assert_same(mine, theirs, rounding=0.0):
    """Asserts that renders of several seeds have the same mean in all blocks."""
    difference = blocks(theirs).mean(0) - blocks(mine).mean(0)
    t, p = welch(blocks(mine), blocks(theirs))
    p = np.where(np.abs(difference) <= rounding * np.abs(blocks(theirs)).mean(0), 1, p)
    worst = np.unravel_index(np.argmin(p), p.shape)
    level = 1 - (1 - FALSE_ALARM) ** (1 / p.size)
    values = blocks(mine).mean(0)[worst], blocks(theirs).mean(0)[worst]
    assert p.min() > level, f"block {worst}: t = {t[worst]:.1f}, ours {values[0]:.4g}, Cycles {values[1]:.4g}"


@pytest.mark.parametrize("name", [*LIGHT, *WHOLE, "Combined"])
def test_light(renders, name):
    theirs, mine = renders
    assert product(mine, name).mean() > 1e-4, "the scene has none of it"
    assert_same(product(mine, name), product(theirs, name))


def test_the_parts_add_up(renders):
    _, mine = renders
    total = sum(product(mine, name) for name in (*LIGHT, *WHOLE))
    assert np.allclose(total, mine["Combined"], rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("name", COLORS)
def test_colors(renders, name):
    theirs, mine = renders
    assert_same(
        mine[name], theirs[name], rounding=0.05
    )  # albedos of rough lobes are estimates in both: 3.4 % off


def beside_fog(renders):
    """Returns (h, w) where no sample of ours met the fog."""
    return (renders[1]["Transmittance"].min((0, -1)) == 1) & (renders[1]["Emission"].max((0, -1)) < 10)


@pytest.mark.parametrize("name", MEANS)
def test_means_over_surfaces(renders, name):
    theirs, mine = renders
    outside = beside_fog(renders)[None, ..., None]
    assert_same(mine[name] * outside, theirs[name] * outside)


@pytest.mark.parametrize("name", FIRST)
def test_the_first_sample(renders, name):
    theirs, mine = (r[name].astype(np.float64) for r in renders)
    low, high = mine.min(0), mine.max(0)
    margin = 0.5 * (high - low) + 1e-4 * np.abs(high)
    within = (np.median(theirs, 0) >= low - margin) & (np.median(theirs, 0) <= high + margin)
    assert within.all(-1)[beside_fog(renders)].mean() > 0.98


def test_features_of_the_floor(renders):
    theirs, mine = ({name: r[name].astype(np.float64).mean(0) for name in FEATURES} for r in renders)
    floor = beside_fog(renders) & (renders[1]["Object Index"] == 1).all((0, -1))
    floor &= (renders[0]["Object Index"] == 1).all((0, -1))
    assert floor.sum() > 800
    clip_start = 0.1  # from which Cycles counts
    mine["Denoising Depth"] = mine["Denoising Depth"] - clip_start
    # In a tenth of the pixels some sample may meet something else.
    for name, most in (("Denoising Albedo", 0.01), ("Denoising Normal", 0.01), ("Denoising Depth", 0.1)):
        off = np.abs(mine[name] - theirs[name]).max(-1)[floor]
        assert np.percentile(off, 90) < most, name


@pytest.mark.parametrize("name", MATTES)
def test_mattes(renders, name):
    theirs, mine = renders
    ids = np.unique(np.concatenate([r[name][..., (0, 2)].ravel() for r in renders]))
    ids = [i for i in ids if i != 0]
    assert len(ids) >= 4

    def coverage(images, number):
        found = images[name].view(np.uint32) == np.float32(number).view(np.uint32)
        return (found[..., (0, 2)] * images[name][..., (1, 3)]).sum(-1, keepdims=True)

    for number in ids:
        assert_same(coverage(mine, number), coverage(theirs, number), rounding=0.02)
