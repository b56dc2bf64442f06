# SPDX-License-Identifier: GPL-3.0-or-later
"""What must hold wherever the extension rendered by turns with Cycles."""

from pathlib import Path

import numpy as np

# Libraries that Blender has of its own in some version; ours carry a hash in their names.
TWINS = ("libembree", "libopenvdb", "libImath", "libblosc")


def check_turns(pictures, reference):
    """Nephele's pictures are the reference's, bit by bit, before and after Cycles; Cycles' own do not
    change."""
    np.testing.assert_array_equal(pictures["nephele_first"], reference)
    np.testing.assert_array_equal(pictures["nephele_second"], reference)
    assert pictures["cycles_before"].mean() > 0.1
    np.testing.assert_array_equal(pictures["cycles_between"], pictures["cycles_before"])
    np.testing.assert_array_equal(pictures["cycles_after"], pictures["cycles_before"])


def check_alike(picture, other):
    """Two pictures of the same paths by two processors' or C libraries' arithmetic: the paths that a last
    bit sends elsewhere are few. Measured: 0.83 of the pixels agree between glibc 2.36 and 2.41, 0.95 between
    x86-64-v3 and a processor with AVX-512, none between two seeds."""
    scale = np.maximum(other.max(axis=-1), 1e-3)
    agree = np.abs(picture - other).max(axis=-1) < 1e-3 * scale
    assert agree.mean() > 0.7, agree.mean()


def check_report(told, resources):
    """Both renders went well, by the native module of the extension, with one oneTBB in the process."""
    assert told["states"] == [["done", "", []]] * 2
    assert Path(told["native"]).is_relative_to(resources)
    libraries = [Path(path) for path in told["libraries"]]
    assert len([path for path in libraries if path.name.startswith("libtbb.so.12")]) == 1
    ours = [path for path in libraries if path.is_relative_to(resources)]
    for stem in TWINS:
        assert any(path.name.startswith(stem) for path in ours), f"no {stem} of ours is loaded"
