# SPDX-License-Identifier: GPL-3.0-or-later
"""Draws a picture into a region of a 3D view, by Blender's graphics module."""

import gpu
from gpu_extras.presets import draw_texture_2d


class Drawing:
    """Keeps the latest picture on the graphics card. To be used while Blender draws."""

    def __init__(self):
        self._picture = self._texture = None

    def draw(self, engine, scene, picture):
        """Draws a viewport_worker.Picture; Blender puts the display transform of `scene` over it."""
        if picture is not self._picture:
            self._texture = _texture(picture.pixels)
            self._picture = picture
        x, y, width, height = picture.place
        gpu.state.blend_set("ALPHA_PREMULT")
        engine.bind_display_space_shader(scene)
        draw_texture_2d(self._texture, (x, y), width, height)
        engine.unbind_display_space_shader()
        gpu.state.blend_set("NONE")


def _texture(pixels):
    height, width = pixels.shape[:2]
    data = gpu.types.Buffer("FLOAT", (height, width, 4), pixels)
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=data)
