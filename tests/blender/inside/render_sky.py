# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders a Sky Texture, which a process of its own bakes, with the installed extension.

Argument: the OpenEXR picture to write.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common


def main():
    (picture,) = common.arguments()
    scene = bpy.context.scene
    scene.render.engine, scene.nephele.samples = "NEPHELE", 4
    scene.render.resolution_x, scene.render.resolution_y = 32, 18
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    sky = tree.nodes.new("ShaderNodeTexSky")
    tree.links.new(sky.outputs[0], tree.nodes["Background"].inputs["Color"])
    common.write_exr(scene)
    scene.render.filepath = picture
    assert bpy.ops.render.render(write_still=True) == {"FINISHED"}
    record = common.part("engine").last_render
    assert (record.state, record.warnings) == ("done", []), record


main()
