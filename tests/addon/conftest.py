# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line on the fakes of fake_native.py, in this process."""

import sys

import fake_native
import pytest
from nephele import cli, description_file


@pytest.fixture
def run(monkeypatch, capfd):
    """Returns a function that runs the command line and returns (exit code, stdout, stderr)."""
    monkeypatch.setitem(sys.modules, "nephele.bridge", fake_native.bridge())

    def call(*arguments):
        code = cli.main([str(argument) for argument in arguments])
        sys.stdout.flush()
        captured = capfd.readouterr()
        return code, captured.out, captured.err

    return call


@pytest.fixture
def scene_file(tmp_path):
    """Returns the path of a description file of fake_native.scene()."""
    path = tmp_path / "scene.nephele"
    description_file.save(path, fake_native.scene())
    return path
