# SPDX-License-Identifier: GPL-3.0-or-later
"""The rendered 3D view: samples arrive, orbit, edits, undo, a VDB sequence, passes, borders, two views, F12
beside them, back to Solid; previews.

The extension is installed already. Arguments: folder for screenshots, .blend of a still scene, .blend of a
scene with a VDB sequence, folder for pictures. What the test outside compares is in the folder of pictures:
facts.json says where in the screenshots it lies.
"""

import json
import sys
import threading
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import bpy
import common
import stage

SAMPLES = 8
CYCLES = 20  # from Solid to Rendered and back
facts = {}


def areas():
    """Returns the 3D views of the main window, the largest first."""
    found = [area for area in stage.window().screen.areas if area.type == "VIEW_3D"]
    return sorted(found, key=lambda area: -area.width * area.height)


def region(area):
    return next(region for region in area.regions if region.type == "WINDOW")


def space():
    return areas()[0].spaces.active


def over_view():
    """Returns the context manager in which operators act on the largest 3D view."""
    area = areas()[0]
    return stage.override(area=area, region=region(area))


def viewports():
    """Returns the add-on's open Viewports."""
    return list(common.part("viewport")._open)


def workers():
    return [viewport._worker for viewport in viewports() if viewport._worker is not None]


def threads():
    return [thread for thread in threading.enumerate() if thread.name == "nephele viewport"]


def settled():
    """Whether every view has shown its last sample."""
    return bool(workers()) and not any(worker.working for worker in workers()) and all_drawn()


def all_drawn():
    return all(viewport._news == viewport._worker.news for viewport in viewports())


def check(count=1):
    """Asserts that so many views render and that none complains."""
    assert len(workers()) == count, viewports()
    for viewport in viewports():
        assert (viewport._message, viewport._worker.message) == ("", ""), viewport._message


def shot(name):
    """Waits until Blender has drawn, then takes a screenshot."""
    yield 0.5
    stage.screenshot(name)


def rendered(name=None, count=1):
    """Waits until all views have their last sample."""
    yield 0.3
    yield settled
    check(count)
    if name:
        yield from shot(name)


def place_of(area):
    """Returns (x0, y0, x1, y1) of a view's region, in pixels of screenshots, whose first row is the top
    one."""
    inside = region(area)
    left, bottom = inside.x, inside.y
    top = stage.window().height - bottom - inside.height
    return [left, top, left + inside.width, top + inside.height]


def frame_place():
    """Returns the camera's frame in pixels of screenshots."""
    (viewport,) = viewports()
    view, inside = viewport._job.view, common.part("viewport_view")
    scene = bpy.context.scene
    plane = scene.camera.calc_matrix_camera(
        bpy.context.evaluated_depsgraph_get(), x=scene.render.resolution_x, y=scene.render.resolution_y
    )
    frame = inside.frame_in(inside.viewplane(plane, True), view.camera.viewplane, view.size)
    left, _, _, bottom = place_of(areas()[0])
    x0, y0, x1, y1 = frame
    return [left + x0, bottom - y1, left + x1, bottom - y0]


def bare(shown):
    """Hides what Blender draws over the picture, or shows it."""
    space().overlay.show_overlays = space().show_gizmo = shown


def samples_arrive(blend):
    """The view through the camera, as samples arrive and at its end; then F12 of the same frame."""
    scene = common.open_scene(blend, 640, 360, SAMPLES)
    yield 2.0
    scene.render.engine = "NEPHELE"
    scene.nephele.viewport_samples = SAMPLES
    space().region_3d.view_perspective = "CAMERA"
    space().region_3d.view_camera_zoom = 0.0
    scene.render.use_border = True  # nothing beyond the camera's frame
    bare(False)
    yield 1.0
    stage.screenshot("viewport_solid")
    space().shading.type = "RENDERED"
    yield lambda: bool(workers()) and workers()[0].picture is not None
    facts["first_divider"] = workers()[0].picture.place[2] / workers()[0].picture.pixels.shape[1]
    yield from shot("viewport_early")
    yield from rendered("viewport_done")
    facts["view"], facts["frame"] = place_of(areas()[0]), frame_place()
    x0, y0, x1, y1 = facts["frame"]
    scene.render.resolution_x, scene.render.resolution_y = round(x1 - x0), round(y1 - y0)
    bpy.context.preferences.view.render_display_type = "NONE"
    yield from f12()
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "IMAGE"
    settings.file_format, settings.color_mode = "PNG", "RGB"
    bpy.data.images["Render Result"].save_render(str(Path(common.arguments()[3], "f12.png")), scene=scene)
    scene.render.use_border = False
    scene.render.preview_pixel_size = "8"
    scene.nephele.viewport_samples = 4
    yield from rendered()


def f12():
    """F12, to its end."""
    engine = common.part("engine")
    engine.last_render = None
    with stage.override():
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield lambda: getattr(engine.last_render, "state", "running") != "running"
    yield lambda: not bpy.app.is_job_running("RENDER")
    assert engine.last_render.state == "done", engine.last_render


def orbit():
    """Steps around the scene; every step's first picture is timed."""
    bare(True)
    with over_view():
        bpy.ops.view3d.view_camera()
    space().region_3d.view_distance = 12.0
    space().region_3d.view_location = (0.0, 6.0, 1.5)
    yield from rendered("viewport_orbit_before")
    facts["orbit"] = []
    for _ in range(4):
        with over_view():
            bpy.ops.view3d.view_orbit(type="ORBITLEFT", angle=0.1)
        yield from rendered()
        facts["orbit"].append([workers()[0].first_seconds, workers()[0].native_seconds])
    yield from shot("viewport_orbit_after")
    with over_view():
        bpy.ops.view3d.view_persportho()
    yield from rendered("viewport_orthographic")
    with over_view():
        bpy.ops.view3d.view_persportho()
    yield from rendered()


def edits():
    """Material, lamp, object, world: each changes the picture; undo brings the one before back. Nothing that
    did not change is built again."""
    material = bpy.data.materials["Cloud"].node_tree.nodes["Principled Volume"]
    with stage.override():
        bpy.ops.ed.undo_push(message="Before")
    yield from rendered("viewport_edit_before")
    job = viewports()[0]._job
    bpy.context.view_layer.objects.active = bpy.context.scene.objects["Glass ball"]
    yield 1.0
    assert viewports()[0]._job is job  # a selection changes nothing
    before = viewports()[0]._session._parts.counts()
    material.inputs["Color"].default_value = (0.9, 0.2, 0.1, 1.0)
    with stage.override():
        bpy.ops.ed.undo_push(message="Colour")
    yield from rendered("viewport_edit_material")
    after = viewports()[0]._session._parts.counts()
    facts["parts"] = {"found": after[0] - before[0], "made": after[1] - before[1]}
    bpy.data.objects["Copper ball"].location.z += 1.0
    bpy.data.lights["Sun"].energy *= 0.2
    with stage.override():
        bpy.ops.ed.undo_push(message="Ball and sun")
    yield from rendered("viewport_edit_objects")
    with stage.override():
        bpy.ops.ed.undo()
    yield from rendered("viewport_undo_objects")
    with stage.override():
        bpy.ops.ed.undo()
    yield from rendered("viewport_undo_material")


def passes():
    """Another pass, in false colour, and back."""
    for name in ("VSP_TARGET", "NORMAL", "DEPTH", "COMBINED"):
        space().shading.nephele.render_pass = name
        areas()[0].tag_redraw()
        yield from rendered(f"viewport_pass_{name.lower()}")


def borders():
    """The view's render region, then the camera's; a transparent film."""
    view = space()
    view.use_render_border = True
    view.render_border_min_x, view.render_border_max_x = 0.25, 0.75
    view.render_border_min_y, view.render_border_max_y = 0.5, 1.0
    areas()[0].tag_redraw()
    yield from rendered("viewport_border")
    view.use_render_border = False
    view.region_3d.view_perspective = "CAMERA"
    render = bpy.context.scene.render
    render.use_border = render.film_transparent = True
    render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.1, 0.6, 0.0, 1.0
    yield from rendered("viewport_camera_border")
    render.use_border = render.film_transparent = False
    yield from rendered()


def two_views():
    """A second view beside the first, and F12 beside both; an error is told in the view."""
    with stage.override(area=areas()[0], region=region(areas()[0])):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    yield 1.0
    for area in areas():  # Blender gives a new view another shading
        area.spaces.active.shading.type = "RENDERED"
    yield lambda: len(workers()) == 2
    areas()[1].spaces.active.region_3d.view_perspective = "PERSP"
    yield from rendered(count=2)
    bpy.context.scene.nephele.viewport_samples = bpy.context.scene.nephele.samples = 8
    yield from f12()
    yield from rendered("viewport_two", count=2)
    with stage.override(area=areas()[1], region=region(areas()[1])):
        bpy.ops.screen.area_close()
    yield lambda: len(viewports()) == 1
    yield from rendered()


def error():
    """What cannot be rendered is told once, and mended."""
    volume = bpy.data.objects["Cloud"].data
    path = volume.filepath
    volume.filepath = "//missing.vdb"
    yield lambda: "missing.vdb" in viewports()[0]._message
    yield from shot("viewport_error")
    volume.filepath = path
    yield from rendered("viewport_mended")


def modes():
    """From Solid to Rendered and back, again and again: everything is freed."""
    sizes = []
    for number in range(CYCLES):
        space().shading.type = "RENDERED"
        yield lambda: bool(workers()) and workers()[0].picture is not None
        space().shading.type = "SOLID"
        yield lambda: viewports() == [] and threads() == []
        if number >= CYCLES // 3:
            sizes.append(int(Path("/proc/self/statm").read_text().split()[1]) * 4096)
    facts["sizes"] = sizes
    yield from shot("viewport_solid_again")


def previews():
    """Previews in the properties editor, of a volume's material and of the world. Nothing is written to
    afterwards: a preview that ends while Blender draws a panel may leave scripts forbidden to write."""
    found = next(item for item in bpy.context.scene.objects if item.type == "VOLUME")
    stage.window().view_layer.objects.active = found
    area = areas()[0]
    area.type = "PROPERTIES"
    yield 1.0
    area.spaces.active.search_filter = "preview"
    for tab in ("MATERIAL", "WORLD"):
        area.spaces.active.context = tab
        yield 3.0
        yield lambda: not bpy.app.is_job_running("RENDER_PREVIEW")
        yield from shot(f"preview_{tab.lower()}")
    area.spaces.active.search_filter = ""
    area.type = "VIEW_3D"
    yield 1.0


def sequence(blend):
    """Scrubs through a VDB sequence."""
    scene = common.open_scene(blend, 640, 360, SAMPLES)
    yield 2.0
    scene.render.engine = "NEPHELE"
    scene.nephele.viewport_samples = 8
    scene.render.preview_pixel_size = "8"
    space().region_3d.view_perspective = "CAMERA"
    space().shading.type = "RENDERED"
    yield 0.5
    for frame in (1, 2, 1):
        scene.frame_set(frame)
        yield from rendered(f"viewport_frame_{frame}")
        (volume,) = viewports()[0]._job.scene.volumes
        assert volume.path.endswith(f"_{frame:04d}.vdb"), volume.path


def popover():
    """The shading popover, with our panel in it; a panel that fails to draw leaves a traceback."""
    with over_view():
        bpy.ops.wm.call_panel("INVOKE_DEFAULT", name="VIEW3D_PT_shading", keep_open=True)
    yield 1.0
    yield from shot("viewport_popover")


def scenario():
    _, still_blend, sequence_blend, folder = common.arguments()
    yield from samples_arrive(still_blend)
    yield from orbit()
    yield from edits()
    yield from passes()
    yield from borders()
    yield from two_views()
    yield from error()
    yield from modes()
    yield from sequence(sequence_blend)
    yield from previews()
    yield from popover()
    Path(folder, "facts.json").write_text(json.dumps(facts, indent=1))


stage.play(scenario)
