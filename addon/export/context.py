# SPDX-License-Identifier: GPL-3.0-or-later
"""What one export shares: warnings, images, materials, and the numbers of UV maps and attributes."""

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
        self._images = []  # (Blender's image, text naming the node that uses it) by number
        self._uv_numbers = {"": 0}  # UV map name -> number; "" is a mesh's active one
        self._attribute_numbers = {}
        self._image_numbers = {}
        self._known_materials = {}  # (name, grids) -> (number, UV maps, attributes)

    def warn(self, text):
        """Adds a warning unless it was given before."""
        if text not in self.warnings:
            self.warnings.append(text)

    def uv_number(self, name):
        return self._uv_numbers.setdefault(name, len(self._uv_numbers))

    def attribute_number(self, name):
        return self._attribute_numbers.setdefault(name, len(self._attribute_numbers))

    def image_number(self, image, user):
        """Returns the number of Blender's `image`, which read_images() may read later. user: text naming the
        node that uses it."""
        if image.name_full not in self._image_numbers:
            self._image_numbers[image.name_full] = len(self._images)
            self._images.append((image, user))
        return self._image_numbers[image.name_full]

    def read_images(self, numbers):
        """Returns the description.Images of these numbers; magenta, with a warning, where one cannot be
        read."""
        return tuple(read_image(*self._images[number], self.warn) for number in numbers)

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

    def has_surface(self, number):
        """Tells whether the material of this number, -1 for the default, is that of a surface."""
        return number < 0 or self.materials[number].surface is not None

    def _default_volume(self):
        """Returns the number of the material of volumes without one: Principled Volume as Blender adds it."""
        key = ""
        if key not in self._known_materials:
            closure = description.VolumeClosure((0.5,) * 3, (0.5,) * 3, density_grid="density")
            self._known_materials[key] = (len(self.materials), {}, {})
            self.materials.append(description.Material("Default Volume", None, (closure,)))
        return self._known_materials[key][0]
