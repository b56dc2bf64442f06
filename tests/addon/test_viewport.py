# SPDX-License-Identifier: GPL-3.0-or-later
"""Viewports in Blender without windows: a stand-in for the engine and for the region, the native module
itself. Drawing is recorded instead of done."""

import gc
import sys
import threading
import time
import types
from pathlib import Path

import numpy as np
import pytest
from nephele import engine, viewport
from nephele.export.space import matrix4
from programs import with_nodes

PATIENCE = 60.0  # seconds, on a busy machine
CYCLES, WARM = 200, 60


class Engine:
    """What Blender gives an engine of a 3D view, recorded."""

    camera_override = None
    pixel_size = 1

    def __init__(self):
        self.redraws, self.texts = 0, []

    def tag_redraw(self):
        self.redraws += 1

    def update_stats(self, stats, info):
        self.texts.append(info)

    def get_preview_pixel_size(self, scene):
        return self.pixel_size


class Drawn:
    """Stands in for viewport_draw.Drawing."""

    pictures = ()

    def draw(self, engine, scene, picture):
        if not Drawn.pictures or Drawn.pictures[-1] is not picture:
            Drawn.pictures = (*Drawn.pictures, picture)


@pytest.fixture
def drawn(monkeypatch):
    monkeypatch.setitem(sys.modules, "nephele.viewport_draw", types.SimpleNamespace(Drawing=Drawn))
    Drawn.pictures = ()
    return Drawn


class View:
    """An open 3D view of the current scene."""

    def __init__(self, bpy, camera, size=(48, 32)):
        self.bpy = bpy
        screen = next(s for s in bpy.data.screens if any(a.type == "VIEW_3D" for a in s.areas))
        self.space = next(a for a in screen.areas if a.type == "VIEW_3D").spaces.active
        projection = camera.calc_matrix_camera(self.depsgraph(), x=size[0], y=size[1])
        self.region_data = types.SimpleNamespace(
            view_perspective="PERSP",
            is_perspective=True,
            window_matrix=matrix4(projection),
            view_matrix=np.linalg.inv(matrix4(camera.matrix_world)),
        )
        self.region = types.SimpleNamespace(width=size[0], height=size[1])
        self.engine = Engine()
        self.viewport = viewport.Viewport(self.engine)

    def depsgraph(self):
        return self.bpy.context.evaluated_depsgraph_get()

    @property
    def context(self):
        return types.SimpleNamespace(space_data=self.space, region=self.region, region_data=self.region_data)

    def update(self):
        """Has Blender evaluate what changed. As view_update, this is where the depsgraph still names it."""
        calls = []

        def after(scene, depsgraph):
            calls.append(depsgraph)
            self.viewport.update(self.engine, self.context, depsgraph)

        handlers = self.bpy.app.handlers.depsgraph_update_post
        handlers.append(after)
        try:
            depsgraph = self.depsgraph()
        finally:
            handlers.remove(after)
        if not calls:
            self.viewport.update(self.engine, self.context, depsgraph)

    def draw(self):
        self.viewport.draw(self.engine, self.context, self.depsgraph())

    def finish(self):
        """Draws until the last sample is shown. Returns the picture's pixels."""
        end = time.monotonic() + PATIENCE
        while True:
            self.draw()
            worker = self.viewport._worker
            if worker is None or (not worker.working and worker.news == self.viewport._news):
                return None if worker is None or worker.picture is None else worker.picture.pixels
            assert time.monotonic() < end, "waited in vain"
            time.sleep(0.005)


@pytest.fixture
def view(bpy, camera, drawn, link):
    """Returns a View of a small scene: a lit floor."""
    mesh = bpy.data.meshes.new("Floor")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    item = link("Floor", mesh)
    item.data.materials.append(with_nodes(bpy.data.materials.new("Grey")))
    link("Lamp", bpy.data.lights.new("Lamp", "SUN")).location = (0, 0, 3)
    bpy.context.scene.nephele.viewport_samples = 4
    bpy.context.view_layer.update()
    made = View(bpy, camera)
    yield made
    made.viewport.close()
    made.space.shading.nephele.property_unset("render_pass")
    viewport.close_all()


def floor_color(bpy):
    tree = bpy.data.materials["Grey"].node_tree
    return next(n for n in tree.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"]


def test_the_view_is_the_final_render(bpy, view, camera):
    """Through the camera, pixel by pixel: the same paths as those of F12 at that size."""
    from nephele.bridge import create_renderer
    from nephele.export import export_scene

    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.nephele.samples = 48, 32, 4
    scene.nephele.hierarchy = "by_mesh"  # as views have it
    bpy.context.view_layer.update()
    view.update()
    pixels = view.finish()
    renderer = create_renderer(export_scene(view.depsgraph()))
    renderer.start()
    while not renderer.wait(1.0):
        pass
    np.testing.assert_array_equal(pixels, renderer.read_pass("Combined"))
    assert pixels[..., :3].mean() > 0.01


def test_a_moved_view_needs_no_update(view):
    view.update()
    first = view.finish()
    view.region_data.view_matrix = view.region_data.view_matrix.copy()
    view.region_data.view_matrix[0, 3] += 1.0
    job = view.viewport._job
    second = view.finish()
    assert view.viewport._job is not job and view.viewport._job.scene is job.scene
    assert np.abs(first - second).max() > 0.01


def test_updates_that_change_nothing_restart_nothing(bpy, view):
    view.update()
    view.finish()
    job, news = view.viewport._job, view.viewport._worker.news
    bpy.data.objects["Floor"].select_set(True)
    view.update()
    view.finish()
    assert view.viewport._job is job and view.viewport._worker.news == news


@pytest.mark.parametrize("change", ["material", "lamp", "object", "world"])
def test_edits_change_the_picture(bpy, view, change):
    view.update()
    first = view.finish()
    if change == "material":
        floor_color(bpy).default_value = (0.1, 0.9, 0.1, 1)
    elif change == "lamp":
        bpy.data.lights["Lamp"].energy *= 3
    elif change == "object":
        bpy.data.objects["Floor"].location.x += 2
    else:
        bpy.context.scene.world = world = bpy.data.worlds.new("Bright")
        with_nodes(world)
        bpy.data.objects["Floor"].location.x += 2
    view.update()
    assert np.abs(view.finish() - first).max() > 0.01


def test_only_what_changed_is_built(bpy, view):
    view.update()
    view.finish()
    found, made = view.viewport._session._parts.counts()
    bpy.data.lights["Lamp"].energy *= 3
    view.update()
    view.finish()
    later = view.viewport._session._parts.counts()
    assert later[0] > found
    assert later[1] - made < made


def test_settings_and_film_count_without_an_update(bpy, view):
    view.update()
    view.finish()
    bpy.context.scene.nephele.viewport_samples = 7
    bpy.context.scene.render.film_transparent = True
    pixels = view.finish()
    assert view.viewport._worker.status.startswith("Sample 7/7")
    assert pixels[..., 3].min() < 1e-6


def test_passes(view):
    view.update()
    view.finish()
    view.space.shading.nephele.render_pass = "VSP_TARGET"
    view.finish()
    assert view.viewport._worker.picture.legend.startswith("VSP Target: 0 (dark)")
    assert view.engine.texts[-1].endswith(view.viewport._worker.picture.legend)


def test_pixel_size(view):
    view.engine.pixel_size = 4
    view.update()
    assert view.finish().shape == (8, 12, 4)


def test_camera_view_with_depth_of_field_and_border(bpy, view, camera):
    camera.data.dof.use_dof = True
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.use_border, scene.render.border_max_x = True, 0.5
    view.region_data.view_perspective = "CAMERA"
    view.space.camera = camera
    view.update()
    assert view.finish().shape == (32, 24, 4)
    assert view.viewport._job.view.camera.aperture_radius > 0
    assert view.viewport._worker.picture.place == (0, 0, 24, 32)


def test_local_view_and_hidden_objects(bpy, view):
    """What is disabled in renders is seen; what the view hides is not."""
    bpy.data.objects["Floor"].hide_render = True
    view.update()
    assert [i.name for i in view.viewport._scene.instances] == ["Floor"]
    bpy.data.objects["Floor"].hide_viewport = True
    view.update()
    assert view.viewport._scene.instances == ()


def test_no_camera_is_needed(bpy, view, camera):
    bpy.data.objects.remove(camera)
    view.update()
    assert view.finish() is not None


def test_faults_of_the_export_are_told_and_mended(bpy, view, link):
    view.update()
    view.finish()
    volume = bpy.data.volumes.new("Smoke")
    volume.filepath = "/nowhere/smoke.vdb"
    item = link("Smoke", volume)
    for _ in range(3):
        view.update()
        view.draw()
    assert "/nowhere/smoke.vdb" in view.engine.texts[-1]
    assert len([text for text in view.engine.texts if "nowhere" in text]) == 1
    bpy.data.objects.remove(item)
    view.update()
    assert view.finish() is not None
    assert view.engine.texts[-1].startswith("Sample 4/4")


@pytest.mark.parametrize("where", [(viewport.Session, "export"), (viewport, "view_of")])
def test_bugs_are_told_once(view, monkeypatch, capsys, where):
    monkeypatch.setattr(*where, lambda *_, **__: 1 / 0)
    for _ in range(3):
        view.update()
        view.draw()
    assert view.engine.texts[-1] == "internal error: ZeroDivisionError: division by zero"
    assert capsys.readouterr().err.count("Traceback") == (3 if where[1] == "view_of" else 1)
    monkeypatch.undo()


def test_undo_makes_the_export_look_at_everything(bpy, view):
    view.update()
    view.finish()
    history = view.viewport._session._cache.history
    assert history._graph is not None
    for handler in bpy.app.handlers.undo_post:
        handler(bpy.context.scene)
    assert history._graph is None
    view.update()
    view.finish()


def test_hidden_views_pause_and_go_on(bpy, view):
    bpy.context.scene.nephele.viewport_samples = 2**20
    view.update()
    view.draw()
    end = time.monotonic() + PATIENCE
    while not view.viewport._worker.paused:
        view.viewport.look()
        time.sleep(0.01)
        assert time.monotonic() < end
    assert view.engine.redraws > 0
    assert not view.viewport.look()  # the timer may end
    view.draw()
    assert not view.viewport._worker.paused


def test_several_views_and_a_final_render_at_once(bpy, view, camera):
    scene = bpy.context.scene
    scene.nephele.viewport_samples = 2**20
    other = View(bpy, camera)
    other.engine.pixel_size = 2
    for one in (view, other):
        one.update()
        one.draw()
    scene.render.resolution_x, scene.render.resolution_y, scene.nephele.samples = 16, 8, 2
    bpy.ops.render.render()
    assert engine.last_render.state == "done"
    scene.nephele.viewport_samples = 3
    shapes = [one.finish().shape[:2] for one in (view, other)]
    assert shapes == [(32, 48), (16, 24)]
    other.viewport.close()


def threads():
    return [thread for thread in threading.enumerate() if thread.name == "nephele viewport"]


def resident():
    """Returns the bytes of memory in use."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def test_cycles_of_start_and_cancel_leak_nothing(bpy, view, camera):
    """Views are closed while they render, at another moment of it each time."""
    view.viewport.close()
    bpy.context.scene.nephele.viewport_samples = 2**20
    sizes = []
    for number in range(CYCLES):
        one = View(bpy, camera)
        one.update()
        one.draw()
        time.sleep(0.001 * (number % 40))
        one.draw()
        assert one.viewport._message == one.viewport._worker.message == ""
        one.viewport.close()
        del one
        if number >= WARM and number % 10 == 0:
            viewport.close_all()
            assert threads() == []
            sizes.append(resident())
    assert max(sizes) <= 1.02 * sizes[0], [size >> 20 for size in sizes]


def test_cycles_of_final_renders_leak_nothing(bpy, view):
    """As Escape ends them: renders of the host's test_break(), at another moment each time."""
    scene = bpy.context.scene
    scene.nephele.samples = 2**20
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    calls = types.SimpleNamespace(left=0)

    def escape(self):
        calls.left -= 1
        return calls.left < 0

    ours = {name: value for name, value in vars(engine.NepheleRenderEngine).items() if callable(value)}
    host = type("Host", (), {
        **ours, "_session": None, "_viewport": None, "is_preview": False, "camera_override": None,
        "begin_result": lambda *_, **__: types.SimpleNamespace(layers=[types.SimpleNamespace(passes={
            "Combined": types.SimpleNamespace(rect=types.SimpleNamespace(foreach_set=lambda flat: None))})]),
        "end_result": lambda *_: None, "update_result": lambda *_: None, "test_break": escape,
        "report": lambda *_: None, "error_set": lambda *_: None, "update_stats": lambda *_: None,
        "update_progress": lambda *_: None, "update_memory_stats": lambda *_, **__: None,
        "add_pass": lambda *_, **__: None,
    })  # fmt: skip
    sizes = []
    for number in range(CYCLES):
        calls.left = number % 3 + 1
        host().render(view.depsgraph())
        assert engine.last_render.state == "cancelled", engine.last_render
        if number >= WARM and number % 10 == 0:
            sizes.append(resident())
    assert max(sizes) <= 1.02 * sizes[0], [size >> 20 for size in sizes]
