# SPDX-License-Identifier: GPL-3.0-or-later
"""Loads the native module when it is first needed, and builds renderers from scene descriptions."""

import importlib

MODULE = "nephele_native"


class NativeModuleError(Exception):
    """The native module is missing or does not load; the message says why and what to do."""


def load_native():
    """Returns the native module; raises NativeModuleError where it cannot be used."""
    try:
        return importlib.import_module(MODULE)
    except ModuleNotFoundError as fault:
        if fault.name != MODULE:
            raise NativeModuleError(_broken(fault)) from fault
        raise NativeModuleError(
            f"Nephele's native module '{MODULE}' is not installed for this Python. Install the "
            "extension made for this "
            "Blender version and platform, or build the module (see README.md)"
        ) from fault
    except ImportError as fault:
        raise NativeModuleError(_broken(fault)) from fault


def _broken(fault):
    return (
        f"Nephele's native module '{MODULE}' does not load: {fault}. Install the extension made for "
        "this Blender version "
        "and platform, or build the module anew (see README.md)"
    )


def create_renderer(scene, parts=None):
    """Returns a native Renderer of a description.Scene. parts: SceneParts of the scenes before it.

    Raises NativeModuleError, ValueError (the scene is at fault) or RuntimeError, each with a message for the
    user.
    """
    return load_native().Renderer(scene, parts)


def create_parts():
    """Returns empty SceneParts for create_renderer(). Raises NativeModuleError."""
    return load_native().SceneParts()
