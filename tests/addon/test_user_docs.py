# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/user: links lead somewhere, pictures are small, and nothing that the panels show is left out."""

import re
from pathlib import Path

import pytest
from nephele import preset_files, render_panels

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted((ROOT / "docs" / "user").glob("*.md"))
LARGEST = 200_000  # bytes of a picture


def text_of(name):
    return (ROOT / "docs" / "user" / name).read_text(encoding="utf-8")


@pytest.mark.parametrize("page", [ROOT / "README.md", *PAGES], ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    links = re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8"))
    missing = [link for link in links if not link.startswith("http") and not (page.parent / link).exists()]
    assert missing == []


def test_the_index_has_every_page():
    index = text_of("README.md")
    assert [page.name for page in PAGES if page.name != "README.md" and f"({page.name})" not in index] == []


def test_pictures_are_small_and_shown():
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    for picture in (ROOT / "docs" / "images" / "user").iterdir():
        assert picture.stat().st_size < LARGEST, picture
        assert f"images/user/{picture.name})" in text, picture


def test_panels_are_explained():
    text = text_of("panels.md")
    labels = [cls.bl_label for cls in render_panels.CLASSES if cls.bl_label not in ("Compositor",)]
    assert [label for label in labels if f"*{label}" not in text] == []


def test_presets_are_explained():
    text = text_of("presets.md")
    for name in preset_files.NAMES:
        row = next(line for line in text.splitlines() if line.startswith(f"| {name} "))
        stated = preset_files.stated(preset_files.find(name))
        assert all(str(value) in row for value in stated.values() if not isinstance(value, bool)), row
