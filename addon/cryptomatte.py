# SPDX-License-Identifier: GPL-3.0-or-later
"""Cryptomatte metadata (specification 1.2): which name each id stands for, as files and Blender's node read
it. The mattes themselves are made by the native module (native/film/matte.h)."""

import json

KINDS = {  # kind of name, as in a pass's -> names of a description.Scene
    "CryptoObject": lambda scene: (item.name for item in scene.instances),
    "CryptoMaterial": lambda scene: materials(scene),
    "CryptoAsset": lambda scene: (item.asset or item.name for item in scene.instances),
}
DEFAULT_MATERIAL = "default_surface"  # of objects without a material, as Cycles calls it


def materials(scene):
    """Yields the names of the materials that surfaces show."""
    for item in scene.instances:
        for number in item.materials:
            yield DEFAULT_MATERIAL if number < 0 else scene.materials[number].name


def metadata(scene, layer, native):
    """Returns a dict of the texts that go into the header of an image of `scene`, a description.Scene; empty
    where its film has no cryptomatte. layer: the view layer's name. native: the native module."""
    texts = {}
    for kind, names_of in KINDS.items():
        if not any(name.startswith(kind) for name in scene.film.passes):
            continue
        name = f"{layer}.{kind}"
        prefix = f"cryptomatte/{native.matte_hash(name):08x}"[: len("cryptomatte/") + 7]
        manifest = {item: f"{native.matte_hash(item):08x}" for item in sorted(set(names_of(scene)))}
        texts |= {
            f"{prefix}/name": name,
            f"{prefix}/hash": "MurmurHash3_32",
            f"{prefix}/conversion": "uint32_to_float32",
            f"{prefix}/manifest": json.dumps(manifest, separators=(",", ":"), ensure_ascii=False),
        }
    return texts
