# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the add-on and a finished wheel into a zip that Blender installs: `make_zip.py KIND`, one
of kinds.py.

The zip is built and validated by Blender's own tool, which the module bpy in .venv brings.
"""

import shutil
import subprocess
import sys
from pathlib import Path

from kinds import ADDON, BUILD, DIST, KINDS, ROOT, VERSION
from reach import reached_files

TOOL = "scripts/addons_core/bl_pkg/cli/blender_ext.py"


def blender_tool():
    """Returns the path of Blender's tool for extensions."""
    (path,) = Path(sys.prefix).glob(f"lib/python*/site-packages/bpy/*/{TOOL}")
    return path


def blender_extension(*arguments):
    """Runs Blender's tool; raises RuntimeError with its words if it refuses."""
    command = [sys.executable, str(blender_tool()), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"Blender's extension tool refuses: {done.stdout}{done.stderr}")


def manifest(kind, wheel):
    """Returns the text of a kind's manifest, made from addon/blender_manifest.toml."""
    lines = (ADDON / "blender_manifest.toml").read_text().splitlines()
    made = []
    for line in lines:
        key = line.split(" = ")[0]
        if key == "version" and line != f'version = "{VERSION}"':
            raise ValueError(f"addon/blender_manifest.toml and pyproject.toml (version {VERSION}) disagree")
        if key == "blender_version_min":
            made.append(f'blender_version_min = "{kind.minimum}"')
            if kind.maximum:
                made.append(f'blender_version_max = "{kind.maximum}"  # the first that is too new')
            made += ['platforms = ["linux-x64"]', f'wheels = ["./wheels/{wheel.name}"]']
        elif not line.startswith("# What Blender must know"):
            made.append(line)
    return "\n".join(made) + "\n"


def make(kind):
    """Makes a kind's zip and returns its path."""
    wheel = kind.finished_wheel
    source = BUILD / "zip" / kind.name
    shutil.rmtree(source, ignore_errors=True)
    for path in reached_files():
        target = source / path.relative_to(ADDON)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(path, target)
    (source / "wheels").mkdir()
    shutil.copy2(wheel, source / "wheels")
    shutil.copy2(ROOT / "LICENSE", source)
    (source / "blender_manifest.toml").write_text(manifest(kind, wheel))
    DIST.mkdir(exist_ok=True)
    kind.zip_path.unlink(missing_ok=True)
    blender_extension("build", "--source-dir", source, "--output-filepath", kind.zip_path)
    blender_extension("validate", kind.zip_path)
    return kind.zip_path


def main():
    path = make(KINDS[sys.argv[1]])
    print(f"    {path.relative_to(ROOT)}: {path.stat().st_size / 2**20:.1f} MiB")


if __name__ == "__main__":
    main()
