# SPDX-License-Identifier: GPL-3.0-or-later
"""Nephele's renderer, and what it asks of Python and the processor.

Both are asked before the renderer loads: a processor that lacks an instruction ends the process without a
word.
"""

import sys
from pathlib import Path

from ._built_for import FIRST_PYTHON, LAST_PYTHON, PROCESSOR

LEVELS = {  # level of processor -> what /proc/cpuinfo calls the instructions it has beyond plain x86-64
    "x86-64-v2": ("cx16", "lahf_lm", "popcnt", "sse4_1", "sse4_2", "ssse3"),
    "x86-64-v3": ("abm", "avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "movbe", "popcnt", "sse4_2"),
}


def missing_instructions(cpuinfo, level):
    """Returns those of a level's instructions that the text of /proc/cpuinfo lacks; none where the level is
    not in LEVELS (a build for one machine) or the text has no flags."""
    for line in cpuinfo.splitlines():
        name, _, flags = line.partition(":")
        if name.strip() == "flags":
            return sorted(set(LEVELS.get(level, ())) - set(flags.split()))
    return []


def _require(python, cpuinfo):
    """Raises ImportError where the module cannot run."""
    if not FIRST_PYTHON <= python <= (LAST_PYTHON or python):
        built = ".".join(map(str, FIRST_PYTHON)) + ("" if LAST_PYTHON else " and newer")
        here = ".".join(map(str, python))
        raise ImportError(f"this is the build for Python {built}, and this Blender has Python {here}")
    lacking = missing_instructions(cpuinfo, PROCESSOR)
    if lacking:
        raise ImportError(
            f"this processor lacks {', '.join(lacking)}, and this build needs one of level {PROCESSOR} "
            "(Intel from 2013, AMD from 2015 on)"
        )


_require(sys.version_info[:2], Path("/proc/cpuinfo").read_text(errors="replace"))

from .nephele_native import *  # noqa: E402, F403
from .nephele_native import __version__  # noqa: E402, F401
