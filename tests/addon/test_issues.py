# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of what is approximated or left out: read off warnings, shown in a panel, printed by info."""

import ast
from pathlib import Path

import pytest
from nephele import engine, issue_panel, issues
from programs import with_nodes

EXPORT = Path(__file__).resolve().parents[2] / "addon" / "export"


def test_warning_is_read():
    found = issues.issue("material 'It's: one', node 'Bevel.001': bevel is not supported; it stays")
    assert found == issues.Issue("material", "It's: one", "Bevel.001", "bevel is not supported; it stays")
    assert issues.issue("View layer 'Fog' is not rendered") == issues.Issue(
        "view layer", "Fog", "", "is not rendered"
    )
    assert issues.issue("anything else: at all") == issues.Issue("scene", "", "", "anything else: at all")


def test_issues_of_one_thing_are_together():
    warnings = ("object 'A': one", "world 'W', node 'Sky': two", "object 'A': three", "four")
    assert issues.text_lines(warnings) == [
        "object 'A'", "  one", "  three", "world 'W'", "  node 'Sky': two", "scene", "  four",
    ]  # fmt: skip


def beginnings():
    """Yields (file, text) of how the exporter's warnings begin, where that is written in the call."""
    for path in sorted(EXPORT.glob("*.py")):
        for call in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)):
                continue
            if call.func.attr != "warn" or not isinstance(call.args[0], ast.JoinedStr):
                continue
            if isinstance(call.args[0].values[0], ast.Constant):
                yield path.name, call.args[0].values[0].value


def test_exporter_names_things_as_issues_reads_them():
    found = list(beginnings())
    assert len(found) > 5
    kinds = tuple(f"{kind} '" for kind in issues.KINDS)
    strange = [row for row in found if not row[1].startswith((*kinds, "the file's working colour space"))]
    assert strange == []


@pytest.fixture
def glass(bpy, link, camera):
    """Returns an object whose second slot is a material with a node that is not supported."""
    mesh = bpy.data.meshes.new("Mesh")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    item = link("Pane", mesh)
    for name in ("Plain", "Glass"):
        mesh.materials.append(with_nodes(bpy.data.materials.new(name)))
    mesh.polygons[0].material_index = 1
    tree = bpy.data.materials["Glass"].node_tree
    node = tree.nodes.new("ShaderNodeShaderToRGB")  # EEVEE alone can do it
    tree.links.new(node.outputs[0], tree.nodes["Principled BSDF"].inputs["Base Color"])
    return item


def go_to(bpy, warning):
    """Does what the button of a warning's issue does."""
    found = issues.issue(warning)
    return bpy.ops.nephele.go_to_issue(kind=found.kind, name=found.name, node=found.node)


def test_check_finds_what_a_render_would(bpy, glass):
    assert bpy.ops.nephele.check_scene() == {"FINISHED"}
    (warning,) = issue_panel.findings.warnings
    assert warning.startswith("material 'Glass', node 'Shader to RGB': ")
    assert go_to(bpy, warning) == {"FINISHED"}
    assert bpy.context.view_layer.objects.active == glass
    assert glass.active_material_index == 1
    assert glass.active_material.node_tree.nodes.active.name == "Shader to RGB"


def test_check_tells_why_there_is_no_picture(bpy):
    bpy.ops.nephele.check_scene()
    assert "has no camera" in issue_panel.findings.fault


def test_objects_and_lights_are_selected(bpy, link, camera):
    lamp = link("Lamp object", bpy.data.lights.new("Lamp data", "POINT"))
    ball = link("Ball", bpy.data.metaballs.new("Ball"))
    for warning, expected in (
        ("light 'Lamp data': one", lamp), ("object 'Ball': two", ball), ("light 'Lamp object': three", lamp),
    ):  # fmt: skip
        assert go_to(bpy, warning) == {"FINISHED"}
        assert bpy.context.view_layer.objects.active == expected
        assert bpy.context.selected_objects == [expected]


def test_what_is_gone_is_not_gone_to(bpy):
    assert go_to(bpy, "object 'Nothing': at all") == {"CANCELLED"}


def test_panel_shows_the_last_render(bpy):
    record = engine.RenderRecord(4, "Main", "failed", "no camera", warnings=["object 'A': one"])
    for listener in engine.listeners:
        listener(record)
    found = issue_panel.findings
    assert (found.origin, found.warnings, found.fault) == (
        "Last render, frame 4", ("object 'A': one",), "no camera",
    )  # fmt: skip
    for warning in ("object 'B': two", "object 'A': one"):  # of another layer, whose later render counts
        record = engine.RenderRecord(4, "Fog", "done", warnings=[warning])
        for listener in engine.listeners:
            listener(record)
    assert (issue_panel.findings.warnings, issue_panel.findings.fault) == (("object 'A': one",), "")
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    assert issue_panel.findings.origin == ""
