# SPDX-License-Identifier: GPL-3.0-or-later
"""Takes the pictures of docs/user anew: `make pictures`, as root; `user_pictures.py STEP...` some of STEPS.

Panels come from the windows of Debian's Blender in build/roots/trixie with the zip of `make extension
KINDS=system`; the maps of guiding from the bundled smoke, rendered by `nephele render`.
"""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "blender"))
from hosts import EXECUTABLES, MODULES, run  # noqa: E402
from turns import WORK, fresh, package  # noqa: E402

PICTURES = ROOT / "docs" / "images" / "user"
COLOURS = 64  # of a panel's picture
LARGEST = 60_000  # bytes of a picture


def save(image, name):
    """Writes a panel's picture with few colours; raises ValueError where it is too large to keep."""
    path = PICTURES / f"{name}.png"
    image.convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)
    if path.stat().st_size > LARGEST:
        raise ValueError(f"{path} has {path.stat().st_size} bytes: crop it")
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size} bytes")


def host_and_scene():
    """Returns (Host, the bundled cloud as it can open it)."""
    host = next(host for host in EXECUTABLES if host.name == "trixie")
    folder = fresh(WORK / "picture_scene")
    saver = next(module for module in MODULES if module.name == "bpy-4.5.15")
    scene = ROOT / "blend_scenes" / "cloud" / "cloud.blend"
    saver.run("resave.py", folder, scene, resources=fresh(WORK / "picture_saver"))
    return host, folder / "cloud.blend"


def take_panels():
    """Takes the pictures of panels."""
    host, scene = host_and_scene()
    shots, resources = fresh(WORK / "pictures_of_panels"), fresh(WORK / "picture_user")
    install = ("--command", "extension", "install-file", "--repo", "user_default", "--enable")
    run(host.blender(*install, str(package(host.kind))), resources, 120)
    host.show("ui_pictures.py", shots, scene, resources=resources, screen=(640, 1500))
    for name, box in json.loads((shots / "crops.json").read_text()).items():
        save(Image.open(shots / f"{name}.png").crop(box), name)


def take_first_render():
    """Takes the picture of a new user's first render, and prints how long its steps took."""
    host = next(host for host in EXECUTABLES if host.name == "trixie")
    shots, resources = fresh(WORK / "first_render"), fresh(WORK / "new_user")
    arguments = (shots, package(host.kind), shots / "times.json")
    host.show("ui_first_render.py", *arguments, resources=resources, screen=(1200, 750))
    picture = Image.open(shots / "first_render.png").convert("RGB").crop((0, 50, 1200, 750))
    picture.save(PICTURES / "first_render.jpg", quality=80)
    print((shots / "times.json").read_text())


def make_maps():
    """Renders the bundled smoke, and writes it beside its maps of guiding."""
    out = fresh(WORK / "maps") / "smoke.exr"
    command = [sys.executable, "-m", "nephele", "render", "blend_scenes/smoke/smoke.blend", "-o", str(out)]
    command += ["--resolution", "320x180", "--samples", "64", "--quiet"]
    command += ["--passes", "Combined,VSP Target,VSP Achieved"]
    subprocess.run(command, check=True, cwd=ROOT)
    from nephele import exr, maps

    images = exr.read(out)
    shown = [shown for shown in maps.maps_of(images) if shown.name in ("Combined", *maps.SHARES[:2])]
    assert [one.name for one in shown] == ["Combined", *maps.SHARES[:2]]
    gap = np.full((shown[0].colours.shape[0], 6, 3), 255, np.uint8)
    row = np.hstack([part for one in shown for part in (gap, one.colours)][1:])
    path = PICTURES / "vsp_maps.jpg"
    Image.fromarray(row).save(path, quality=82)
    print(f"{path.relative_to(ROOT)}: {path.stat().st_size} bytes")


STEPS = {"maps": make_maps, "panels": take_panels, "first_render": take_first_render}

if __name__ == "__main__":
    PICTURES.mkdir(parents=True, exist_ok=True)
    for step in sys.argv[1:] or STEPS:
        STEPS[step]()
