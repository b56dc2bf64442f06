# SPDX-License-Identifier: GPL-3.0-or-later
"""What `nephele bench` renders: suites of bundled scenes, or any .blend."""

from dataclasses import dataclass
from pathlib import Path

from nephele.errors import InputError

ROOT = Path(__file__).resolve().parent.parent
SCENES = ROOT / "blend_scenes"


@dataclass(frozen=True)
class BenchScene:
    """path: of the .blend. bounces: of each kind and of all together, in every program. reference: the method
    that renders the reference image: plain delta tracking, unless it does not get there (for the lamps among
    fog it leaves bright single pixels at any number of samples)."""

    name: str
    path: Path
    bounces: int
    reference: str = "delta"
    about: str = ""


def bundled(folder, name, bounces, about, reference="delta"):
    """Returns the BenchScene of blend_scenes/FOLDER/NAME.blend."""
    return BenchScene(name, SCENES / folder / f"{name}.blend", bounces, reference, about)


SUITES = {
    "artists": (
        bundled("suite", "fog_lamps", 16, "58 lamps in thin fog", "vspg"),
        bundled("suite", "jungle", 16, "leaves, instances, sun shafts in mist"),
        bundled("suite", "lanterns", 64, "lights inside a cloud"),
        bundled("suite", "sunset", 256, "dense cloud, albedo 0.999, forward scattering"),
        bundled("suite", "smoke_wall", 32, "smoke before a textured wall"),
        bundled("suite", "fire", 16, "a fire lights its surroundings"),
        bundled("suite", "underwater", 32, "chromatic absorption, sun through a rough surface of water"),
        bundled("suite", "planet", 16, "atmosphere made by nodes"),
        bundled("suite", "kitchen", 24, "indirect light, steam, glass and metal"),
        bundled("suite", "coloured_smokes", 48, "overlapping chromatic grids"),
        bundled("suite", "empty", 12, "no volume at all"),
        bundled("suite", "stress", 32, "ten volumes, 5.5 million triangles"),
    ),
    "guiding": (
        bundled("guiding", "alley", 16, "wants more scattering"),
        bundled("guiding", "mist", 16, "wants more scattering"),
        bundled("guiding", "ember", 32, "wants less scattering"),
        bundled("guiding", "smoke_screen", 16, "wants less scattering"),
        bundled("guiding", "cumulus", 32, "delta tracking is about right"),
        bundled("guiding", "milk", 128, "adverse: long paths, nothing to gain"),
    ),
    "indirect": (
        bundled("indirect", "door", 32, "light only through a gap", "everything"),
        bundled("indirect", "window", 32, "light only from clouds and sky behind glass", "everything"),
    ),
}
DEFAULT = "artists"


def chosen(suite, only, bounces):
    """Returns the BenchScenes of a suite, or of a .blend that `suite` names; `only`: names among them, or
    None. bounces: those of a .blend.

    Raises InputError for a name that is not there.
    """
    if Path(suite).suffix == ".blend":
        if not Path(suite).is_file():
            raise InputError(f"{suite}: no such file")
        return (BenchScene(Path(suite).stem, Path(suite), bounces),)
    if suite == "all":
        scenes = tuple(scene for suite_scenes in SUITES.values() for scene in suite_scenes)
    elif suite in SUITES:
        scenes = SUITES[suite]
    else:
        raise InputError(
            f"no suite is called '{suite}'; there are {', '.join(SUITES)}, all, or a .blend file"
        )
    if only is None:
        return scenes
    found = {scene.name: scene for scene in scenes}
    for name in only:
        if name not in found:
            raise InputError(f"--scenes: suite '{suite}' has no scene '{name}'; it has {', '.join(found)}")
    return tuple(found[name] for name in only)
