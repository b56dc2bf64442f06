# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets: files as Blender's preset menus write and run them, whose lines `... nephele.NAME = VALUE` are all
that is read here. Knows neither bpy nor the native module.

A preset stands for a value of every setting that presets govern: the default where it names none.
"""

import ast
from pathlib import Path

from .errors import InputError
from .parameters import PARAMETERS, lookup

SUBFOLDER = "nephele/render"  # below presets/, here and in a user's folder of Blender
BUNDLED = Path(__file__).parent / "presets" / SUBFOLDER
NAMES = ("Preview", "Final", "Reference", "Benchmark")  # of the bundled ones, from quick to slow

# What belongs to the picture, the machine or the 3D view stays as it is.
UNGOVERNED_GROUPS = {"film", "performance"}
UNGOVERNED = {"seed", "viewport_samples"}


def governed():
    """Returns the parameters that presets set."""
    return [p for p in PARAMETERS if p.group not in UNGOVERNED_GROUPS and p.name not in UNGOVERNED]


def find(name):
    """Returns the path of the bundled preset called `name`, whatever its case, or of the file `name`. Raises
    InputError."""
    for known in NAMES:
        if name.lower() == known.lower():
            return BUNDLED / f"{known}.py"
    if Path(name).is_file():
        return Path(name)
    raise InputError(f"no preset is called '{name}': use {', '.join(NAMES).lower()} or name a preset's file")


def about(path):
    """Returns what a bundled preset says of itself: its second line."""
    return path.read_text(encoding="utf-8").splitlines()[1].removeprefix("# ")


def stated(path):
    """Returns the settings that a preset's file names, checked. Raises InputError naming the file and its
    fault."""
    try:
        lines = ast.parse(Path(path).read_text(encoding="utf-8")).body
        found = {
            line.targets[0].attr: ast.literal_eval(line.value)
            for line in lines
            if isinstance(line, ast.Assign) and isinstance(line.targets[0], ast.Attribute)
        }
        return {name: lookup(name).checked(value) for name, value in found.items()}
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except (KeyError, ValueError, SyntaxError) as error:
        raise InputError(f"{path}: is no preset of Nephele: {error.args[0]}") from error


def values(path):
    """Returns the value of every setting that a preset stands for. Raises InputError."""
    return {p.name: p.default for p in governed()} | stated(path)
