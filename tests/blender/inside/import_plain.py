# SPDX-License-Identifier: GPL-3.0-or-later
"""Imports a wheel whose libraries were not made private, in a Blender with an Embree of its own in global
scope.

Argument: the wheel. Prints what the import says, and leaves without Blender's own end: with two versions of
its libraries bound to each other Blender 4.3 crashes there, which is why such a wheel is refused.
"""

import os
import sys
import tempfile
import zipfile

with tempfile.TemporaryDirectory() as folder:
    zipfile.ZipFile(sys.argv[sys.argv.index("--") + 1]).extractall(folder)
    sys.path.insert(0, folder)
    try:
        import nephele_native  # noqa: F401
    except ImportError as fault:
        print(f"refused: {fault}")
sys.stdout.flush()
os._exit(0)
