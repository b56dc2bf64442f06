# SPDX-License-Identifier: GPL-3.0-or-later
"""How SIGINT and SIGTERM reach the command line: as KeyboardInterrupt in the main thread, now or later."""

import contextlib
import signal


@contextlib.contextmanager
def raised():
    """Inside the block the signals raise KeyboardInterrupt."""
    with handled(signal.default_int_handler):
        yield


@contextlib.contextmanager
def deferred():
    """Inside the block the signals wait; where one came, KeyboardInterrupt is raised at the block's end.

    For Blender's start and file loading, which crash when an exception falls into their Python parts.
    """
    came = []
    try:
        with handled(lambda number, frame: came.append(number)):
            yield
    finally:
        if came:
            raise KeyboardInterrupt


@contextlib.contextmanager
def handled(handler):
    """Inside the block `handler` takes the signals, except one that the process was told to ignore: a shell's
    background job ignores Ctrl-C on purpose."""
    kept = {}
    for number in (signal.SIGINT, signal.SIGTERM):
        if signal.getsignal(number) is not signal.SIG_IGN:
            kept[number] = signal.signal(number, handler)
    try:
        yield
    finally:
        for number, before in kept.items():
            signal.signal(number, before if before is not None else signal.SIG_DFL)
