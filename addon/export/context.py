# SPDX-License-Identifier: GPL-3.0-or-later
"""What one export shares: warnings, images, materials, and the numbers of UV maps and attributes."""

import contextlib
import dataclasses

from .. import description
from .cache import ExportCache
from .images import kept_image
from .materials import kept_material


class ExportError(ValueError):
    """The scene cannot be rendered; the message names what is at fault and the remedy."""


@dataclasses.dataclass
class Record:
    """What was asked of a Context. asked: (kind, name, number) of UV maps and attributes. notes: warnings.
    images: whether for one."""

    asked: list = dataclasses.field(default_factory=list)
    notes: list = dataclasses.field(default_factory=list)
    images: bool = False


def _number(numbers, name):
    """Returns the number of a name, the next one where it has none."""
    return numbers.setdefault(name, len(numbers))


class Context:
    """State of one export. depsgraph: Blender's, evaluated. cache: ExportCache of the exports before it.
    block: the material or world that is being compiled. warnings: in order of appearance, each once."""

    def __init__(self, depsgraph, cache=None):
        self.depsgraph = depsgraph
        self.cache = cache or ExportCache()
        self.block = None
        self._record = Record()
        self.scene = depsgraph.scene_eval
        self.view_layer = depsgraph.view_layer_eval
        self.warnings = []
        self.materials = []  # description.Material by number
        self._images = []  # (Blender's image, text naming the node that uses it, block of that) by number
        self._uv_numbers = {"": 0}  # UV map name -> number; "" is a mesh's active one
        self._attribute_numbers = {}
        self._image_numbers = {}
        self._known_materials = {}  # (name, grids) -> (number, UV maps, attributes)

    def warn(self, text):
        """Adds a warning unless it was given before."""
        self._record.notes.append(text)
        if text not in self.warnings:
            self.warnings.append(text)

    @contextlib.contextmanager
    def recording(self):
        """Yields the Record of what is asked of the context inside the with statement."""
        self._record = Record()
        yield self._record
        self._record = Record()

    def ask_again(self, asked):
        """Asks for what a Record says was asked for; returns whether the same numbers are given. If not, none
        is."""
        uvs, attributes = dict(self._uv_numbers), dict(self._attribute_numbers)
        kinds = {"uv": uvs, "attribute": attributes}
        if any(_number(kinds[kind], name) != number for kind, name, number in asked):
            return False
        self._uv_numbers, self._attribute_numbers = uvs, attributes
        return True

    def uv_number(self, name):
        number = _number(self._uv_numbers, name)
        self._record.asked.append(("uv", name, number))
        return number

    def attribute_number(self, name):
        number = _number(self._attribute_numbers, name)
        self._record.asked.append(("attribute", name, number))
        return number

    def image_number(self, image, user):
        """Returns the number of Blender's `image`, which read_images() may read later. user: text naming the
        node that uses it."""
        self._record.images = True
        if image.name_full not in self._image_numbers:
            self._image_numbers[image.name_full] = len(self._images)
            self._images.append((image, user, self.block))
        return self._image_numbers[image.name_full]

    def read_images(self, numbers):
        """Returns the description.Images of these numbers; magenta, with a warning, where one cannot be
        read."""
        return tuple(kept_image(*self._images[number], self) for number in numbers)

    def material_number(self, material, grids=None):
        """Returns (number, UV maps, attributes) of Blender's `material`; -1 for None.

        grids: volume_grids.Grids of the VDB volume or fluid domain that it is for, where only its volume
        shader counts; None for meshes.
        """
        if material is None:
            return (-1 if grids is None else self._default_volume()), {}, {}
        key = (material.name_full, grids)
        if key not in self._known_materials:
            compiled, uvs, attributes = kept_material(material, self, grids)
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
