# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blenders that the extension is tested in. scripts/blenders.sh makes those that are not in .venv."""

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
INSIDE = Path(__file__).resolve().parent / "inside"
BUILD = ROOT / "build"
SCREENSHOTS = BUILD / "screenshots"


@dataclass(frozen=True)
class Host:
    """A Blender. kind: of zip that it installs (tools/extension/kinds.py); same_scene: whether it opens files
    that Blender 5.0 saved."""

    name: str
    kind: str
    same_scene: bool = True

    def python(self):
        """Returns the beginning of a command that runs the Python beside this Blender."""
        raise NotImplementedError

    def command(self, script, arguments):
        """Returns the command that runs a script inside Blender, without windows."""
        raise NotImplementedError

    def run(self, script, *arguments, resources, timeout=600):
        """Runs a script of inside/ with a Blender whose user folder is `resources`. Returns what it printed;
        raises AssertionError, with that, where it fails."""
        return run(self.command(INSIDE / script, [str(a) for a in arguments]), resources, timeout)


@dataclass(frozen=True)
class Module(Host):
    """Blender as a Python module in a venv of its own."""

    def python(self):
        return [str(BUILD / "venvs" / self.name / "bin" / "python"), "-B"]

    def command(self, script, arguments):
        return [*self.python(), str(script), "--", *arguments]


@dataclass(frozen=True)
class VenvModule(Module):
    """The module in .venv, without the package and the native module that .venv has of its own: they would be
    found before those of the extension."""

    def python(self):
        links = BUILD / "bpy_alone"
        links.mkdir(exist_ok=True)
        for path in Path(sys.prefix).glob("lib/python*/site-packages/*"):
            link = links / path.name
            if "nephele" not in path.name and not link.is_symlink():
                link.symlink_to(path)
        return ["env", f"PYTHONPATH={links}", sys.executable, "-S", "-B"]


@dataclass(frozen=True)
class Executable(Host):
    """Debian's Blender in a root of its own, with windows on a display without a screen."""

    @property
    def folder(self):
        return BUILD / "roots" / self.name

    def python(self):
        return [*self.inside(), "python3", "-B"]

    def command(self, script, arguments):
        return [*self.blender("--background"), "--python", str(script), "--", *arguments]

    def inside(self):
        """Returns the beginning of a command that runs in the root."""
        return [str(ROOT / "scripts" / "enter_root.sh"), str(self.folder)]

    def blender(self, *options):
        """Returns the command that starts Blender; a Python error ends it with 1."""
        user = f"BLENDER_USER_RESOURCES={RESOURCES}"
        return [*self.inside(), "env", user, "blender", "--python-exit-code", "1", *options]

    def show(self, script, *arguments, resources, screen=(1600, 1000), timeout=1500):
        """Runs a script with Blender's windows on a display without a screen. Returns what was printed."""
        mode = "{}x{}x24".format(*screen)
        command = self.blender("--window-geometry", "0", "0", *map(str, screen))
        place = command.index("blender")
        command[place:place] = ["xvfb-run", "--auto-servernum", "--server-args", f"-screen 0 {mode}"]
        command += ["--python", str(INSIDE / script), "--", *map(str, arguments)]
        return run(command, resources, timeout)


RESOURCES = "@RESOURCES@"  # stands for the user folder, which run() knows

MODULES = (
    Module("bpy-4.2.23", "py311", same_scene=False),
    Module("bpy-4.5.15", "py311"),
    VenvModule("venv", "py311"),
)
EXECUTABLES = (
    Executable("trixie", "system", same_scene=False),  # Blender 4.3 with Python 3.13
    Executable("sid", "py312"),  # Blender 5.2 or newer
)


def run(command, resources, timeout=300):
    """Runs a command in a group of its own; see Host.run."""
    command = [str(word).replace(RESOURCES, str(resources)) for word in command]
    environment = os.environ | {"BLENDER_USER_RESOURCES": str(resources)}
    process = subprocess.Popen(
        command,
        cwd=ROOT,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors="replace",
        start_new_session=True,
    )
    try:
        text, _ = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, 9)
        text, _ = process.communicate()
        raise AssertionError(f"no end after {timeout} s:\n{text}") from None
    assert process.returncode == 0, f"status {process.returncode} of {' '.join(command)}:\n{text}"
    return text
