# SPDX-License-Identifier: GPL-3.0-or-later
"""What one export shares: warnings, images, materials, and the numbers of UV maps and attributes."""

import numpy as np

from .. import description
from .images import read_image
from .nodes import compile_material


class ExportError(ValueError):
    """The scene cannot be rendered; the message names what is at fault and the remedy."""


class Context:
    """State of one export. depsgraph: Blender's, evaluated. warnings: in order of appearance, each once."""

    def __init__(self, depsgraph):
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene_eval
        self.view_layer = depsgraph.view_layer_eval
        self.warnings = []
        self.materials = []  # description.Material by number
        self.sky_lights = []  # description.Light that the world's nodes make
        self.images = []  # description.Image by number
        self._uv_numbers = {"": 0}  # UV map name -> number; "" is a mesh's active one
        self._attribute_numbers = {}
        self._property_numbers = {}  # key of properties.py -> number
        self._image_numbers = {}  # key of an ImageUse -> number
        self._known_materials = {}  # (name, grids) -> (number, UV maps, attributes)

    def warn(self, text):
        """Adds a warning unless it was given before."""
        if text not in self.warnings:
            self.warnings.append(text)

    def uv_number(self, name):
        return self._uv_numbers.setdefault(name, len(self._uv_numbers))

    def attribute_number(self, name):
        return self._attribute_numbers.setdefault(name, len(self._attribute_numbers))

    def sky_number(self, settings, pixels):
        """Returns the number of the picture of a sky (nodes_sky.py)."""
        key = ("sky", settings)
        if key not in self._image_numbers:
            opaque = np.ones((*pixels.shape[:2], 4), np.float32)
            opaque[..., :3] = pixels
            self._image_numbers[key] = len(self.images)
            self.images.append(description.Image("Sky", opaque))
        return self._image_numbers[key]

    def property_number(self, key):
        return self._property_numbers.setdefault(key, len(self._property_numbers))

    @property
    def property_keys(self):
        """Keys of the objects' properties that programs read, by number."""
        return tuple(self._property_numbers)

    def image_number(self, use, user):
        """Returns the number of an images.ImageUse; of a magenta image, with a warning naming `user`, if it
        cannot be read."""
        if use.key not in self._image_numbers:
            self._image_numbers[use.key] = len(self.images)
            self.images.append(read_image(use, user, self.warn))
        return self._image_numbers[use.key]

    def material_number(self, material, grids=None):
        """Returns (number, UV maps, attributes) of Blender's `material`; -1 for None.

        grids: volume_grids.Grids of the VDB volume or fluid domain that it is for, where only its volume
        shader counts; None for meshes.
        """
        if material is None:
            return (-1 if grids is None else self._default_volume()), {}, {}
        key = (material.name_full, grids)
        if key not in self._known_materials:
            compiled, uvs, attributes = compile_material(material, self, grids)
            self._known_materials[key] = (len(self.materials), uvs, attributes)
            self.materials.append(compiled)
        return self._known_materials[key]

    def _default_volume(self):
        """Returns the number of the material of volumes without one: Principled Volume as Blender adds it."""
        key = ""
        if key not in self._known_materials:
            closure = description.VolumeClosure((0.5,) * 3, (0.5,) * 3, density_grid="density")
            self._known_materials[key] = (len(self.materials), {}, {})
            self.materials.append(description.Material("Default Volume", None, (closure,)))
        return self._known_materials[key][0]
