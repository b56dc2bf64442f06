# SPDX-License-Identifier: GPL-3.0-or-later
"""Twelve small scenes of the kinds that artists make: the suite that `nephele bench` renders.

    python blend_scenes/suite/make.py [NAME...] [--output FOLDER]

Each scene is the module of its name beside this file, with `BOUNCES`, `build()` and, where it has a volume
of its own, `write_volume(path)`. Writes NAME.blend and NAME.vdb into the folder (this one by default).
"""

import argparse
import importlib
import sys
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
sys.path[:0] = [str(FOLDER), str(FOLDER.parent)]
import common  # noqa: E402  the folders above are on the path only now

RESOLUTION, SAMPLES = (480, 270), 64
SCENES = (
    "fog_lamps",
    "jungle",
    "lanterns",
    "sunset",
    "smoke_wall",
    "fire",
    "underwater",
    "planet",
    "kitchen",
    "coloured_smokes",
    "empty",
    "stress",
)


def make(name, folder):
    """Writes one scene with its volume; returns the path of its .blend."""
    module = importlib.import_module(name)
    if hasattr(module, "write_volume"):
        module.write_volume(folder / f"{name}.vdb")
    common.new_scene(RESOLUTION, SAMPLES, module.BOUNCES, view_transform="AgX")
    module.build()
    return common.save(folder, name)


def main():
    parser = argparse.ArgumentParser(description="Write the scenes of the suite.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(SCENES)}; all by default")
    parser.add_argument("--output", type=Path, default=FOLDER, metavar="FOLDER")
    options = parser.parse_args()
    if unknown := set(options.names) - set(SCENES):
        parser.error(f"no scene {', '.join(sorted(unknown))}; there are {', '.join(SCENES)}")
    for name in options.names or SCENES:
        print(make(name, options.output))


main()
