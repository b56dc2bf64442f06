# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of shader nodes: it lists every node of Blender, agrees with the compiler, and docs/nodes.md
with it."""

from pathlib import Path

import pytest
from nephele.export import node_support
from nephele.export.nodes import HANDLERS, VOLUME_HANDLERS
from nephele.export.nodes_closure import SIMPLE

TABLE = {key: node for nodes in node_support.NODES.values() for key, node in nodes.items()}
# Nodes that are followed by other means than a handler of values or a closure of their own.
STRUCTURE = {"GROUP", "MIX_SHADER", "ADD_SHADER", "OUTPUT_MATERIAL", "OUTPUT_WORLD", "OUTPUT_LIGHT"}
VOLUMES = {"VOLUME_ABSORPTION", "VOLUME_COEFFICIENTS", "PRINCIPLED_VOLUME", "VOLUME_SCATTER"}


@pytest.fixture
def nodes(bpy):
    """Returns identifier -> node of every kind that Blender can make."""
    tree = bpy.data.materials.new("All").node_tree
    made = {}
    for name in dir(bpy.types):
        if name.startswith("ShaderNode"):
            try:
                made[name.removeprefix("ShaderNode")] = tree.nodes.new(name)
            except RuntimeError:  # base classes
                continue
    return made


def test_table_lists_every_node(nodes):
    assert {key: node.label for key, node in TABLE.items()} == {k: n.bl_label for k, n in nodes.items()}


def test_table_agrees_with_the_compiler(nodes):
    compiled = HANDLERS.keys() | VOLUME_HANDLERS.keys() | SIMPLE.keys() | STRUCTURE | VOLUMES
    for key, node in TABLE.items():
        assert (nodes[key].type in compiled) == (node.state != node_support.UNSUPPORTED), key


def test_what_is_not_simply_supported_says_why():
    for key, node in TABLE.items():
        assert node.state == node_support.SUPPORTED or node.note, key


def test_page_is_up_to_date():
    path = Path(__file__).resolve().parents[2] / "docs" / "nodes.md"
    assert path.read_text(encoding="utf-8") == node_support.page(), "run tools/generate_node_page.py"
