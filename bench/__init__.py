# SPDX-License-Identifier: GPL-3.0-or-later
"""Measuring: Nephele against Cycles, and parts of Nephele against each other."""
