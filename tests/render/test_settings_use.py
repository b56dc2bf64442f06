# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels grey out does not count: changing it leaves every bit of the image."""

from types import SimpleNamespace

import numpy as np
import pytest
from nephele import parameters, settings_use
from small_world import small_world

# Settings under which others are idle. Together they reach every condition of settings_use.py.
STATES = (
    {"integrator": "plain"},
    {"distance_sampling": "delta", "train_field": "never"},
    {"distance_sampling": "nds_plus", "train_field": "always"},
    {"vsp_primary": False, "train_field": "never"},
    {"vsp_primary": False, "vsp_secondary": False, "train_field": "always"},
    {"pixel_filter": "box", "vsp_control": "conditional"},
    {"target_error": 0.5, "train_field": "always"},
)
ONE_THREAD = {"threads": 1, "size": 12, "samples": 8}


def idle(state):
    """Returns the names of what does not count under these settings."""
    settings = SimpleNamespace(**parameters.checked(state))
    return {name for name in settings_use.CONDITIONS if not settings_use.is_used(name, settings)}


def others(state, name):
    """Returns another value of a setting: of numbers one that is smaller."""
    parameter = parameters.BY_NAME[name]
    value = state.get(name, parameter.default)
    if parameter.kind == "enum":
        return next(item[0] for item in parameter.items if item[0] != value)
    if parameter.kind == "bool":
        return not value
    return parameter.checked(value / 4)


def test_states_reach_every_condition():
    """`estimate_error` is idle with a target error, `adaptive_sampling` without one."""
    assert set().union(*map(idle, STATES)) == set(settings_use.CONDITIONS)
    assert "samples" not in set().union(*map(idle, STATES))


@pytest.mark.parametrize("state", STATES, ids=lambda state: " ".join(map(str, state.values())))
def test_what_is_greyed_out_does_not_count(state):
    scene = small_world()
    image = scene.render(**ONE_THREAD, **state)["Combined"]
    changed = state | {name: others(state, name) for name in idle(state)}
    np.testing.assert_array_equal(scene.render(**ONE_THREAD, **changed)["Combined"], image)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("vsp_criterion", "contribution"),
        ("vsp_control", "exact"),
        ("vsp_product", False),
        ("filter_width", 3.0),
    ],
)
def test_what_is_not_greyed_out_may_count(name, value):
    """The other test would pass if these never counted."""
    scene = small_world()
    image = scene.render(**ONE_THREAD | {"samples": 32})["Combined"]
    assert np.any(scene.render(**ONE_THREAD | {"samples": 32}, **{name: value})["Combined"] != image)
