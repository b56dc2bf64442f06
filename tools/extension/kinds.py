# SPDX-License-Identifier: GPL-3.0-or-later
"""The zips that `make extension` can build, and where things lie while it does."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build" / "extension"
DIST = ROOT / "dist"
ADDON = ROOT / "addon"
VERSION = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]


@dataclass(frozen=True)
class Kind:
    """A zip: the wheel it holds, named as pip names it (python-abi), and the Blenders that may install it,
    from `minimum` on and below `maximum` where there is one. build: the build folder that the module comes
    from."""

    name: str
    wheel: str
    minimum: str
    maximum: str | None
    build: Path = BUILD

    @property
    def zip_path(self):
        return DIST / f"nephele-{VERSION}-{self.name}-linux-x64.zip"

    @property
    def wheel_folder(self):
        """The folder that holds the finished wheel, alone."""
        return BUILD / "wheels" / self.build.name / self.wheel

    @property
    def finished_wheel(self):
        (path,) = self.wheel_folder.glob("*.whl")
        return path

    @property
    def processor(self):
        """The processor that the module was compiled for (-march)."""
        (found,) = re.findall(r"^NEPHELE_ARCH:\w+=(.+)$", (self.build / "CMakeCache.txt").read_text(), re.M)
        return found


KINDS = {
    # Blender refuses a zip with wheels for several versions of Python, even where its own is among them.
    "py311": Kind("blender-4.2-to-5.0", "cp311-cp311", "4.2.0", "5.1.0"),
    "py312": Kind("blender-5.1", "cp312-abi3", "5.1.0", None),
    # Blenders that a Linux distribution built with a newer Python than Blender's own of that version.
    "system": Kind("system-python", "cp312-abi3", "4.2.0", None),
    # For this machine alone, from what `make build` has built: for tests.
    "development": Kind("development", "cp311-cp311", "4.2.0", "5.1.0", ROOT / "build" / "release"),
}
