# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves a changed copy of a .blend, for comparisons that have to leave something out of a scene.

Runs Blender in a process of its own; this file is also that process's script:

    python -P bench/variant.py SCENE.blend COPY.blend CHANGES.json
"""

import json
import subprocess
import sys
from pathlib import Path


def make(scene, copy, remove=(), bare_principled=False):
    """Writes `copy`, the .blend `scene` with changes, and returns its path. Raises RuntimeError where it fails.

    remove: names of objects to leave out. bare_principled: takes the dielectric reflection off every Principled
    BSDF, so that what is no metal is diffuse under its coat.
    """
    changes = json.dumps({"remove": list(remove), "bare_principled": bare_principled})
    command = [sys.executable, "-P", __file__, str(scene), str(copy), changes]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{scene}: Blender cannot change it: {done.stderr.strip()}")
    return Path(copy)


def run(scene, copy, changes):
    """Does the work of make() inside Blender."""
    import bpy

    bpy.ops.wm.open_mainfile(filepath=str(Path(scene).resolve()), use_scripts=False)
    for name in changes["remove"]:
        bpy.data.objects.remove(bpy.data.objects[name])
    if changes["bare_principled"]:
        for material in bpy.data.materials:
            for node in material.node_tree.nodes:
                if node.bl_idname == "ShaderNodeBsdfPrincipled":
                    node.inputs["Specular IOR Level"].default_value = 0.0
    bpy.ops.file.make_paths_absolute()
    bpy.ops.wm.save_as_mainfile(filepath=str(copy), copy=True)


if __name__ == "__main__":
    run(sys.argv[1], sys.argv[2], json.loads(sys.argv[3]))
