# SPDX-License-Identifier: GPL-3.0-or-later
"""Properties of objects that shaders read: attributes of the object or its instancer, its place on the
instancer, its particle. Each is four numbers per instance, numbered by key.

A key is (kind, name): ("OBJECT" or "INSTANCER", an attribute's name), ("PLACE", "orco" or "uv"), or
("PARTICLE", an output of Particle Info)."""

from .hash import hash_pair

INSTANCER = {"Generated": ("PLACE", "orco"), "UV": ("PLACE", "uv")}  # by output of Texture Coordinate

# Mesh attributes that the exporter computes; no attribute of Blender's can be called so.
POINTINESS, ISLAND_RANDOM = "\0pointiness", "\0random per island"
# Of strands and points: attribute -> output of Curves Info or Point Info.
STRAND = {
    f"\0strand {output}": output
    for output in ("Is Strand", "Intercept", "Length", "Thickness", "Random", "Radius", "Position")
}

NOTHING = (0.0, 0.0, 0.0, 1.0)
ABSENT = (0.0, 0.0, 0.0, 0.0)


def particle_property(output):
    """Returns the key of an output of Particle Info."""
    return ("PARTICLE", output)


def read_properties(context, instance, keys):
    """Returns the values of `keys` (ABSENT for None) for one depsgraph instance: tuple of (r, g, b, a)."""
    return tuple(ABSENT if key is None else _value(context, instance, *key) for key in keys)


def _value(context, instance, kind, name):
    if kind == "OBJECT":
        item = instance.object
        return _first(name, item, item.data)
    if kind == "INSTANCER":
        item = instance.parent if instance.is_instance else instance.object
        return _first(name, item, item.data) if item is not None else ABSENT
    if kind == "PLACE":
        return _place(instance, name)
    return _particle(context, instance, name)


def view_layer_attribute(view_layer, scene, name):
    """Returns the (3,) colour that attribute `name` of the view layer, or else of the scene, has."""
    return _first(name, view_layer, scene)[:3]


def _first(name, *owners):
    for owner in owners:
        if owner is not None and (value := _attribute(owner, name)) is not None:
            return value
    return ABSENT


def _attribute(owner, name):
    """Returns RGBA of a custom property or of a built-in one (by its path), or None where there is none."""
    value = owner.get(name)
    if value is None:
        try:
            value = owner.path_resolve(name)
        except ValueError:
            return None
    if isinstance(value, bool | int | float):
        return (float(value),) * 3 + (1.0,)
    try:
        numbers = [float(v) for v in value]
    except (TypeError, ValueError):
        return None
    return tuple((*numbers, 0.0, 0.0, 0.0)[:3]) + ((numbers[3],) if len(numbers) > 3 else (1.0,))


def _place(instance, name):
    if not instance.is_instance:
        return NOTHING
    if name == "uv":
        return (*instance.uv, 0.0, 1.0)
    return (*(0.5 * x - 0.5 for x in instance.orco), 1.0)


PARTICLE = {  # output of Particle Info -> what a particle's is
    "Age": lambda particle, frame: frame - particle.birth_time,
    "Lifetime": lambda particle, frame: particle.lifetime,
    "Location": lambda particle, frame: particle.location,
    "Size": lambda particle, frame: particle.size,
    "Velocity": lambda particle, frame: particle.velocity,
    "Angular Velocity": lambda particle, frame: particle.angular_velocity,
}


def _particle(context, instance, output):
    system = instance.particle_system if instance.is_instance else None
    index = instance.persistent_id[0] if system is not None else -1
    if system is None or not 0 <= index < len(system.particles):
        return (hash_pair(0, 0) / 0xFFFFFFFF,) * 3 + (1.0,) if output == "Random" else NOTHING
    if output == "Index":
        value = float(index)
    elif output == "Random":
        value = hash_pair(index, 0) / 0xFFFFFFFF
    else:
        value = PARTICLE[output](system.particles[index], context.scene.frame_current_final)
    return (value,) * 3 + (1.0,) if isinstance(value, float) else (*value, 1.0)
