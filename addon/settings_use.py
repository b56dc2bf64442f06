# SPDX-License-Identifier: GPL-3.0-or-later
"""Which settings count, given the others: what the panels grey out. Knows neither bpy nor the native
module."""


def _guides(s):
    return s.integrator == "path" and s.distance_sampling != "delta"


def _guides_camera_rays(s):
    return _guides(s) and s.vsp_primary


def _has_field(s):
    return s.integrator == "path" and s.train_field != "never"


def _guides_later(s):
    return _has_field(s) and s.vsp_secondary and s.distance_sampling == "vspg"


def _learns(s):
    """Whether anything asks for a learned probability of scattering."""
    return _guides_camera_rays(s) or _guides_later(s)


def _resamples(s):
    """Whether any segment is sampled by volume scattering probability guiding."""
    return s.distance_sampling == "vspg" and _learns(s)


def _is_path(s):
    return s.integrator == "path"


# Name of a setting -> whether it counts, of an object with the settings as attributes. Others always do.
CONDITIONS = {
    "adaptive_sampling": lambda s: s.target_error > 0,
    "estimate_error": lambda s: s.target_error == 0,  # always on with one
    "distance_sampling": _is_path,
    "vsp_primary": _guides,
    "vsp_criterion": _learns,
    "vsp_control": _resamples,
    "vsp_defensive": lambda s: _resamples(s) and s.vsp_control == "exact",
    "vsp_cost": _learns,
    "vsp_product": _resamples,
    "vsp_gather": _resamples,
    "vsp_target": _guides_camera_rays,
    "train_field": _is_path,
    "guide_directions": _has_field,
    "vsp_secondary": lambda s: _has_field(s) and s.distance_sampling == "vspg",
    "guided_roulette": _has_field,
    "guiding_memory": _has_field,
    "tracking": _is_path,
    "transmittance": _is_path,
    "filter_width": lambda s: s.pixel_filter != "box",
}


def is_used(name, settings):
    """Returns whether the setting `name` counts. settings: an object with all of them as attributes."""
    condition = CONDITIONS.get(name)
    return condition is None or condition(settings)
