# SPDX-License-Identifier: GPL-3.0-or-later
"""Which grids a volume shader finds in the data that it shades, and of how many components each is."""

from dataclasses import dataclass

VECTOR_TYPES = {"VECTOR_FLOAT", "VECTOR_DOUBLE", "VECTOR_INT"}
UNREADABLE_TYPES = {"POINTS", "STRING", "UNKNOWN"}


@dataclass(frozen=True)
class Fire:
    """What a fluid domain's "temperature" means: in thousands of kelvin, `ignition` where flame begins,
    `hottest` where it is 1. (Its cache stores another grid of that name, the simulation's heat.)"""

    ignition: float
    hottest: float


@dataclass(frozen=True)
class Grids:
    """components: (name, 1 or 3) of each grid. fire: None but for fluid domains."""

    components: tuple = ()
    fire: Fire | None = None

    def count(self, name):
        """Returns the number of components of grid `name`, or None where there is none."""
        return dict(self.components).get(name)


DOMAIN_GRIDS = (("density", 1), ("flame", 1), ("temperature", 1), ("velocity", 3))


def volume_grids(data):
    """Returns the Grids of a Volume data-block whose file is loaded."""
    return Grids(
        tuple(
            (grid.name, 3 if grid.data_type in VECTOR_TYPES else 1)
            for grid in data.grids
            if grid.data_type not in UNREADABLE_TYPES
        )
    )


def domain_grids(settings):
    """Returns the Grids of a gas domain's cache."""
    return Grids(DOMAIN_GRIDS, Fire(settings.flame_ignition, settings.flame_max_temp))
