# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render tells on stderr: on a terminal one line that updates itself, else a line now and then."""

import sys
import time

LINE_SECONDS = 5.0


class Reporter:
    """Writes messages and progress to `stream`; nothing where quiet."""

    def __init__(self, quiet=False, stream=None):
        self._quiet = quiet
        self._stream = stream or sys.stderr
        self._terminal = self._stream.isatty()
        self._last = time.monotonic()
        self._start_fraction = None
        self._line_open = False

    def say(self, text):
        """Writes a line of its own."""
        if self._quiet:
            return
        self._clear()
        print(text, file=self._stream, flush=True)

    def begin(self, label):
        """Starts a render; `label` leads its lines."""
        self._label = label
        self._start_fraction = None
        self._last = time.monotonic()

    def show(self, progress):
        """Shows the dict that Renderer.progress() returns, where it is time to."""
        if self._start_fraction is None:  # a resumed render starts in the middle
            self._start_fraction = progress["fraction"]
        if self._quiet:
            return
        if self._terminal:
            self._stream.write(f"\r\x1b[K{self._text(progress)}")
            self._stream.flush()
            self._line_open = True
        elif time.monotonic() - self._last >= LINE_SECONDS:
            self._last = time.monotonic()
            print(self._text(progress), file=self._stream, flush=True)

    def _text(self, progress):
        fraction, seconds = progress["fraction"], progress["seconds"]
        advanced = fraction - self._start_fraction
        left = f", {duration(seconds * (1 - fraction) / advanced)} left" if advanced > 0 else ""
        samples = f"{progress['samples_done']}/{progress['samples']} samples"
        error = "" if progress["error"] is None else f", error {progress['error']:.2g}"
        return f"{self._label}: {samples}, {100 * fraction:.0f} %{error}, {duration(seconds)}{left}"

    def _clear(self):
        if self._line_open:
            self._stream.write("\r\x1b[K")
            self._line_open = False


def duration(seconds):
    """Returns seconds as text, e.g. 3.2 s, 45 s, 2:05, 1:02:05."""
    if seconds < 10:
        return f"{seconds:.1f} s"
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    minutes, seconds = divmod(seconds, 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{minutes}:{seconds:02d}"
