# SPDX-License-Identifier: GPL-3.0-or-later
"""Which files of the package `nephele` Blender needs: those that registering and rendering reach by import.

The command line stays out of the extension, and with it what Blender has not got: OpenEXR, pillow, FLIP.
"""

import ast
import sys

from kinds import ADDON

# What every Blender brings beyond the standard library; nephele_native is in the wheel.
BLENDERS_OWN = {"bl_operators", "bl_ui", "bpy", "bpy_extras", "gpu", "gpu_extras", "mathutils", "numpy"}
SOME_BLENDERS = {"openvdb"}  # asked for when it is needed, with a message where it is not there
WHEELS = {"nephele_native"}
# Files that are run or read by path, not imported.
BY_PATH = ("export/sky_bake.py", "presets/**/*.py")


def ranks():
    """Returns the names of the modules that addon/__init__.py registers."""
    for node in ast.parse((ADDON / "__init__.py").read_text()).body:
        if isinstance(node, ast.Assign) and node.targets[0].id == "RANKS":
            return ast.literal_eval(node.value)
    raise ValueError("addon/__init__.py has no RANKS")


def _file_of(dotted):
    """Returns the file of a module of the package, by its name below it ("export.mesh"), or None."""
    base = ADDON.joinpath(*dotted.split(".")) if dotted else ADDON
    for path in (base.with_suffix(".py"), base / "__init__.py"):
        if path.is_file():
            return path
    return None


def _imports(path):
    """Yields (own, name): modules that a file imports; own: of the package, named below it."""
    package = path.relative_to(ADDON).parent.parts
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from ((False, alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            yield False, node.module
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - (node.level - 1)]
            base = ".".join((*above, *filter(None, [node.module])))
            yield True, base
            for alias in node.names:  # `from . import mesh` names a module, `from .mesh import x` does not
                yield True, f"{base}.{alias.name}" if base else alias.name


def reached_files():
    """Returns the paths of the files that Blender needs; raises ValueError if one imports what Blender
    lacks."""
    found, waiting = {ADDON / "__init__.py"}, [_file_of(rank) for rank in ranks()]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found.add(path)
        for own, name in _imports(path):
            if own:
                file = _file_of(name)
                if file is not None:
                    waiting.append(file)
                continue
            top = name.split(".")[0]
            if top not in sys.stdlib_module_names and top not in BLENDERS_OWN | SOME_BLENDERS | WHEELS:
                raise ValueError(f"{path.relative_to(ADDON.parent)} imports {top}, which Blender has not got")
    found.update(path for pattern in BY_PATH for path in ADDON.glob(pattern))
    return sorted(found)
