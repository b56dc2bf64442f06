# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs the zip into a fresh user folder and renders a scene by turns with Cycles and with Nephele.

Arguments: the zip, the .blend, a folder for pictures (NAME.exr) and report.json, width, height, samples.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common

TURNS = ("cycles_before", "nephele_first", "cycles_between", "nephele_second", "cycles_after")


def main():
    package, blend, folder, width, height, samples = common.arguments()
    common.install(package)
    scene = common.open_scene(blend, int(width), int(height), int(samples))
    common.write_exr(scene)
    states = []
    for turn in TURNS:
        scene.render.engine = "CYCLES" if turn.startswith("cycles") else "NEPHELE"
        scene.render.filepath = str(Path(folder, f"{turn}.exr"))
        assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
        if scene.render.engine == "NEPHELE":
            record = common.part("engine").last_render
            states.append([record.state, record.message, record.warnings])
    bpy.ops.wm.save_userpref()
    common.report(
        Path(folder, "report.json"), states=states, native=str(sys.modules["nephele_native"].__file__)
    )
    # No scene may use the engine when it goes.
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.ops.preferences.addon_disable(module=common.MODULE)
    try:
        bpy.context.scene.render.engine = "NEPHELE"
    except TypeError:
        return
    raise AssertionError("disabling the extension left its engine behind")


main()
