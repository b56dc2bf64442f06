# SPDX-License-Identifier: GPL-3.0-or-later
"""What of a scene is approximated or left out, by what it concerns: read off the warnings of export and
build, which begin with it ("material 'Glass', node 'Bevel': ..."). Knows neither bpy nor the native
module."""

import re
from dataclasses import dataclass

# Kinds of things that warnings begin with. "scene" stands for what concerns no single one.
OBJECT_KINDS = ("object", "volume", "fluid domain", "camera")
KINDS = (*OBJECT_KINDS, "light", "material", "world", "view layer", "scene")
NAMED = re.compile(rf"({'|'.join(KINDS)}) '(.+?)'(?:, node '(.+?)')?:? (.+)", re.IGNORECASE | re.DOTALL)


@dataclass(frozen=True)
class Issue:
    """One warning. kind: of KINDS. name: of the thing, "" for the scene. node: of its tree, or ""."""

    kind: str
    name: str
    node: str
    text: str


def issue(warning):
    """Returns the Issue of a warning."""
    match = NAMED.fullmatch(warning)
    if match is None:
        return Issue("scene", "", "", warning)
    kind, name, node, text = match.groups()
    return Issue(kind.lower(), name, node or "", text)


def by_owner(warnings):
    """Returns {(kind, name): [Issue]} in the order of first appearance."""
    found = {}
    for one in map(issue, warnings):
        found.setdefault((one.kind, one.name), []).append(one)
    return found


def text_lines(warnings):
    """Returns the lines of the list for people: things, and indented what is said of each."""
    lines = []
    for (kind, name), issues in by_owner(warnings).items():
        lines.append(f"{kind} '{name}'" if name else kind)
        lines += [f"  {f'node {one.node!r}: ' if one.node else ''}{one.text}" for one in issues]
    return lines
