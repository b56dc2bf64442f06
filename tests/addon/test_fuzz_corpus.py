# SPDX-License-Identifier: GPL-3.0-or-later
"""Inputs that once made a fuzz target of Python fail (tests/fuzz/corpus), replayed."""

import importlib
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).resolve().parents[1]
FUZZ = TESTS / "fuzz"
INPUTS = [path for kind in ("description", "archive") for path in sorted((FUZZ / "corpus" / kind).iterdir())]


@pytest.fixture(scope="module", autouse=True)
def folders():
    """Lets the targets find their modules."""
    added = [str(FUZZ), str(TESTS / "render")]
    sys.path[:0] = added
    yield
    for folder in added:
        sys.path.remove(folder)


def test_the_scenes_to_start_from_are_good():
    import nephele_native

    for scene in importlib.import_module("scenes").all_scenes():
        nephele_native.Renderer(scene)


@pytest.mark.parametrize("path", INPUTS, ids=lambda path: f"{path.parent.name}-{path.name}")
def test_replay(path):
    importlib.import_module(f"fuzz_{path.parent.name}").test_one(path.read_bytes())
