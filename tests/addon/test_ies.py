# SPDX-License-Identifier: GPL-3.0-or-later
"""IES profiles: what is read, what symmetry fills in, and what is refused."""

import numpy as np
import pytest
from nephele.export.ies import HEIGHT, WIDTH, BadProfile, parse, picture


def profile(vertical, horizontal, candela, kind=1, factor=1, tilt="NONE", ballast=1):
    lines = ["IESNA:LM-63-2002", "[MANUFAC] none", f"TILT={tilt}"]
    lines.append(f"1 -1 {factor} {len(vertical)} {len(horizontal)} {kind} 2 0 0 0 {ballast} 1 0")
    lines += [" ".join(map(str, row)) for row in (vertical, horizontal, *candela)]
    return "\n".join(lines)


def test_round_profile():
    image = picture(profile([0, 90, 180], [0], [[100, 50, 0]], factor=2, ballast=0.5))
    assert image.shape == (HEIGHT, WIDTH)
    assert np.allclose(image[[0, 90, 180]], np.array([[100], [50], [0]]))
    assert np.allclose(image[:, :1], image)  # the same all the way round


@pytest.mark.parametrize(
    ("horizontal", "expected"),
    [
        ([0, 90], [10, 30, 10, 30, 10]),
        ([0, 90, 180], [10, 30, 50, 30, 10]),
        ([0, 90, 180, 270, 360], [10, 30, 50, 20, 10]),
    ],
)
def test_symmetry_fills_the_circle(horizontal, expected):
    values = {0: 10, 90: 30, 180: 50, 270: 20, 360: 10}
    image = picture(profile([0, 45, 90], horizontal, [[values[h]] * 3 for h in horizontal]))
    assert np.allclose(image[45, [0, 90, 180, 270, 360]], expected)
    assert np.all(image[91:] == 0)  # nothing above the last angle


def test_type_b_has_its_poles_on_the_side():
    """A profile as bright as the height over the plane across the poles' axis."""
    angles = list(range(-90, 91, 10))
    image = picture(profile(angles, angles, [[v + 90 for v in angles]] * len(angles), kind=2))
    assert image[0, 0] == pytest.approx(90)  # straight down lies between the poles
    assert image[90, 90] == pytest.approx(180, rel=1e-3)
    assert image[90, 270] == pytest.approx(0, abs=1e-3)


def test_tilt_tables_are_skipped():
    text = profile([0, 90], [0], [[7, 7]], tilt="INCLUDE\n1\n2\n0 90\n1 1")
    assert np.allclose(picture(text)[[0, 90]], 7)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("", "begin"),
        ("IESNA", "TILT"),
        (profile([0, 90], [0], [[1, 1]])[:-1].rsplit("\n", 1)[0], "early"),
        (profile([90, 0], [0], [[1, 1]]), "grow"),
        (profile([0, 90], [0], [["x", 1]]), "text"),
        (profile([0, 90], [0], [[1, 1]], kind=7), "type"),
    ],
)
def test_bad_profiles(text, reason):
    with pytest.raises(BadProfile, match=reason):
        parse(text)


def test_a_missing_profile_warns(bpy, link, export):
    item = link("Lamp", bpy.data.lights.new("Lamp", "POINT"))
    item.data.use_nodes = True
    tree = item.data.node_tree
    node = tree.nodes.new("ShaderNodeTexIES")
    tree.links.new(node.outputs[0], tree.nodes["Emission"].inputs["Strength"])
    node.mode, node.filepath = "EXTERNAL", "/no/such/file.ies"
    scene = export()
    assert any("light 'Lamp', node 'IES Texture'" in text for text in scene.warnings)
    assert scene.lights[0].power == (0.0, 0.0, 0.0)
