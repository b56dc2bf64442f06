# SPDX-License-Identifier: GPL-3.0-or-later
"""What the extension packs: nothing that Blender's Python lacks is imported by it."""

import sys
from pathlib import Path

import pytest

TOOLS = Path(__file__).resolve().parents[2] / "tools" / "extension"


@pytest.fixture
def reach(monkeypatch):
    """Returns the module that finds the files that Blender needs."""
    monkeypatch.syspath_prepend(str(TOOLS))
    import reach

    yield reach
    for name in ("reach", "kinds"):
        sys.modules.pop(name, None)


def test_blender_has_all_that_the_extension_imports(reach):
    names = {path.name for path in reach.reached_files()}
    assert {"engine.py", "images.py"} <= names
    assert {"sky_bake.py", "Preview.py", "Benchmark.py"} <= names  # run or read by path
    assert "exr.py" not in names
