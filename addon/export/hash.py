# SPDX-License-Identifier: GPL-3.0-or-later
"""Hashes behind Object Info's Random: Bob Jenkins' lookup3 (2006, public domain) of two integers, and one of
text."""

MASK = 0xFFFFFFFF


def hash_text(text):
    """Returns a 32-bit number of `text`: base 37 over its UTF-8 bytes."""
    result = 0
    for byte in text.encode():
        signed = byte - 256 if byte > 127 else byte
        result = (result * 37 + signed) & MASK
    return result


def hash_pair(first, second):
    """Returns lookup3's 32-bit hash of two 32-bit integers."""
    a = b = c = (0xDEADBEEF + (2 << 2) + 13) & MASK
    a, b = (a + first) & MASK, (b + second) & MASK
    c = _mix(c, b, 14)
    a = _mix(a, c, 11)
    b = _mix(b, a, 25)
    c = _mix(c, b, 16)
    a = _mix(a, c, 4)
    b = _mix(b, a, 14)
    return _mix(c, b, 24)


def random_number(instance):
    """Returns Object Info's Random in [0, 1]: Blender's for instances, from the name for other objects, as in
    Cycles."""
    bits = instance.random_id if instance.is_instance else hash_pair(hash_text(instance.object.name), 0)
    return (bits & 0xFFFFFFFF) / 0xFFFFFFFF


def _mix(target, source, bits):
    rotated = ((source << bits) | (source >> (32 - bits))) & MASK
    return ((target ^ source) - rotated) & MASK
