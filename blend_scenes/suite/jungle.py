# SPDX-License-Identifier: GPL-3.0-or-later
"""A jungle in mist with shafts of sun: ferns, broad leaves and a canopy of cut-out leaves, all instanced
(435 000 triangles), translucent; mist that thins out with height (extinction up to 0.035 per metre, g =
0.7)."""

import common
import numpy as np
import shading
from nodes import ShaderNodes
from props import add_sun, matt, sun_from
from shapes import arching, blades, polygon_mesh, rod, scatter, subdivide

BOUNCES = 16


def leaf_material(name, colour, mask=None):
    """Half reflects, half lets through, yellower; cut out by an image where one is given."""
    n = ShaderNodes(name)
    through = tuple(c * k for c, k in zip(colour, (1.5, 1.3, 0.5), strict=True))
    shader = n.mix(0.45, n.node("BsdfDiffuse", Color=colour), n.node("BsdfTranslucent", Color=through))
    if mask is not None:
        image = n.node("TexImage", {"image": mask})
        shader = n.mix(image, n.node("BsdfTransparent"), shader)
    return n.finish(surface=shader)


def leaf_mask():
    """A spray of leaves along a twig, 64 x 64: white where there is leaf."""
    y, x = (np.indices((64, 64)) + 0.5) / 64
    mask = np.abs(x - 0.5) < 0.012
    for k in range(7):
        for side in (-1, 1):
            u, v = side * (x - 0.5), y - 0.06 - 0.115 * k
            along, across = 0.8 * u + 0.6 * v, 0.8 * v - 0.6 * u
            length = 0.42 - 0.025 * k
            mask |= (along > 0) & (np.abs(across) < 0.22 * np.sqrt(np.maximum(along * (length - along), 0)))
    return np.repeat(mask[..., None], 3, axis=-1).astype(float)


def rosette(name, rng, count, widths, length, material):
    """Leaves that arch out of one root."""
    transforms = [
        arching(length * rng.uniform(0.7, 1.1), rng.uniform(0.7, 1.3), rng.uniform(1.0, 1.9), 2.4 * i)
        for i in range(count)
    ]
    return common.link(name, polygon_mesh(name, *blades(widths, transforms)), material=material)


def fern(rng, material):
    """Fronds with leaflets on both sides."""
    vertices, quads = [], []
    for i in range(11):
        frond = arching(rng.uniform(0.8, 1.1), rng.uniform(0.8, 1.2), rng.uniform(1.2, 2.0), 2.4 * i)
        for x in np.linspace(0.12, 0.98, 18):
            reach, half = 0.26 * np.sin(np.pi * x**0.7), 0.022
            flat = [
                (x, 0, 0),
                (x + half, 0.5 * reach, 0.01),
                (x + 0.04, reach, -0.03),
                (x - half, 0.5 * reach, 0.01),
            ]
            for side in (-1, 1):
                quads.append(tuple(4 * len(vertices) + np.arange(4)))
                vertices.append(frond(np.array(flat) * (1, side, 1)))
    return common.link("Fern", polygon_mesh("Fern", np.concatenate(vertices), quads), material=material)


def spray(rng, material):
    """Thirty cards that show the image of a twig."""
    cards = np.array(((-0.5, 0, 0), (0.5, 0, 0), (0.5, 1, 0), (-0.5, 1, 0)))
    turns = np.linalg.qr(rng.normal(size=(30, 3, 3)))[0]
    vertices = np.concatenate([cards @ turn.T + rng.normal(0, 0.45, 3) * (1, 1, 0.5) for turn in turns])
    mesh = polygon_mesh("Spray", vertices, np.arange(120).reshape(-1, 4))
    uvs = np.tile(np.array((0, 0, 1, 0, 1, 1, 0, 1), np.float32), 30)
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", uvs)
    return common.link("Spray", mesh, material=material)


def ground_places(rng, count, clear):
    """Places (N, 3) beside the path, which is `clear` metres to either side of its middle."""
    x = rng.uniform(clear, 9.0, count) * rng.choice((-1, 1), count)
    y = rng.uniform(0.5, 26.0, count)
    return np.stack([x + path(y), y, rise(x + path(y), y)], axis=1)


def path(y):
    return 0.8 * np.sin(0.28 * y)


def rise(x, y):
    return 0.09 * np.abs(x - path(y)) ** 1.4 - 0.05


def build():
    rng = np.random.default_rng(5)
    shading.set_world((0.40, 0.60, 0.75), 0.4)
    soil, bark = matt("Soil", 0.07, 0.05, 0.03), matt("Bark", 0.12, 0.085, 0.06)
    xs, ys = np.linspace(-14, 14, 21), np.linspace(-4, 34, 26)
    ground = common.link("Ground", common.heightfield_mesh("Ground", xs, ys, rise), material=soil)
    subdivide(ground, 2, smooth=True)

    def plant(name, child, places, lean, scales):
        normals = np.array((0, 0, 1)) + rng.normal(0, lean, (len(places), 3))
        scatter(name, child, places, normals, rng.uniform(0, 2 * np.pi, len(places)), scales)

    broad = 0.16 * np.sin(np.pi * np.linspace(0.03, 1, 9) ** 0.8)
    green, deep, lime = (0.07, 0.20, 0.03), (0.04, 0.14, 0.04), (0.14, 0.26, 0.04)
    ferns = ground_places(rng, 330, 0.75)
    plant("Ferns", fern(rng, leaf_material("Fern", green)), ferns, 0.15, rng.uniform(0.6, 1.5, 330))
    leafy = ground_places(rng, 220, 1.3)
    bush = rosette("Broad leaves", rng, 13, broad, 1.3, leaf_material("Broad leaf", deep))
    plant("Bushes", bush, leafy, 0.2, rng.uniform(0.6, 1.7, 220))
    grassy = ground_places(rng, 240, 0.45)
    blade = rosette("Grass", rng, 12, (0.02, 0.025, 0.02, 0.0), 0.5, leaf_material("Grass", lime))
    plant("Tufts", blade, grassy, 0.1, rng.uniform(0.4, 1.1, 240))

    trees = ground_places(rng, 34, 2.1)
    for i, (x, y, z) in enumerate(trees):
        top = (x + rng.normal(0, 0.5), y + rng.normal(0, 0.5), 11.0)
        rod(f"Trunk {i + 1}", (x, y, z - 0.2), top, rng.uniform(0.12, 0.35), bark, 0.5)
    mask = shading.pack_image("twig", leaf_mask(), "Non-Color")
    count = 500
    crown = trees[rng.integers(0, len(trees), count)] + rng.normal(0, 1.5, (count, 3)) * (1, 1, 0)
    crown[:, 2] = rng.uniform(5.5, 10.5, count)
    plant(
        "Crowns", spray(rng, leaf_material("Canopy", green, mask)), crown, 0.6, rng.uniform(0.8, 1.5, count)
    )

    add_sun(sun_from(62.0, 52.0), 110.0, (1.0, 0.88, 0.66))
    n = ShaderNodes("Mist")
    up = n.map_range(n.axis(n.node("NewGeometry", output="Position"), "Z"), 0.0, 11.0, 0.035, 0.02)
    mist = n.finish(n.node("VolumeScatter", Color=(0.96, 0.97, 0.96), Density=up, Anisotropy=0.7))
    common.link("Mist", common.box_mesh("Mist", (-13, -3, -0.6), (13, 33, 12)), material=mist)
    common.add_camera((0.3, -2.2, 1.5), (0.5, 10.0, 2.6), 24.0)
