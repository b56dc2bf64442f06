# SPDX-License-Identifier: GPL-3.0-or-later
"""The zip for Python 3.11 in Blender's modules. Run by `make test-blender`, which makes them and the zips."""

import pytest
from checks import check_alike, check_report, check_turns
from hosts import MODULES
from turns import WORK, package, render_by_turns, without_blender

pytestmark = pytest.mark.blender


@pytest.mark.parametrize("host", MODULES, ids=lambda host: host.name)
def test_installs_and_renders_between_cycles(host, scene_for, from_venv):
    resources = WORK / host.name / "user"
    pictures, told = render_by_turns(host, package(host.kind), scene_for(host, "cloud"), resources)
    check_report(told, resources)
    check_turns(pictures, without_blender(host, from_venv[1]))
    check_alike(pictures["nephele_first"], from_venv[0])
