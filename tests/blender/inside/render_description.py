# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a description (`nephele render --save-description`) with the native module in a zip.

This runs without Blender, in a Python beside the host's C library: libraries of mathematics differ in their
last bits, and one bit sends a path elsewhere. What Blender then adds or breaks shows bit by bit.

Arguments: the zip, the description, a file for Combined (.npy, top row first).
"""

import importlib.util
import sys
import tempfile
import zipfile
from pathlib import Path

ADDON = Path(__file__).resolve().parents[3] / "addon"


def unpack_wheel(package, folder):
    """Unpacks the wheel in a zip into a folder."""
    with zipfile.ZipFile(package) as outer:
        (name,) = [name for name in outer.namelist() if name.endswith(".whl")]
        with outer.open(name) as wheel, zipfile.ZipFile(wheel) as inner:
            inner.extractall(folder)


def main():
    package, source, target = map(Path, sys.argv[sys.argv.index("--") + 1 :])
    place = [str(ADDON)]
    spec = importlib.util.spec_from_file_location(
        "nephele", ADDON / "__init__.py", submodule_search_locations=place
    )
    sys.modules["nephele"] = importlib.util.module_from_spec(spec)
    import numpy as np
    from nephele import bridge, description_file

    with tempfile.TemporaryDirectory() as folder:
        unpack_wheel(package, folder)
        sys.path.insert(0, folder)
        renderer = bridge.create_renderer(description_file.load(source, Path(folder, "vdb")))
        renderer.start()
        while not renderer.wait(0.1):
            pass
        np.save(target, renderer.read_pass("Combined")[::-1, :, :3])


main()
