# SPDX-License-Identifier: GPL-3.0-or-later
"""What one export shares: warnings, images, materials, and the numbers of what programs read."""

import contextlib
import dataclasses

from .. import description
from .cache import ExportCache
from .images import kept_image, kept_picture
from .materials import kept_material
from .properties import view_layer_attribute


class ExportError(ValueError):
    """The scene cannot be rendered; the message names what is at fault and the remedy."""


@dataclasses.dataclass
class Record:
    """What was asked of a Context. asked: (kind, name, answer) of UV maps, attributes, properties and values
    of the view layer. notes: warnings. images: whether for one."""

    asked: list = dataclasses.field(default_factory=list)
    notes: list = dataclasses.field(default_factory=list)
    images: bool = False


class Context:
    """State of one export. depsgraph: Blender's, evaluated. cache: ExportCache of the exports before it.
    space: the SpaceView3D that it is for, or None. block: the material or world that is being compiled.
    warnings: in order of appearance, each once."""

    def __init__(self, depsgraph, cache=None, space=None):
        self.depsgraph = depsgraph
        self.space = space
        self.cache = cache or ExportCache()
        self.block = None
        self._record = Record()
        self.scene = depsgraph.scene_eval
        self.view_layer = depsgraph.view_layer_eval
        self.warnings = []
        self.materials = []  # description.Material by number
        self.sky_lights = []  # description.Light that the world's nodes make
        self._images = []  # function that returns the description.Image, by number
        # What programs ask for -> number, by kind. The UV map "" is a mesh's active one.
        self._numbers = {"uv": {"": 0}, "attribute": {}, "property": {}}
        self._image_numbers = {}  # key of an ImageUse or of a sky -> number
        self._known_materials = {}  # (name, grids) -> (number, UV maps, attributes)

    def warn(self, text):
        """Adds a warning unless it was given before."""
        self._record.notes.append(text)
        if text not in self.warnings:
            self.warnings.append(text)

    def hides(self, instance):
        """Tells whether an instance that the depsgraph lists is not to be seen: it is disabled in renders, or
        not in a 3D view's local view or collections."""
        if self.space is None:
            return instance.object.hide_render
        return not (instance.parent or instance.object).visible_in_viewport_get(self.space)

    @contextlib.contextmanager
    def recording(self):
        """Yields the Record of what is asked of the context inside the with statement."""
        self._record = Record()
        yield self._record
        self._record = Record()

    def ask_again(self, asked):
        """Asks for what a Record says was asked for; returns whether the same numbers are given. If not, none
        is."""
        before = {kind: dict(numbers) for kind, numbers in self._numbers.items()}
        if all(self._answer(kind, name) == answer for kind, name, answer in asked):
            return True
        self._numbers = before
        return False

    def _ask(self, kind, name):
        answer = self._answer(kind, name)
        self._record.asked.append((kind, name, answer))
        return answer

    def _answer(self, kind, name):
        if kind == "view layer":
            return view_layer_attribute(self.view_layer, self.scene, name)
        numbers = self._numbers[kind]
        return numbers.setdefault(name, len(numbers))

    def uv_number(self, name):
        return self._ask("uv", name)

    def attribute_number(self, name):
        return self._ask("attribute", name)

    def property_number(self, key):
        """Returns the number of a property of objects. key: see properties.py."""
        return self._ask("property", key)

    def property_keys(self, numbers):
        """Returns the keys of these properties by number, up to the last; None for others."""
        keys = [key if number in numbers else None for key, number in self._numbers["property"].items()]
        return keys[: max(numbers, default=-1) + 1]

    def view_layer_value(self, name):
        """Returns the (3,) colour that attribute `name` of the view layer, or else of the scene, has."""
        return self._ask("view layer", name)

    def image_number(self, use, user):
        """Returns the number of an images.ImageUse, which read_images() may read later. user: text naming the
        node that uses it."""
        block = self.block
        return self._image_number(use.key, lambda: kept_image(use, user, block, self))

    def picture_number(self, name, settings, pixels):
        """Returns the number of a picture that is computed, (h, w, 3), as of a sky or an IES profile; its
        name and settings determine it."""
        return self._image_number((name, settings), lambda: kept_picture(name, settings, pixels, self.cache))

    def _image_number(self, key, read_image):
        self._record.images = True
        if key not in self._image_numbers:
            self._image_numbers[key] = len(self._images)
            self._images.append(read_image)
        return self._image_numbers[key]

    def read_images(self, numbers):
        """Returns the description.Images of these numbers; magenta, with a warning, where one cannot be
        read."""
        return tuple(self._images[number]() for number in numbers)

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
