# SPDX-License-Identifier: GPL-3.0-or-later
"""Colour of light of one wavelength: the CIE 1931 observer in linear Rec. 709, as Blender's Wavelength node
scales it.

Blender's table has steps of 5 nm from 380 to 780 nm and nothing outside.
"""

import numpy as np

from .blackbody import OBSERVER, REC709_FROM_XYZ

FIRST_NM, LAST_NM = 380.0, 780.0
BRIGHTEST = 2.52  # what Blender divides by, so that no channel exceeds about 1

# x, y, z of the 2 degree observer between the entries of blackbody.OBSERVER: at 385, 395 ... 755 nm.
_BETWEEN = (
    (0.0022, 0.0001, 0.0105), (0.0076, 0.0002, 0.0362), (0.0232, 0.0006, 0.1102), (0.0776, 0.0022, 0.3713),
    (0.2148, 0.0073, 1.0391), (0.3285, 0.0168, 1.6230), (0.3481, 0.0298, 1.7826), (0.3187, 0.0480, 1.7441),
    (0.2511, 0.0739, 1.5281), (0.1421, 0.1126, 1.0419), (0.0580, 0.1693, 0.6162), (0.0147, 0.2586, 0.3533),
    (0.0024, 0.4073, 0.2123), (0.0291, 0.6082, 0.1117), (0.1096, 0.7932, 0.0573), (0.2257, 0.9149, 0.0298),
    (0.3597, 0.9803, 0.0134), (0.5121, 1.0000, 0.0057), (0.6784, 0.9786, 0.0027), (0.8425, 0.9154, 0.0018),
    (0.9786, 0.8163, 0.0014), (1.0567, 0.6949, 0.0010), (1.0456, 0.5668, 0.0006), (0.9384, 0.4412, 0.0002),
    (0.7514, 0.3210, 0.0001), (0.5419, 0.2170, 0.0000), (0.3608, 0.1382, 0.0000), (0.2187, 0.0816, 0.0000),
    (0.1212, 0.0446, 0.0000), (0.0636, 0.0232, 0.0000), (0.0329, 0.0119, 0.0000), (0.0158, 0.0057, 0.0000),
    (0.0081, 0.0029, 0.0000), (0.0041, 0.0015, 0.0000), (0.0020, 0.0007, 0.0000), (0.0010, 0.0004, 0.0000),
    (0.0005, 0.0002, 0.0000), (0.0002, 0.0001, 0.0000),
)  # fmt: skip
_BEYOND = ((0.0001, 0.0000, 0.0000),) * 3 + ((0.0000, 0.0000, 0.0000),)  # 765 to 780 nm


def spectrum():
    """Returns (81, 3): the colours from FIRST_NM to LAST_NM in steps of 5 nm, negative outside Rec. 709."""
    observer = np.empty((81, 3))
    observer[0:77:2], observer[1:76:2], observer[77:] = OBSERVER, _BETWEEN, _BEYOND
    return observer @ REC709_FROM_XYZ.T / BRIGHTEST
