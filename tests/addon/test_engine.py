# SPDX-License-Identifier: GPL-3.0-or-later
"""The render engine in Blender, with a stand-in for the native module: passes, borders, cancel, errors,
progress."""

import threading
import time
import types

import numpy as np
import OpenEXR
import pytest
from nephele import bridge, engine, parameters, passes
from nephele.export.film import toggle_of


class FakeRenderer:
    """Pixel (x, y) of every pass is 1000 y + x + channel / 10. `seconds`: how long a render takes. `fault`:
    raised by wait()."""

    seconds = 0.0
    fault = None
    made = ()

    def __init__(self, scene, parts=None):
        type(self).made = (*self.made, self)
        self.scene = scene
        self.settings = parameters.checked(scene.settings)
        x0, y0, x1, y1 = scene.film.crop or (0, 0, scene.film.width, scene.film.height)
        self.width, self.height = x1 - x0, y1 - y0
        self.warnings = ["the fake renders numbers"]
        self.reads, self.started, self.cancelled_at, self.ended_at = 0, None, None, None
        self.stop = threading.Event()

    def start(self):
        self.started = time.monotonic()

    def wait(self, seconds):
        if self.fault is not None and self.cancelled_at is None:
            raise self.fault
        left = self.started + self.seconds - time.monotonic()
        self.stop.wait(max(0.0, min(seconds, left)))
        done = self.stop.is_set() or time.monotonic() >= self.started + self.seconds
        if done and self.ended_at is None:
            self.ended_at = time.monotonic()
        return done

    def cancel(self):
        if self.ended_at is None:
            self.cancelled_at = time.monotonic()
        self.stop.set()

    def progress(self):
        fraction = min(1.0, (time.monotonic() - self.started) / max(self.seconds, 1e-9))
        state = "cancelled" if self.cancelled_at else "done"
        samples = self.settings["samples"]
        done = int(fraction * samples)
        return {"state": state, "message": "", "samples_done": done, "samples": samples, "fraction": fraction,
                "seconds": time.monotonic() - self.started, "error": None}  # fmt: skip

    def read_pass(self, name):
        if name not in self.scene.film.passes:
            raise ValueError(name)
        self.reads += 1
        y, x, channel = np.meshgrid(
            np.arange(self.height),
            np.arange(self.width),
            np.arange(len(passes.BY_NAME[name].channels)),
            indexing="ij",
        )
        return (1000 * y + x + channel / 10).astype(np.float32)

    def statistics(self):
        return {"rays": 7, "grids": [{"bytes": 2**20}], "embree_bytes": 2**20}


@pytest.fixture
def fake(monkeypatch):
    """Returns a fresh fake renderer class in the native module's place."""
    cls = type("Fake", (FakeRenderer,), {"made": ()})
    native = types.SimpleNamespace(Renderer=cls, SceneParts=object, matte_hash=len)
    monkeypatch.setattr(bridge, "load_native", lambda: native)
    return cls


@pytest.fixture
def render(bpy, camera, fake, tmp_path):
    """Returns a function that renders the scene to a multilayer EXR and returns channel -> pixels, row 0 at
    the bottom."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 40, 20, 100

    def run():
        path = str(tmp_path / "picture.exr")
        settings = scene.render.image_settings
        if bpy.app.version >= (5, 0, 0):
            settings.media_type = "MULTI_LAYER_IMAGE"
        settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
        scene.render.filepath = path
        bpy.ops.render.render(write_still=True)
        with OpenEXR.File(path, separate_channels=True) as file:
            return {name: c.pixels[::-1] for part in file.parts for name, c in part.channels.items()}

    return run


class Host:
    """What Blender gives an engine, recorded: Blender's own methods cannot be replaced on a registered
    class."""

    camera_override = None
    is_preview = False

    def __init__(self):
        self.errors, self.reports, self.fractions, self.texts, self.results = [], [], [], [], []
        self.break_times, self.pictures = [], 0
        self.escape = lambda: False

    def begin_result(self, x, y, width, height, layer):
        self.results.append("begun")
        rects = {}
        layer_passes = {
            row.name: types.SimpleNamespace(
                rect=types.SimpleNamespace(
                    foreach_set=lambda flat, name=row.name: rects.__setitem__(name, flat.copy())
                )
            )
            for row in passes.PASSES
        }
        return types.SimpleNamespace(layers=[types.SimpleNamespace(passes=layer_passes)], rects=rects)

    def end_result(self, result, **_):
        self.results[-1] = "ended"
        self.last_rects = result.rects

    def update_result(self, result):
        self.pictures += 1

    def test_break(self):
        self.break_times.append(time.monotonic())
        return self.escape()

    def report(self, kinds, text):
        self.reports.append((*kinds, text))

    def error_set(self, text):
        self.errors.append(text)

    def update_stats(self, text, info):
        self.texts.append(text)

    def update_progress(self, fraction):
        self.fractions.append(fraction)

    def update_memory_stats(self, memory_used, memory_peak):
        self.memory = memory_used

    def add_pass(self, name, channels, letters, layer):
        self.results.append(name)


@pytest.fixture
def host(bpy, camera, fake):
    """Returns a Host with our engine's methods; `host.go()` renders the scene."""
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 40, 20
    ours = {name: value for name, value in vars(engine.NepheleRenderEngine).items() if callable(value)}
    made = type("OurHost", (Host,), {**ours, "_session": None, "_viewport": None})()
    made.go = lambda: made.render(bpy.context.evaluated_depsgraph_get())
    return made


def expected(width, height, channel=0):
    y, x = np.mgrid[:height, :width]
    return (1000 * y + x + channel / 10).astype(np.float32)


def test_all_passes_arrive(bpy, render):
    layer = bpy.context.view_layer
    layer.pass_cryptomatte_depth = passes.MOST_LEVELS
    rows = [row for row in passes.PASSES if not row.denoised]
    for row in rows:
        setattr(*toggle_of(layer, row), True)
    channels = render()
    for row in rows:
        for k, letter in enumerate(row.channels):
            name = f"ViewLayer.{engine.blender_name(row)}.{letter}"
            assert np.array_equal(channels[name], expected(40, 20, k)), name


def test_only_passes_asked_for(render, fake):
    assert set(render()) == {f"ViewLayer.Combined.{c}" for c in "RGBA"}
    assert fake.made[-1].scene.film.passes == ("Combined",)


@pytest.mark.parametrize("percent", [100, 55])
def test_resolution_percentage(bpy, render, percent):
    bpy.context.scene.render.resolution_percentage = percent
    assert render()["ViewLayer.Combined.R"].shape == (20 * percent // 100, 40 * percent // 100)


@pytest.mark.parametrize("crop", [False, True])
def test_border(bpy, render, crop):
    """x 8 to 28, y 5 to 18; 0.7 * 40 is 28 in single precision and 27.99... in double."""
    settings = bpy.context.scene.render
    settings.use_border, settings.use_crop_to_border = True, crop
    settings.border_min_x, settings.border_max_x = 0.2, 0.7
    settings.border_min_y, settings.border_max_y = 0.25, 0.9
    picture = render()["ViewLayer.Combined.R"]
    if crop:
        assert np.array_equal(picture, expected(20, 13))
    else:
        assert picture.shape == (20, 40)
        assert np.array_equal(picture[5:18, 8:28], expected(20, 13))
        picture[5:18, 8:28] = 0
        assert not picture.any()


def test_one_render_per_view_layer(bpy, render, fake):
    second = bpy.context.scene.view_layers.new("Second")
    second.nephele.use_pass_volume = True
    channels = render()
    assert [len(r.scene.film.passes) for r in fake.made] == [1, 2]
    assert np.array_equal(channels["Second.Volume.R"], expected(40, 20))
    assert "ViewLayer.Volume.R" not in channels


def test_record_of_the_last_render(bpy, render, monkeypatch):
    heard = []
    monkeypatch.setattr(engine, "listeners", [heard.append])
    bpy.context.scene.frame_set(4)
    render()
    record = engine.last_render
    assert heard == [record]
    assert (record.state, record.frame, record.view_layer) == ("done", 4, "ViewLayer")
    assert (record.warnings, record.statistics["rays"]) == (["the fake renders numbers"], 7)
    assert set(record.seconds) == {"export", "build", "render", "write"}


def test_settings_reach_the_renderer(bpy, render, fake):
    bpy.context.scene.nephele.samples = 3
    bpy.context.scene.nephele.majorant = "global"
    render()
    assert (fake.made[-1].settings["samples"], fake.made[-1].settings["majorant"]) == (3, "global")


def test_progress_and_pictures_on_the_way(host, fake, monkeypatch):
    """First picture after FIRST_UPDATE_SECONDS, further ones ever rarer; progress only grows."""
    monkeypatch.setattr(engine, "FIRST_UPDATE_SECONDS", 0.1)
    monkeypatch.setattr(engine, "STATUS_SECONDS", 0.0)
    fake.seconds = 1.0
    host.go()
    assert host.fractions == sorted(host.fractions)
    assert host.fractions[-1] == 1.0
    assert 3 <= host.pictures <= 8
    assert any(text.startswith("Sample ") and text.endswith(" left") for text in host.texts)
    assert host.memory == 2.0
    assert np.array_equal(host.last_rects["Combined"].reshape(20, 40, 4)[..., 0], expected(40, 20))


def test_escape_stops_within_a_fifth_of_a_second(host, fake):
    fake.seconds = 30.0
    pressed = []

    def escape():
        renderer = fake.made[-1] if fake.made else None
        if renderer is None or renderer.started is None or time.monotonic() < renderer.started + 0.3:
            return False
        pressed.append(time.monotonic())
        return True

    host.escape = escape
    host.go()
    assert time.monotonic() - pressed[0] < 0.2
    assert engine.last_render.state == "cancelled"
    assert np.array_equal(host.last_rects["Combined"].reshape(20, 40, 4)[..., 0], expected(40, 20))  # is kept
    assert host.errors == []


def test_escape_before_the_start(host, fake):
    host.escape = lambda: True
    host.go()
    assert (fake.made, engine.last_render.state, host.results) == ((), "cancelled", ["ended"])


def test_escape_is_seen_often(host, fake):
    """At least every 0.05 s; the median leaves room for a busy machine."""
    fake.seconds = 1.0
    host.go()
    assert np.median(np.diff(host.break_times)) < 0.06


def test_ctrl_c_stops_the_threads(bpy, render, fake):
    """In the bpy module Ctrl C is a KeyboardInterrupt inside render(); Blender prints it and goes on."""
    fake.fault, fake.seconds = KeyboardInterrupt(), 30.0
    render()
    assert fake.made[-1].stop.is_set()
    assert engine.last_render.state == "cancelled"


FAULTS = [ValueError("mesh 'A': bad; mend it"), RuntimeError("out of memory"), TypeError("a bug")]


def fail(fake, monkeypatch, fault, where):
    def refuse(scene, parts):
        raise fault

    if where == "build":
        monkeypatch.setattr(bridge, "create_renderer", refuse)
    else:
        fake.fault = fault


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: type(f).__name__)
@pytest.mark.parametrize("where", ["build", "render"])
def test_failures_reach_scripts(render, fake, monkeypatch, fault, where):
    """Blender raises what an engine reports as an error."""
    fail(fake, monkeypatch, fault, where)
    with pytest.raises(RuntimeError, match=str(fault)):
        render()
    assert engine.last_render.state == "failed"


@pytest.mark.parametrize("fault", FAULTS, ids=lambda f: type(f).__name__)
@pytest.mark.parametrize("where", ["build", "render"])
def test_failures_are_told_twice(host, fake, monkeypatch, fault, where):
    """To the user (error_set) and to scripts (report); results are complete and no thread goes on."""
    fail(fake, monkeypatch, fault, where)
    if isinstance(fault, TypeError):  # a bug of ours also leaves its traceback
        with pytest.raises(TypeError):
            host.go()
    else:
        host.go()
    (error,) = host.errors
    assert str(fault) in error
    assert ("ERROR", error) in host.reports
    assert "begun" not in host.results
    if where == "render":
        assert fake.made[-1].stop.is_set()


def test_export_error_is_reported(bpy, render, camera):
    camera.data.type = "CUSTOM"
    with pytest.raises(RuntimeError, match="unsupported camera"):
        render()


def test_missing_native_module_says_what_to_do(bpy, camera, monkeypatch):
    def missing(name):
        raise ModuleNotFoundError(f"No module named '{name}'", name=name)

    monkeypatch.setattr(bridge.importlib, "import_module", missing)
    with pytest.raises(RuntimeError, match=r"'nephele_native' is not installed.*Install"):
        bpy.ops.render.render()


def test_broken_native_module_says_why(monkeypatch):
    def broken(name):
        raise ImportError("libembree3.so.3: cannot open shared object file")

    monkeypatch.setattr(bridge.importlib, "import_module", broken)
    with pytest.raises(bridge.NativeModuleError, match=r"does not load: libembree3.*Install"):
        bridge.load_native()


def test_animation(bpy, render, fake):
    render()
    bpy.context.scene.frame_end = 3
    bpy.ops.render.render(animation=True)
    assert len(fake.made) == 1 + 3


def test_hidden_objects_are_not_rendered(bpy, render, fake, link):
    """The final depsgraph: what is hidden in the viewport only is rendered, what is disabled in renders is
    not."""
    mesh = bpy.data.meshes.new("Triangle")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    link("Shown", mesh).hide_viewport = True
    link("Hidden", mesh).hide_render = True
    render()
    assert [i.name for i in fake.made[-1].scene.instances] == ["Shown"]


def test_previews_are_quick_and_leave_no_trace(host, fake):
    """Blender's pictures of materials: few samples, whatever the scene says; nothing is reported."""
    before = engine.last_render
    host.is_preview = True
    host.go()
    assert fake.made[-1].settings["samples"] == engine.PREVIEW_SAMPLES < 128
    assert np.array_equal(host.last_rects["Combined"].reshape(20, 40, 4)[..., 0], expected(40, 20))
    assert engine.last_render is before and host.reports == []
    fake.fault = ValueError("bad")
    host.go()
    assert engine.last_render is before and host.reports == host.errors == []


def test_an_engine_that_goes_closes_its_view(host):
    closed = []
    host._viewport = types.SimpleNamespace(close=lambda: closed.append(True))
    host.__del__()
    assert closed == [True]
    host._viewport = None
    host.__del__()
    del host._viewport  # one that never drew a view
    host.__del__()


def test_both_viewport_methods():
    """Half of the pair would crash Blender."""
    assert {"view_draw", "view_update"} <= set(vars(engine.NepheleRenderEngine))


def test_status_text():
    progress = {"samples_done": 3, "samples": 12, "seconds": 65.0, "fraction": 0.25, "error": None}
    assert engine.status_text(progress) == "Sample 3/12 | 1:05 | 3:15 left"
    assert engine.status_text(progress | {"error": 0.0213}) == "Sample 3/12 | 1:05 | Error 0.021 | 3:15 left"
    assert engine.clock(3661) == "1:01:01"
