# SPDX-License-Identifier: GPL-3.0-or-later
"""Saves .blend files in the format of the Blender that runs this: older ones refuse those that 5.0 wrote.

Arguments: a folder for the results, then .blend files. Their VDB files are copied along.
"""

import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common


def main():
    folder, *files = map(Path, common.arguments())
    for file in files:
        bpy.ops.wm.open_mainfile(filepath=str(file))
        for volume in file.parent.glob("*.vdb"):
            shutil.copy2(volume, folder)
        bpy.context.preferences.filepaths.save_version = 0
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / file.name), relative_remap=False)


main()
