# SPDX-License-Identifier: GPL-3.0-or-later
"""What the extension packs: nothing that Blender's Python lacks is imported by it."""

import sys
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from nephele.export import plain_exr

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
    assert {"engine.py", "images.py", "plain_exr.py"} <= names
    assert {"sky_bake.py", "Preview.py", "Benchmark.py"} <= names  # run or read by path
    assert "exr.py" not in names


@pytest.mark.parametrize("size", [(1, 1), (3, 5), (40, 7)])
def test_plain_exr_is_read_back(tmp_path, size):
    pixels = np.random.default_rng(3).standard_normal((*size, 4)).astype(np.float32)
    path = tmp_path / "plain.exr"
    plain_exr.write_rgba(path, pixels)
    with OpenEXR.File(str(path)) as file:
        np.testing.assert_array_equal(file.channels()["RGBA"].pixels, pixels)
