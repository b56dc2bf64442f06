# SPDX-License-Identifier: GPL-3.0-or-later
"""Plays a scenario in Blender's windows, step by step, as a user would.

A scenario is a generator that acts and yields what to wait for: seconds, or a function that becomes true.
Between two steps Blender handles events and draws. Blender then quits by its own operator: with 0 when the
scenario has come to its end, else at once with 1 and the traceback.

The script's arguments begin with the folder for screenshots.
"""

import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy
import common

WAIT_AT_MOST = 400.0  # seconds, on a machine with other things to do
LOOK_EVERY = 0.2


def window():
    """Returns Blender's main window."""
    return bpy.context.window_manager.windows[0]


def screenshot(name):
    """Writes the whole display to NAME.png; returns its path. Blender's own operator gives black pictures."""
    path = Path(common.arguments()[0], f"{name}.png")
    subprocess.run(["import", "-window", "root", str(path)], check=True, timeout=60)
    return path


def press(key):
    """Presses a key over the middle of the display, where Blender opens the window of a render. Blender's own
    simulated events do not stop a job."""
    subprocess.run(["xdotool", "mousemove", "800", "500", "key", key], check=True, timeout=60)


def largest_area():
    """Returns the main window's largest area."""
    return max(window().screen.areas, key=lambda area: area.width * area.height)


def override(**more):
    """Returns the context manager in which operators act on the main window."""
    return bpy.context.temp_override(window=window(), **more)


def play(scenario):
    """Plays a scenario from the event loop."""
    preferences = bpy.context.preferences
    preferences.view.show_splash = False
    preferences.view.use_save_prompt = False
    preferences.view.render_display_type = "WINDOW"
    steps = scenario()
    state = {"until": lambda: True, "since": time.monotonic()}

    def turn():
        try:
            if not state["until"]():
                if time.monotonic() - state["since"] > WAIT_AT_MOST:
                    screenshot("stuck")
                    raise TimeoutError(f"waited {WAIT_AT_MOST} s in vain for line {steps.gi_frame.f_lineno}")
                return LOOK_EVERY
            wanted = next(steps, None)
            if wanted is None:
                with override():
                    bpy.ops.wm.quit_blender()
                return None
        except BaseException:  # noqa: BLE001  whatever it was, the process must end and say so
            traceback.print_exc()
            sys.stderr.flush()
            sys.stdout.flush()
            os._exit(1)
        state["since"] = now = time.monotonic()
        state["until"] = wanted if callable(wanted) else (lambda: time.monotonic() - now >= wanted)
        return LOOK_EVERY

    bpy.app.timers.register(turn, first_interval=2.0, persistent=True)
