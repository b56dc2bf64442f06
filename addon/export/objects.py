# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects: walks the depsgraph's instances and sorts them into meshes, lights and volumes."""

from dataclasses import replace

from .. import description
from . import needs
from .fluids import export_fluid, fluid_domain
from .hash import random_number
from .history import uid
from .lights import export_light
from .linking import LightLinks
from .mesh import MeshRecord
from .moving import Tracks
from .neighbours import Neighbours, wants_vectors
from .nodes_input import ray_bits
from .properties import read_properties
from .round_shapes import RoundRecord, curves_source, particle_hair_source, points_source
from .space import matrix4
from .volumes import export_volume

CONVERTIBLE = {"CURVE", "FONT", "SURFACE", "META"}  # shown as the mesh that Blender makes of them
UNSEEN = {"EMPTY", "CAMERA", "ARMATURE", "LATTICE", "SPEAKER", "LIGHT_PROBE"}
UNSUPPORTED = {
    "GREASEPENCIL": "grease pencil is not supported; it is left out",
    "GPENCIL": "grease pencil is not supported; it is left out",
}
ROUND = {"CURVES": curves_source, "POINTCLOUD": points_source}  # shown as tubes and balls
VISIBILITY = {  # property of objects -> bit of opcodes.RAY_KINDS
    "visible_camera": ray_bits("camera"),
    "visible_diffuse": ray_bits("diffuse"),
    "visible_glossy": ray_bits("glossy"),
    "visible_transmission": ray_bits("transmission"),
    "visible_volume_scatter": ray_bits("volume"),
    "visible_shadow": ray_bits("shadow"),
}


class Objects:
    """Everything that stands in the scene. meshes, instances, lights, volumes: of the description, once
    `walk` ran. arrays_by_name: for ExportCache.end()."""

    def __init__(self, context):
        self._context = context
        self._records = {}  # key of evaluated data -> (number, MeshRecord) or None where it has no faces
        self._place, self._places = 0, []  # among the depsgraph's: of the instance read, of self.instances
        self._made = []  # objects whose to_mesh() results are still in use
        self._converted = set()  # objects whose mesh Blender lists by itself
        self._checked = set()  # objects already searched for unsupported features
        self.meshes, self.instances, self.lights, self.volumes = (), [], [], []
        self._names = {}  # (uid of an object, name of its mesh) -> key of its data
        self.arrays_by_name = {}
        self.tracks = Neighbours(context) if wants_vectors(context) else Tracks(context)
        self._seen_uvs = {"": 0} if context.view_layer.use_pass_uv else {}
        self._links = LightLinks(context)
        self._override = context.view_layer.material_override

    def walk(self):
        """Reads all instances."""
        instances = self._context.depsgraph.object_instances
        self._converted = {
            instance.instance_object.original.as_pointer()
            for instance in instances
            if instance.is_instance
            and instance.object.type == "MESH"
            and instance.instance_object is not None
        }
        for self._place, instance in enumerate(instances):
            if self._context.hides(instance):
                continue
            if instance.show_self:
                self._add(instance)
            if instance.show_particles and instance.object.type == "MESH":
                self._add_particle_hair(instance)
        found = {key: entry[1] for key, entry in self._records.items() if entry is not None}
        self.meshes = tuple(record.finish() for record in found.values())
        for key, record in found.items():
            self._context.cache.meshes.put(key, record.arrays)
        self.arrays_by_name = {name: found[key].arrays for name, key in self._names.items() if key in found}
        self._read_properties(instances)
        for item in self._made:
            item.to_mesh_clear()

    def _add(self, instance):
        item = instance.object
        self._check(instance)
        visibility = self._visibility(instance)
        source = self._source(instance)
        if visibility == 0 or not self._is_in_layer(item):
            return  # no ray would ever meet it
        if item.type == "LIGHT":
            light = export_light(self._context, instance, visibility, self._links.of_light(instance))
            if light is not None:
                self.tracks.add("light", len(self.lights), instance)
                self.lights.append(light)
        elif item.type == "VOLUME":
            material = self._material(instance, source)
            self._add_volume(instance, export_volume(self._context, instance, source, material, visibility))
        elif item.type == "MESH" and (domain := fluid_domain(item)) is not None:
            material = self._material(instance, source)
            self._add_volume(instance, export_fluid(self._context, instance, domain, material, visibility))
        elif self._is_mesh(instance):
            self._add_mesh(instance, source, visibility)
        elif item.type in UNSUPPORTED:
            self._context.warn(f"object '{item.name}': {UNSUPPORTED[item.type]}")
        elif item.type not in UNSEEN | CONVERTIBLE:
            self._context.warn(
                f"object '{item.name}': objects of type {item.type.title()} are not supported; left out"
            )

    def _is_mesh(self, instance):
        """Tells whether the instance is shown as triangles."""
        kind = instance.object.type
        return kind == "MESH" or kind in ROUND or (kind in CONVERTIBLE and not self._is_converted(instance))

    def _is_in_layer(self, item):
        """Tells whether the view layer's include settings let it in."""
        layer = self._context.view_layer
        if item.type == "LIGHT":
            return True
        if item.type == "VOLUME":
            return layer.use_volumes
        return layer.use_strand if item.type == "CURVES" else layer.use_solid

    def _read_properties(self, instances):
        """Gives instances what shaders read of their objects: which properties those are is known only
        now."""
        keys = self._context.property_keys(needs.properties_read(self._context.materials))
        if not keys:
            return
        places = {place: number for number, place in enumerate(self._places)}
        for place, instance in enumerate(instances):
            if place in places:
                number = places[place]
                values = read_properties(self._context, instance, keys)
                self.instances[number] = replace(self.instances[number], properties=values)

    def _is_converted(self, instance):
        """True for a curve or the like whose mesh Blender lists as an instance of its own (not for metaballs
        of old versions)."""
        owner = instance.instance_object if instance.is_instance else instance.object
        return owner is not None and owner.original.as_pointer() in self._converted

    def _add_volume(self, instance, volume):
        if volume is not None:
            placed = volume.world_from_object
            self.tracks.add("volume", len(self.volumes), instance, world_from_data=placed)
            self.volumes.append(replace(volume, **self._links.of_object(instance)))

    def _add_mesh(self, instance, source, visibility):
        key, item = self._key(instance), source or instance.object
        self._names[uid(item), item.data.name] = key
        self._context.cache.history.see(item)
        if key not in self._records:
            self._records[key] = self._read(key, item, own=source is not None)
        if self._records[key] is None:
            return
        number, record = self._records[key]
        self._place_mesh(instance, number, record, self._materials(instance, source) or [None], visibility)

    def _add_particle_hair(self, instance):
        """Adds the strands of an object's particle systems, each as a mesh of its own."""
        item, final = instance.object, self._context.depsgraph.mode == "RENDER"
        visibility = self._visibility(instance)
        for modifier in item.modifiers:
            if (
                modifier.type != "PARTICLE_SYSTEM"
                or visibility == 0
                or not self._context.view_layer.use_strand
            ):
                continue
            system = modifier.particle_system
            settings = system.settings
            shown = modifier.show_render if final else modifier.show_viewport
            if settings.type != "HAIR" or settings.render_type != "PATH" or not shown:
                continue
            key = ("hair", item.original.as_pointer(), system.name)
            if key not in self._records:
                source = particle_hair_source(
                    item, system, modifier, self._context.depsgraph, self._context.scene
                )
                self._records[key] = self._round_record(key, system.name, source)
            if self._records[key] is None:
                continue
            number, record = self._records[key]
            slots = [slot.material for slot in item.material_slots] or [None]
            material = self._override or slots[min(settings.material, len(slots)) - 1]
            self._place_mesh(instance, number, record, [material], visibility, part=system.name)

    def _round_record(self, key, name, source, again=None):
        """Returns (number, RoundRecord), or None where there is nothing to see."""
        if len(source.shape.triangles) == 0:
            return None
        number = sum(1 for entry in self._records.values() if entry is not None)
        return number, RoundRecord(name, source, self._context.cache.mesh_before(key, key), again)

    def _place_mesh(self, instance, number, record, slots, visibility, part=""):
        """Adds an instance of a record. slots: materials. part: tells what stands in the same place apart."""
        used = record.used_slots(len(slots))
        numbers = {}
        for slot in sorted(used):
            numbers[slot], uvs, attributes = self._context.material_number(slots[slot])
            record.require(uvs | self._seen_uvs, attributes, self._context.has_surface(numbers[slot]))
        materials = [numbers.get(slot, numbers[min(used)]) for slot in range(len(slots))]
        item = instance.object
        self.tracks.add("instance", len(self.instances), instance, record=record, mesh=number, part=part)
        self._places.append(self._place)
        self.instances.append(
            description.Instance(
                name=item.name,
                mesh=number,
                world_from_object=matrix4(instance.matrix_world),
                materials=tuple(materials),
                visibility=visibility,
                random=random_number(instance),
                color=tuple(item.color),
                pass_index=item.pass_index,
                dielectric_priority=item.nephele.dielectric_priority,
                asset=topmost_parent(item),
                holdout=self._is_holdout(instance),
                **self._links.of_object(instance),
                **self._links.of_light(instance),
            )
        )

    def _key(self, instance):
        """Identifies the evaluated geometry. Curves and the like get their mesh from the object, modifiers
        included."""
        item = instance.object
        data = item.data.as_pointer()
        return data if item.type == "MESH" or item.type in ROUND else (data, item.original.as_pointer())

    def _read(self, key, item, *, own):
        """Returns (number, MeshRecord) of the object's geometry, or None where it has no faces. own: the data
        are the object's, see History."""
        cache, name = self._context.cache, item.data.name
        if item.type in ROUND:
            scene, source_of = self._context.scene, ROUND[item.type]
            return self._round_record(
                key, name, source_of(item.data, scene), lambda data: source_of(data, scene)
            )
        same = cache.history.same_data(item, own=own)
        if item.type == "MESH" and not item.data.is_editmode:
            mesh = item.data
        else:
            mesh = item.to_mesh()
            self._made.append(item)
            same &= item.type != "MESH" and item.type != "META"  # others show in the mesh of one of them
        if mesh is None or len(mesh.polygons) == 0:
            return None
        number = sum(1 for entry in self._records.values() if entry is not None)
        known = cache.meshes.get(key) if same else None
        before = known or cache.mesh_before(key, (uid(item), name))
        return number, MeshRecord(name, mesh, known, before)

    def _source(self, instance):
        """Returns the object whose own data the instance shows, or None where Geometry Nodes made the
        data."""
        owner = instance.instance_object if instance.is_instance else instance.object
        if owner is None or owner.data is None or instance.object.data is None:
            return None
        return owner if owner.data.as_pointer() == instance.object.data.as_pointer() else None

    def _materials(self, instance, source):
        """Returns the materials by slot (None for empty ones)."""
        if source is not None:
            materials = [slot.material for slot in source.material_slots]
        else:
            materials = list(instance.object.data.materials)
        if self._override is not None and instance.object.type != "VOLUME":
            return [self._override] * max(len(materials), 1)
        return materials

    def _material(self, instance, source):
        """Returns the material of a volume, its first."""
        return next(iter(self._materials(instance, source)), None)

    def _visibility(self, instance):
        """Returns the mask of ray kinds that see the instance: its own and its instancer's settings
        together."""
        item = instance.object
        owners = [item] if instance.parent is None else [item, instance.parent]
        mask = 0
        for name, bit in VISIBILITY.items():
            if all(getattr(owner, name) for owner in owners):
                mask |= bit
        layer_object = owners[-1].original
        if layer_object.indirect_only_get(view_layer=self._context.depsgraph.view_layer):
            mask &= ~VISIBILITY["visible_camera"]
        return mask

    def _is_holdout(self, instance):
        """Tells whether the instance is a hole in the picture, by itself or by its collection in the view
        layer."""
        owner = instance.object if instance.parent is None else instance.parent
        layer = self._context.depsgraph.view_layer
        return bool(
            instance.object.is_holdout or owner.is_holdout or owner.original.holdout_get(view_layer=layer)
        )

    def _check(self, instance):
        """Warns, once per object, about features of it that we do not have."""
        item = (instance.parent or instance.object) if instance.is_instance else instance.object
        if item.original.as_pointer() in self._checked:
            return
        self._checked.add(item.original.as_pointer())
        for text in unsupported_features(item, self._context):
            self._context.warn(f"object '{item.name}': {text}")


def topmost_parent(item):
    """Returns the name of an object's topmost parent, "" where it has none: its asset, to cryptomattes."""
    name = ""
    while item.parent is not None:
        item = item.parent
        name = item.name
    return name


def unsupported_features(item, context):
    """Yields a sentence for each feature of the object that changes the picture and that we do not have."""
    layer = context.depsgraph.view_layer
    held_out = item.is_holdout or item.original.holdout_get(view_layer=layer)
    if held_out and item.type == "VOLUME":
        yield "volumes are no holdouts; it renders as usual. Use a mesh"
    if item.is_shadow_catcher and item.type != "LIGHT":
        yield (
            "shadow catchers are not supported; it renders as usual. Catch shadows by rendering with and "
            "without what casts them"
        )
    for modifier in item.modifiers:
        if modifier.type == "SUBSURF" and getattr(modifier, "use_adaptive_subdivision", False):
            yield f"adaptive subdivision ({modifier.name}) is not supported; its fixed level is used"
