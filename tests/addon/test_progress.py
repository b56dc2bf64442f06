# SPDX-License-Identifier: GPL-3.0-or-later
"""Progress on a terminal and in a log, and keeping libraries' own output apart."""

import io
import os

import pytest
from nephele import noise, progress
from nephele.errors import InputError


class Terminal(io.StringIO):
    def isatty(self):
        return True


def report(done, seconds, error=None):
    return {"samples_done": done, "samples": 8, "fraction": done / 8, "seconds": seconds, "error": error}


def show_all(reporter):
    reporter.begin("Frame 3")
    for step in range(3):
        reporter.show(report(4 + step, 10.0 * step))
    reporter.say("done")


def test_a_terminal_shows_one_line_that_ends_clean():
    stream = Terminal()
    show_all(progress.Reporter(stream=stream))
    assert stream.getvalue().count("\n") == 1
    assert stream.getvalue().endswith("\r\x1b[Kdone\n")
    # Resumed at half: 20 s for a quarter of the whole, so the last quarter takes 20 s more.
    assert "Frame 3: 6/8 samples, 75 %, 20 s, 20 s left" in stream.getvalue()


def test_a_log_gets_a_line_now_and_then(monkeypatch):
    now = iter((0.0, 0.0, 1.0, 6.0, 6.0, 8.0))
    monkeypatch.setattr(progress.time, "monotonic", lambda: next(now))
    stream = io.StringIO()
    show_all(progress.Reporter(stream=stream))
    assert stream.getvalue() == "Frame 3: 5/8 samples, 62 %, 10 s, 30 s left\ndone\n"


def test_the_error_is_told_where_it_is_known():
    stream = Terminal()
    reporter = progress.Reporter(stream=stream)
    reporter.begin("Rendering")
    reporter.show(report(0, 0.0))
    reporter.show(report(4, 10.0, 0.01234))
    assert "Rendering: 4/8 samples, 50 %, error 0.012, 10 s, 10 s left" in stream.getvalue()


def test_quiet_writes_nothing():
    stream = Terminal()
    show_all(progress.Reporter(quiet=True, stream=stream))
    assert stream.getvalue() == ""


@pytest.mark.parametrize(
    ("seconds", "text"), [(3.21, "3.2 s"), (59.4, "59 s"), (59.7, "1:00"), (125, "2:05"), (3725, "1:02:05")]
)
def test_duration(seconds, text):
    assert progress.duration(seconds) == text


def test_library_output_is_dropped_unless_the_program_fails(capfd):
    with noise.hidden():
        os.write(1, b"Read blend")
        os.write(2, b"EGL_BAD_MATCH")
    with pytest.raises(InputError), noise.hidden():
        os.write(2, b"Malloc returns null")
        raise InputError("file: damaged")
    assert capfd.readouterr() == ("", "")
    with pytest.raises(ZeroDivisionError), noise.hidden():
        os.write(1, b"last words")
        raise ZeroDivisionError
    assert capfd.readouterr() == ("", "last words")
    os.write(1, b"after")
    assert capfd.readouterr().out == "after"
