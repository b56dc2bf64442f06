# SPDX-License-Identifier: GPL-3.0-or-later
"""What is taken over of a scene that was made for Cycles."""

import pytest
from nephele import cycles_settings, parameters


@pytest.fixture
def cycles(bpy):
    """Returns Cycles' settings of the scene; the add-on comes with Blender."""
    if not hasattr(bpy.context.scene, "cycles"):
        bpy.ops.preferences.addon_enable(module="cycles")
    return bpy.context.scene.cycles


def test_settings_are_copied(bpy, cycles):
    cycles.samples, cycles.seed, cycles.time_limit = 300, 5, 12.0
    cycles.max_bounces, cycles.volume_bounces = 20, 6
    cycles.diffuse_bounces, cycles.glossy_bounces, cycles.transmission_bounces = 3, 9, 7
    cycles.film_exposure, cycles.pixel_filter_type, cycles.filter_width = 1.5, "GAUSSIAN", 2.0
    assert bpy.ops.nephele.copy_cycles_settings() == {"FINISHED"}
    settings = bpy.context.scene.nephele
    assert (settings.samples, settings.seed, settings.time_limit) == (300, 5, 12.0)
    assert (settings.max_bounces, settings.volume_bounces, settings.surface_bounces) == (20, 6, 9)
    assert (settings.film_exposure, settings.pixel_filter, settings.filter_width) == (1.5, "gaussian", 2.0)


def test_values_out_of_our_range_are_brought_into_it(cycles):
    cycles.seed, cycles.film_exposure = -1, 0.0
    found = cycles_settings.of_cycles(cycles)
    assert (found["seed"], found["film_exposure"]) == (0, 0.0)
    assert parameters.checked(found)


def test_our_names_exist():
    known = {ours for ours, _ in cycles_settings.SAME}
    assert known - set(parameters.BY_NAME) <= {"denoise", "viewport_samples"}
