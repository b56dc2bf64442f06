# SPDX-License-Identifier: GPL-3.0-or-later
"""Stiff and extreme cases, one row of a table each: `make stress` runs all of them, `make test` the quick
ones. See judge.py for what is asked of each."""

import importlib

import pytest
from judge import Case, judge, refuse

TABLES = (
    "coefficients",
    "densities",
    "transforms",
    "scales",
    "lamps",
    "meshes",
    "guides",
    "rays",
    "pictures",
    "combinations",
    "refusals",
)


def rows():
    for table in TABLES:
        for case in importlib.import_module(f"{table}_cases").CASES:
            for i, way in enumerate(case.ways if isinstance(case, Case) else ("refused",)):
                marks = () if case.quick and i == 0 else (pytest.mark.stress,)
                yield pytest.param(case, way, marks=marks, id=f"{table}-{case.name}-{way}".replace("\n", " "))


@pytest.mark.parametrize(("case", "way"), list(rows()))
def test_extreme(case, way, record_property):
    if isinstance(case, Case):
        judge(case, way, record_property)
    else:
        refuse(case, record_property)
