# SPDX-License-Identifier: GPL-3.0-or-later
"""The VSP View in Blender: the image it makes of a render, and what it says where there is nothing."""

import types

import numpy as np
import pytest
from nephele import engine, maps, passes, vsp_view
from nephele.false_colour import DIVERGING, SEQUENTIAL, Scale


@pytest.fixture
def rendered(monkeypatch):
    """Returns a function that puts passes, name -> (h, w), in the place of the last render's."""

    def put(**images):
        images = {passes.lookup(name).name: pixels[..., np.newaxis] for name, pixels in images.items()}
        record = engine.RenderRecord(1, "ViewLayer", "done", images=images)
        monkeypatch.setattr(engine, "last_render", record)

    return put


def view_pixels(bpy):
    """Returns the image's pixels, 8-bit sRGB, bottom row first."""
    image = bpy.data.images["VSP View"]
    width, height = image.size
    pixels = np.empty(width * height * 4, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = np.rint(pixels.reshape(height, width, 4) * 255).astype(np.uint8)
    assert (pixels[..., 3] == 255).all()
    return pixels[..., :3]


def test_a_map_over_its_legend(bpy, rendered):
    target = np.linspace(0, 1, 30 * 40, dtype=np.float32).reshape(30, 40)
    rendered(vsp_target=target)
    assert bpy.ops.nephele.vsp_view(map="VSP Target") == {"FINISHED"}
    shown = view_pixels(bpy)
    assert shown.shape == (30 + 4 + 1, 40, 3)
    assert np.array_equal(
        shown[5:], Scale(0, 1).colours(target)
    )  # the bottom row of the render at the bottom
    assert (shown[4] == 0).all()
    for row in shown[:4]:
        assert tuple(row[0]) == SEQUENTIAL[0] and tuple(row[-1]) == SEQUENTIAL[-1]
    assert bpy.data.images["VSP View"][vsp_view.LEGEND] == "VSP Target: 0 (dark) to 1 (bright)"


def test_the_same_image_takes_the_next_map_and_size(bpy, rendered):
    rendered(vsp_target=np.zeros((30, 40), np.float32))
    bpy.ops.nephele.vsp_view(map="VSP Target")
    half = np.full((8, 16), 0.5, np.float32)
    rendered(vsp_target=half, vsp_achieved=half / 2)
    bpy.ops.nephele.vsp_view(map=maps.DIFFERENCE)
    assert [image.name for image in bpy.data.images if image.name.startswith("VSP")] == ["VSP View"]
    shown = view_pixels(bpy)
    assert shown.shape == (8 + 4 + 1, 16, 3)
    assert (shown[5:] == DIVERGING[0]).all()
    assert "blue" in bpy.data.images["VSP View"][vsp_view.LEGEND]


def test_says_what_is_missing(bpy, rendered, monkeypatch):
    monkeypatch.setattr(engine, "last_render", None)
    with pytest.raises(RuntimeError, match="nothing has been rendered"):
        bpy.ops.nephele.vsp_view()
    rendered(cost=np.ones((2, 2), np.float32))
    with pytest.raises(RuntimeError, match="does not hold VSP Target; enable the pass"):
        bpy.ops.nephele.vsp_view(map="VSP Target")
    with pytest.raises(RuntimeError, match="VSP Achieved and VSP Target"):
        bpy.ops.nephele.vsp_view(map=maps.DIFFERENCE)
    assert "VSP View" not in bpy.data.images


def test_image_editors_show_it(bpy):
    editor = types.SimpleNamespace(image=None)
    areas = [
        types.SimpleNamespace(type="VIEW_3D", spaces=None),
        types.SimpleNamespace(type="IMAGE_EDITOR", spaces=types.SimpleNamespace(active=editor)),
    ]
    windows = [types.SimpleNamespace(screen=types.SimpleNamespace(areas=areas))]
    context = types.SimpleNamespace(window_manager=types.SimpleNamespace(windows=windows))
    assert vsp_view.show(context, "the image") and editor.image == "the image"
    windows.clear()
    assert not vsp_view.show(context, "the image")


def test_the_menu_offers_every_map(bpy):
    items = bpy.ops.nephele.vsp_view.get_rna_type().properties["map"].enum_items
    assert [item.identifier for item in items] == list(maps.FALSE_COLOURED)
