# SPDX-License-Identifier: GPL-3.0-or-later
"""What the scripts that run inside Blender share. They know the extension as a user does: by its zip."""

import json
import sys
from pathlib import Path

import bpy

MODULE = "bl_ext.user_default.nephele"


def arguments():
    """Returns the script's own arguments."""
    return sys.argv[sys.argv.index("--") + 1 :]


def install(path):
    """Installs a zip and enables it, as Preferences > Get Extensions > Install from Disk does."""
    done = bpy.ops.extensions.package_install_files(
        filepath=str(path), repo="user_default", enable_on_install=True
    )
    assert done == {"FINISHED"} and MODULE in bpy.context.preferences.addons, f"not installed: {done}"


def part(name):
    """Returns a module of the installed add-on, such as "engine"."""
    return sys.modules[f"{MODULE}.{name}"]


def open_scene(path, width, height, samples):
    """Opens a .blend for small pictures and returns its scene."""
    bpy.ops.wm.open_mainfile(filepath=str(path))
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.nephele.samples = samples
    scene.cycles.samples = 1  # whether Cycles still renders is asked, not how well
    return scene


def write_exr(scene):
    """Has the scene's pictures written as OpenEXR with 32 bits: the numbers that the engine gave."""
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_depth, settings.color_mode = "OPEN_EXR", "32", "RGBA"


def loaded_libraries():
    """Returns the paths of the shared libraries of this process."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    return sorted({line.split()[-1] for line in lines if ".so" in line})


def report(path, **facts):
    """Writes facts, and what Blender this is, as JSON."""
    facts |= {
        "blender": bpy.app.version_string,
        "python": sys.version.split()[0],
        "libraries": loaded_libraries(),
    }
    Path(path).write_text(json.dumps(facts, indent=1))
