# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders of one scene that changes, one after the other: what did not change is neither exported nor built
again. For animations, and for viewports:

    session = Session()
    # in view_update(): something changed
    scene = session.export(depsgraph, engine=self, motion=False, space=context.space_data)
    scene = dataclasses.replace(scene, camera=..., film=...)  # in view_draw(): the view changed
    renderer = session.build(scene)                           # then start(), wait(), read_pass()

A picture has the same bits as without a session. Let go of a renderer before the next is built: what both
share is there once, but what changed is there twice. Descriptions and their arrays are never written to.
"""

from . import bridge
from .export import ExportCache, export_scene


class Session:
    """Of one scene and one engine, whose every depsgraph it must be given; after one that it did not get,
    take a new session or call distrust(). After an export that failed the next looks at everything."""

    def __init__(self):
        self._cache = ExportCache()
        self._parts = bridge.create_parts()

    def export(self, depsgraph, *, engine=None, motion=True, space=None):
        """Returns the description.Scene of a depsgraph; see export_scene()."""
        return export_scene(depsgraph, engine=engine, cache=self._cache, motion=motion, space=space)

    def distrust(self):
        """Says that a depsgraph was missed: the next export reads and compares all."""
        self._cache.history.forget()

    def build(self, scene):
        """Returns a native Renderer of a description.Scene. Raises as bridge.create_renderer()."""
        return bridge.create_renderer(scene, self._parts)
