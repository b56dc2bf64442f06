# SPDX-License-Identifier: GPL-3.0-or-later
"""The ways to render that benchmarks compare: Nephele's methods as settings, and other programs."""

from nephele.errors import InputError


def vspg(control, criterion="variance", **extensions):
    """Returns the settings of VSP guiding with only the named extensions on."""
    off = {"vsp_cost": False, "vsp_product": False, "vsp_gather": False, "train_field": "never"}
    return (
        {"distance_sampling": "vspg", "vsp_control": control, "vsp_criterion": criterion} | off | extensions
    )


def field(**techniques):
    """Returns the settings of the guiding field used always, for the named techniques only."""
    off = dict.fromkeys(("guide_directions", "vsp_secondary", "guided_roulette"), False)
    return {"train_field": "always"} | off | techniques


NO_FIELD = {"train_field": "never"}
DELTA = "delta"
METHODS = {
    DELTA: {"distance_sampling": "delta", **NO_FIELD},
    "nds": {"distance_sampling": "nds", **NO_FIELD},
    "nds_plus": {"distance_sampling": "nds_plus", **NO_FIELD},
    "exact_contribution": vspg("exact", "contribution"),
    "exact_variance": vspg("exact"),
    "conditional": vspg("conditional"),
    "conditional_cost": vspg("conditional", vsp_cost=True),
    "conditional_product": vspg("conditional", vsp_product=True),
    "conditional_gather": vspg("conditional", vsp_gather=True),
    "vspg": {"distance_sampling": "vspg", **NO_FIELD},
    "directions": field(guide_directions=True),
    "segments": field(vsp_secondary=True),
    "directions_segments": field(guide_directions=True, vsp_secondary=True),
    "everything": field(guide_directions=True, vsp_secondary=True, guided_roulette=True),
    "auto": {},  # as users get it
}
OTHERS = ("cycles", "cycles_guided", "mitsuba")  # other programs; cycles_guided: with its path guiding


def checked(names, known, option):
    """Returns the names without repetition. Raises InputError for one that is not known."""
    for name in names:
        if name not in known:
            raise InputError(f"{option}: nothing is called '{name}'; there are {', '.join(known)}")
    return tuple(dict.fromkeys(names))
