# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders one scene with one build of the native module, for bench/specialisation.py: a process of its own.

    python bench/feature_run.py MODULE_FOLDER SCENE.nephele SETTINGS.json PASSES [SWITCH.so]

Prints JSON: CPU seconds, rays, a checksum of Combined. With SWITCH.so, under callgrind, which then counts the
instructions of the second render alone: tables that a process makes once are made in the first.
"""

import ctypes
import hashlib
import json
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [sys.argv[1], str(ROOT)]
from nephele import bridge, description_file  # noqa: E402  the folder of the module has to come first

from bench import feature_scenes  # noqa: E402  the project's root is on the path only now


def rendered(scene, switch=None):
    """Returns the finished renderer."""
    renderer = bridge.create_renderer(scene)
    if switch:
        switch.start()
    renderer.start()
    while not renderer.wait(3600):
        pass
    if switch:
        switch.stop()
    return renderer


def main():
    """Renders twice and prints what the second render says."""
    _, module, path, settings, passes, *switch = sys.argv
    loaded = Path(bridge.load_native().__file__).parent
    if loaded != Path(module).resolve():
        raise SystemExit(f"{loaded} was loaded in place of {module}")
    with tempfile.TemporaryDirectory() as folder:
        scene = description_file.load(path, folder)
        scene = feature_scenes.changed(scene, json.loads(settings), passes.split(","))
        rendered(feature_scenes.changed(scene, {"samples": 1}))
        renderer = rendered(scene, ctypes.CDLL(switch[0]) if switch else None)
    told = renderer.statistics()
    pixels = renderer.read_pass("Combined")
    print(
        json.dumps(
            {
                "cpu_seconds": told["render_cpu_seconds"],
                "rays": told["rays"],
                "kernel": told["kernel"],
                "sha256": hashlib.sha256(pixels.tobytes()).hexdigest(),
            }
        )
    )


if __name__ == "__main__":
    main()
