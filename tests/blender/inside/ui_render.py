# SPDX-License-Identifier: GPL-3.0-or-later
"""F12, the picture arriving, Escape, settings, two frames of an animation, a VDB sequence scrubbed.

The extension is installed already. Arguments: folder for screenshots, .blend of a still scene, .blend of a
scene with a VDB sequence, folder for pictures.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage

SIZE = (160, 90)


def engine():
    """Returns the add-on's module engine."""
    return common.part("engine")


def ended():
    """Whether the last render that was begun is over, for Blender, too."""
    record = engine().last_render
    over = record is not None and record.state != "running"
    return over and not bpy.app.is_job_running("RENDER")


def expect(state):
    """Asserts how the last render ended, without a warning."""
    record = engine().last_render
    assert (record.state, record.warnings) == (state, []), (record.state, record.message, record.warnings)


def render_as_f12():
    """Does what F12 does and returns what to wait for. A key that xdotool presses is another to 5.2."""
    engine().last_render = None
    with stage.override():
        bpy.ops.render.render("INVOKE_DEFAULT", use_viewport=True)
    return ended


def open_small(blend, samples):
    """Opens a scene for small pictures of ours."""
    scene = common.open_scene(blend, *SIZE, samples)
    scene.render.engine = "NEPHELE"
    common.write_exr(scene)
    for area in stage.window().screen.areas:
        if area.type == "PROPERTIES":
            area.spaces.active.context = "RENDER"
    return scene


def still(blend):
    """F12 to the end; then a long render, looked at twice, and Escape."""
    scene = open_small(blend, 4)
    yield 2.0
    yield render_as_f12()
    expect("done")
    yield 1.0
    stage.screenshot("f12_done")

    scene.nephele.samples = 1_000_000
    render_as_f12()
    yield lambda: getattr(engine().last_render, "state", "") == "running"
    yield 4.0
    stage.screenshot("f12_early")
    yield 6.0
    stage.screenshot("f12_later")
    assert engine().last_render.state == "running"
    stage.press("Escape")
    yield ended
    expect("cancelled")
    stage.screenshot("f12_cancelled")


def animation(blend, folder):
    """Two frames as files, by the menu's operator."""
    scene = open_small(blend, 2)
    yield 2.0
    scene.frame_start, scene.frame_end = 1, 2
    scene.render.filepath = str(Path(folder, "animation_"))
    files = [Path(folder, f"animation_{frame:04d}.exr") for frame in (1, 2)]
    with stage.override():
        bpy.ops.render.render("INVOKE_DEFAULT", animation=True)
    yield lambda: all(file.is_file() for file in files) and ended()
    expect("done")
    assert engine().last_render.frame == 2


def sequence(blend, folder):
    """Scrubs through a VDB sequence; each frame's picture is kept as sequence_N.exr."""
    scene = open_small(blend, 4)
    yield 2.0
    assert any(item.type == "VOLUME" and item.data.is_sequence for item in scene.objects)
    for frame in (1, 2):
        scene.frame_set(frame)
        yield 0.5
        yield render_as_f12()
        expect("done")
        (file,) = {grid["path"] for grid in engine().last_render.statistics["grids"]}
        assert file.endswith(f"_{frame:04d}.vdb"), file
        yield 1.0
        picture = bpy.data.images["Render Result"]
        picture.save_render(str(Path(folder, f"sequence_{frame}.exr")), scene=scene)
        stage.screenshot(f"sequence_{frame}")


def scenario():
    _, still_blend, sequence_blend, folder = common.arguments()
    yield from still(still_blend)
    yield from animation(still_blend, folder)
    yield from sequence(sequence_blend, folder)


stage.play(scenario)
