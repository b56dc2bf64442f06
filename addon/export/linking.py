# SPDX-License-Identifier: GPL-3.0-or-later
"""Light and shadow linking: which objects a light shines on, and which cast its shadows.

Blender has a collection of receivers and one of blockers for each light. The description numbers sets
instead: objects that all collections treat alike share one, and a light names sets by the bits of a mask.
Set 0 is that of objects that no collection names.
"""

from ..description import ALL_SETS

MOST_SETS = 64
KINDS = ("receiver", "blocker")


def states_of(collection):
    """Returns address of an object -> True (included) or False (excluded) for all that a collection names;
    one that is both is excluded."""
    states = {}

    def note(item, included):
        key = item.as_pointer()
        states[key] = states.get(key, True) and included

    for item, link in zip(collection.objects, collection.collection_objects, strict=True):
        note(item.original, link.light_linking.link_state == "INCLUDE")
    for child, link in zip(collection.children, collection.collection_children, strict=True):
        for item in child.all_objects:
            note(item.original, link.light_linking.link_state == "INCLUDE")
    return states


class Sets:
    """The sets that collections of one kind make of all objects. collections: Blender's, each once."""

    def __init__(self, collections):
        self._states = [states_of(collection) for collection in collections]
        self._signatures = {(None,) * len(collections): 0}
        self.too_many = False
        for key in dict.fromkeys(key for states in self._states for key in states):
            self._number(self._signature(key))

    def _signature(self, key):
        return tuple(states.get(key) for states in self._states)

    def _number(self, signature):
        if signature not in self._signatures and len(self._signatures) == MOST_SETS:
            self.too_many = True
            return 0
        return self._signatures.setdefault(signature, len(self._signatures))

    def of(self, item):
        """Returns the number of an object's set."""
        return self._number(self._signature(item.original.as_pointer())) if self._states else 0

    def mask(self, place):
        """Returns the sets, as bits, that the collection at `place` takes in: those that it includes, or,
        where it includes none, all but those that it excludes."""
        wanted = (True,) if True in self._states[place].values() else (True, None)
        return sum(1 << n for signature, n in self._signatures.items() if signature[place] in wanted)


class LightLinks:
    """The linking of all lights of a depsgraph."""

    def __init__(self, context):
        self._places, self._sets = {}, {}
        for kind in KINDS:
            found = {}
            for item in context.depsgraph.objects:
                if (collection := _collection(item, kind)) is not None:
                    found.setdefault(collection.original.as_pointer(), collection.original)
            self._places[kind] = {key: place for place, key in enumerate(found)}
            self._sets[kind] = Sets(list(found.values()))
            if self._sets[kind].too_many:
                context.warn(
                    f"scene '{context.scene.name}': its lights' {kind} collections tell more than "
                    f"{MOST_SETS} kinds of objects apart; the rest counts as named by none. "
                    "Share collections between lights"
                )

    def of_object(self, instance):
        """Returns {receiver_set, blocker_set} of the description of what a depsgraph instance shows."""
        owner = instance.parent if instance.is_instance and instance.parent is not None else instance.object
        return {f"{kind}_set": self._sets[kind].of(owner) for kind in KINDS}

    def of_light(self, instance):
        """Returns {receivers, blockers} of the description of a light, or of an object that may glow."""
        owner = instance.parent if instance.is_instance and instance.parent is not None else instance.object
        return {f"{kind}s": self._mask(owner, kind) for kind in KINDS}

    def _mask(self, owner, kind):
        collection = _collection(owner, kind)
        if collection is None:
            return ALL_SETS
        return self._sets[kind].mask(self._places[kind][collection.original.as_pointer()])


def _collection(item, kind):
    linking = getattr(item, "light_linking", None)
    return getattr(linking, f"{kind}_collection", None)
