# SPDX-License-Identifier: GPL-3.0-or-later
"""The error of a render as the command line, its page and Blender's panel tell it."""

import json
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from nephele import checkpoint, report

MARKS = [
    {"seconds": 0.5 * n, "cpu_seconds": 1.0 * n, "samples": n, "error": 0.4 / n}
    for n in (2, 4, 8, 16, 32, 64)
]


def told(marks=MARKS, reached=False):
    return {"errors": marks, "samples_done": 64, "target_reached": reached}


def page(**changes):
    combined = np.random.default_rng(3).random((4, 6, 4), np.float32)
    return report.page("a <b>.exr", told(**changes), combined, {"settings": {"samples": 64}})


def test_slope_is_that_of_a_power_law():
    assert report.slope(MARKS) == pytest.approx(-1)
    steeper = [mark | {"error": mark["samples"] ** -1.5} for mark in MARKS]
    assert report.slope(steeper) == pytest.approx(-1.5)
    assert report.slope(MARKS[:5]) is None, "two marks from 16 samples on are no line"


def test_page_is_one_file_with_plots_and_figures():
    text = page()
    assert "http" not in text.replace("http://www.w3.org", "")
    assert "a &lt;b&gt;.exr" in text
    assert "estimated error 0.00625 after 64 samples per pixel, 32.0 s (64.0 CPU s)" in text
    assert "error proportional to samples^-1.00" in text
    assert text.count("<svg") == 2
    for svg in re.findall(r"<svg.*?</svg>", text):
        root = ElementTree.fromstring(svg)
        lines = [line.get("points").split() for line in root.iter("polyline")]
        assert [len(points) for points in lines] == [6, 6]
        assert lines[0][-1] == lines[1][-1], "the ideal line ends where the measured one does"
        for x, y in (map(float, point.split(",")) for point in lines[0]):
            assert 0 <= x <= report.WIDTH
            assert 0 <= y <= report.HEIGHT
    assert text.count("<tr>") == 1 + len(MARKS) + 2
    assert "the target is reached" in page(reached=True)


@pytest.mark.parametrize("marks", [[], MARKS[:1], [MARKS[0] | {"error": float("inf")}]])
def test_page_of_a_render_too_short_for_a_plot(marks):
    text = page(marks=marks)
    assert "<svg" not in text
    assert "64 samples per pixel" in text or "after 2 samples" in text


def test_render_writes_a_report(run, scene_file, tmp_path):
    out, html, stats = (tmp_path / name for name in ("a.exr", "a.html", "a.json"))
    arguments = ("render", scene_file, "-o", out, "--report", html, "--stats", stats, "--samples", 64)
    code, _, stderr = run(*arguments)
    assert code == 0
    assert "64 samples, " in stderr
    assert "estimated error 0.0156" in stderr
    assert "<svg" in html.read_text()
    content = json.loads(stats.read_text())
    assert content["settings"]["estimate_error"] is True
    assert content["errors"][-1]["samples"] == 64
    code, _, stderr = run("render", scene_file, "--save-description", tmp_path / "b", "--report", html)
    assert code == 2
    assert "--report needs an image" in stderr
    code, _, stderr = run("render", scene_file, "-o", out, "--report", tmp_path / "a.txt")
    assert code == 2
    assert ".html" in stderr


def test_render_stops_at_the_target_error_and_is_complete(run, scene_file, tmp_path):
    out, stats = tmp_path / "a.exr", tmp_path / "a.json"
    arguments = ("render", scene_file, "-o", out, "--stats", stats, "--samples", 1000)
    code, _, stderr = run(*arguments, "--target-error", 0.1)
    assert code == 0
    assert "10 of 1000 (target error reached) samples" in stderr
    assert json.loads(stats.read_text())["target_reached"] is True
    assert not checkpoint.path_for(out).exists()
    code, _, stderr = run(*arguments, "--target-error", 0.1, "--resume")
    assert (code, "complete already" in stderr) == (0, True)
    code, _, stderr = run(*arguments, "--target-error", 0.05, "--resume")
    assert (code, "does not exist; starting at the first sample" in stderr) == (0, True)
    code, _, stderr = run(*arguments, "--target-error", -1)
    assert code == 2
    assert "target_error" in stderr


def test_panel_tells_of_the_last_render(bpy):
    from nephele import engine, render_panels

    assert render_panels.report_lines(None) == ["Nothing was rendered yet"]
    record = engine.RenderRecord(3, "Main", "done", seconds={"render": 1.5}, statistics=told())
    lines = render_panels.report_lines(record)
    assert lines[:3] == ["Frame 3, Main: done", "Render: 1.50 s", "Samples: 64"]
    assert lines[3] == "Error after 2 samples, 0:01: 0.2"
    assert lines[-1] == "Error after 64 samples, 0:32: 0.00625"
    record.statistics = told([])
    assert render_panels.report_lines(record)[-1] == "Error: not estimated (Stop at an Error, Estimate Error)"
    record.statistics = told(reached=True)
    assert render_panels.report_lines(record)[-1] == "The target error is reached"
