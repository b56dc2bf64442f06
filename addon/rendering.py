# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a native renderer from the command line so that Ctrl-C always gets through."""

import threading

from . import noise
from .errors import InputError

POLL_SECONDS = 0.1
BACKGROUND = "nephele background"  # name of the threads of interruptible()


def interruptible(function, *arguments):
    """Returns function(*arguments), run on another thread: a long native call there does not delay
    KeyboardInterrupt here.

    After an interrupt the call goes on in the background; the process is expected to end.
    """
    outcome = {}

    def call():
        try:
            outcome["result"] = function(*arguments)
        except BaseException as error:  # noqa: BLE001 - raised again below, in the caller's thread
            outcome["error"] = error

    thread = threading.Thread(target=call, name=BACKGROUND, daemon=True)
    thread.start()
    while thread.is_alive():
        thread.join(POLL_SECONDS)
    if "error" in outcome:
        raise outcome["error"]
    return outcome["result"]


def abandoned():
    """Tells whether a call that was interrupted is still going on."""
    return any(thread.name == BACKGROUND for thread in threading.enumerate())


def native_module():
    """Returns the native module. Raises InputError where it is missing or does not load."""
    from .bridge import NativeModuleError, load_native

    try:
        return load_native()
    except NativeModuleError as error:
        raise InputError(str(error)) from error


def build(scene, parts=None):
    """Returns a native renderer of a description.Scene. parts: see bridge.py. Raises InputError where the
    scene or a file is at fault."""
    from .bridge import create_renderer

    with noise.hidden():
        try:
            return interruptible(create_renderer, scene, parts)
        except ValueError as error:
            raise InputError(" ".join(str(error).split())) from error


def run(renderer, reporter):
    """Renders until it is done, cancelled or at its time limit. KeyboardInterrupt passes through; see
    stop()."""
    renderer.start()
    while not renderer.wait(POLL_SECONDS):
        reporter.show(renderer.progress())


def stop(renderer):
    """Cancels `renderer` and returns once it stands still."""
    renderer.cancel()
    while not renderer.wait(POLL_SECONDS):
        pass
