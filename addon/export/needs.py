# SPDX-License-Identifier: GPL-3.0-or-later
"""What finished programs read: images, UV maps, attributes and properties that no program reads are not
exported.

While node trees are compiled, more is named than is read in the end: a branch of weight 0 is left out.
"""

import dataclasses

import numpy as np

from .. import opcodes

OPS = list(opcodes.OPCODES)
READERS = {kind: [OPS.index(name) for name in names] for kind, names in opcodes.READS.items()}
PARAMETER, MODE = 6, 7  # columns of an instruction


def layers_read(program, uvs, attributes):
    """Returns the parts of `uvs` and `attributes` (name -> number) that the program reads."""

    def read(layers, kind):
        numbers = _numbers_in_mode(program, kind)
        return {name: number for name, number in layers.items() if number in numbers}

    return read(uvs, "uv"), read(attributes, "attribute")


def images_read(materials, world, lights=()):
    """Returns the numbers of the images that the programs of materials, world and lights read, in order."""
    programs = _programs((*materials, world, *lights))
    return sorted({number for program in programs for number in _image_numbers(program).tolist()})


def properties_read(materials):
    """Returns the set of the numbers of objects' properties that the programs of materials read."""
    return set().union(*(_numbers_in_mode(program, "property") for program in _programs(materials)))


def renumbered(block, places):
    """Returns a Material, World or Light whose programs read image places[n] in place of image n."""
    field = _field(block)
    if field == "program":
        program = _with_images(block.program, places)
        return block if program is block.program else dataclasses.replace(block, program=program)
    surface = _with_images(_surface(block), places)
    programs = [_with_images(closure.program, places) for closure in block.volume]
    if surface is _surface(block) and all(
        p is c.program for p, c in zip(programs, block.volume, strict=True)
    ):
        return block
    volume = tuple(
        dataclasses.replace(closure, program=program)
        for closure, program in zip(block.volume, programs, strict=True)
    )
    return dataclasses.replace(block, **{field: surface}, volume=volume)


def _programs(blocks):
    """Returns the programs of Materials, Worlds and Lights."""
    return [
        program
        for block in blocks
        for program in (_surface(block), *(closure.program for closure in getattr(block, "volume", ())))
        if program is not None
    ]


def _numbers_in_mode(program, kind):
    """Returns the set of the numbers of what a program reads of a kind of READERS that has them in the
    mode."""
    modes = program.code[np.isin(program.code[:, 0], READERS[kind]), MODE]
    return set((modes % opcodes.SHIFT).tolist())


def _surface(block):
    return getattr(block, _field(block))


def _field(block):
    return next(name for name in ("surface", "background", "program") if hasattr(block, name))


def _image_rows(program):
    return np.flatnonzero(np.isin(program.code[:, 0], READERS["image"]))


def _image_numbers(program):
    return program.parameters[program.code[_image_rows(program), PARAMETER]].astype(int)


def _with_images(program, places):
    """The new numbers are appended: other instructions may share the old parameters."""
    if program is None:
        return None
    rows, numbers = _image_rows(program), _image_numbers(program)
    new = np.array([places[number] for number in numbers.tolist()], np.float32)
    if np.array_equal(new, numbers):
        return program
    code = program.code.copy()
    code[rows, PARAMETER] = len(program.parameters) + np.arange(len(rows))
    return dataclasses.replace(program, code=code, parameters=np.append(program.parameters, new))
