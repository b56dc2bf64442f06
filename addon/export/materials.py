# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that one export takes over from the last: those of which nothing was evaluated anew, and whose
programs would hold the same numbers of UV maps and attributes. One with an image is always compiled: whether
its pixels are the same is for images.py to say."""

import dataclasses

import bpy

from .. import description
from .history import uid
from .nodes import compile_material


@dataclasses.dataclass(frozen=True)
class KeptMaterial:
    """A material as an export compiled it. uvs, attributes: name -> number of those that meshes need. uses:
    uids of all that its nodes refer to. asked: numbers that it asked for, in order. notes: warnings."""

    material: description.Material
    uvs: dict
    attributes: dict
    uses: frozenset
    asked: tuple
    notes: tuple


def kept_material(material, context, grids):
    """Returns (description.Material, UV map names -> number, attribute names -> number); see
    compile_material()."""
    cache = context.cache
    key = (uid(material) or material.name_full, grids)
    kept = cache.materials.get(key)
    if kept is None or not _holds(kept, material, context):
        with context.recording() as record:
            compiled = compile_material(material, context, grids)
        if record.images:
            return compiled
        kept = KeptMaterial(
            *compiled, frozenset(_referred_to(material.node_tree)), tuple(record.asked), tuple(record.notes)
        )
    else:
        for note in kept.notes:
            context.warn(note)
    cache.materials.put(key, kept)
    return kept.material, kept.uvs, kept.attributes


def _holds(kept, material, context):
    """Tells whether compiling the material would give what was kept; takes its numbers up if so."""
    history = context.cache.history
    own = filter(None, [material, material.node_tree])
    same = material.name == kept.material.name and history.untouched(*own)
    return same and not history.any_touched(kept.uses) and context.ask_again(kept.asked)


def _referred_to(tree):
    """Yields the uids of the data-blocks that a tree's nodes refer to, and of those within their groups."""
    pending, seen = [tree] if tree is not None else [], set()
    while pending:
        for node in pending.pop().nodes:
            for name in _pointers(type(node)):
                block = getattr(node, name)
                if block is None or uid(block) in seen:
                    continue
                seen.add(uid(block))
                yield uid(block)
                if isinstance(block, bpy.types.NodeTree):
                    pending.append(block)


def _pointers(cls):
    """Returns the names of the properties of a node class that refer to data-blocks."""
    if cls not in _POINTERS:
        _POINTERS[cls] = [
            p.identifier for p in cls.bl_rna.properties if p.type == "POINTER" and _is_block(p.fixed_type)
        ]
    return _POINTERS[cls]


def _is_block(rna):
    while rna is not None:
        if rna.identifier == "ID":
            return True
        rna = rna.base
    return False


_POINTERS = {}
