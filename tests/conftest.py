# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures for all Python tests: the package from the working tree, and Blender with the add-on
registered."""

import importlib.util
import signal
import sys
from pathlib import Path

import pytest

ADDON = Path(__file__).resolve().parent.parent / "addon"


def _import_package():
    """Makes the folder addon/ importable as `nephele` where it is not installed."""
    if importlib.util.find_spec("nephele") is None:
        spec = importlib.util.spec_from_file_location(
            "nephele", ADDON / "__init__.py", submodule_search_locations=[str(ADDON)]
        )
        package = importlib.util.module_from_spec(spec)
        sys.modules["nephele"] = package
        spec.loader.exec_module(package)


_import_package()
# A shell that starts the tests in the background has SIGINT ignored, and children would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def addon():
    """Returns the package, registered in Blender until the tests end: some Blenders hang or crash at exit
    otherwise."""
    import bpy
    import nephele

    nephele.register()
    yield nephele
    bpy.ops.wm.read_factory_settings(use_empty=True)  # no scene may use the engine when it goes
    nephele.unregister()


@pytest.fixture
def bpy(addon):
    """Returns the module bpy with an empty factory scene: no object, no camera, no world."""
    import bpy

    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    bpy.context.scene.render.engine = "NEPHELE"
    return bpy


@pytest.fixture
def camera(bpy):
    """Returns the camera object of the empty scene, 5 m above the origin, looking down."""
    item = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    item.location = (0, 0, 5)
    bpy.context.scene.collection.objects.link(item)
    bpy.context.scene.camera = item
    return item


@pytest.fixture
def export(bpy, camera):
    """Returns a function that exports the current scene, as Blender would render it in the viewport's
    depsgraph."""
    from nephele.export import export_scene

    def run():
        return export_scene(bpy.context.evaluated_depsgraph_get())

    return run


@pytest.fixture
def link(bpy):
    """Returns a function (name, data) -> new object in the scene."""

    def make(name, data):
        item = bpy.data.objects.new(name, data)
        bpy.context.scene.collection.objects.link(item)
        return item

    return make


@pytest.fixture
def openvdb(bpy):
    """Returns Blender's own Python module for OpenVDB, which bpy brings but does not put on the path."""
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    folder = Path(bpy.utils.resource_path("LOCAL"), "python", "lib", version, "site-packages")
    sys.path.append(str(folder))
    try:
        import openvdb
    finally:
        sys.path.remove(str(folder))
    return openvdb
