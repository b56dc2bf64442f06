# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a Python target under libFuzzer: `run.py fuzz_description [libFuzzer's options and corpora]`.

scripts/fuzz.sh preloads the sanitizers and puts the module that Clang built first in the path.
"""

import importlib
import sys
from pathlib import Path

import atheris

TESTS = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(TESTS / "fuzz"), str(TESTS / "render")]

with atheris.instrument_imports(include=["nephele"]):
    target = importlib.import_module(sys.argv.pop(1))

atheris.Setup(sys.argv, target.test_one)
atheris.Fuzz()
