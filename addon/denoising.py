# SPDX-License-Identifier: GPL-3.0-or-later
"""Denoising of pictures by Intel's Open Image Denoise, the library that Blender brings along.

It is found where Blender has loaded it, else beside the module `bpy`, else among the system's, and called
through its C interface (version 2; https://www.openimagedenoise.org/documentation.html): a copy of our own
would make each extension zip some 40 MB larger, the size of its trained weights. Knows neither bpy nor the
native module.
"""

import ctypes
import ctypes.util
import functools
import importlib.util
import re
import threading
from pathlib import Path

import numpy as np

LIBRARY = "libOpenImageDenoise"
CPU, FLOAT3 = 1, 3  # OIDN_DEVICE_TYPE_CPU, OIDN_FORMAT_FLOAT3
FEATURES = ("albedo", "normal")

UNAVAILABLE = (
    "denoising needs the library Open Image Denoise 2, which this Blender was built without; use a Blender "
    "from blender.org, install the library, or set denoise to false"
)

_lock = threading.Lock()  # the library's device is one for all


class DenoisingError(RuntimeError):
    """There is no denoiser, or it failed; the message says why and what to do."""


def available():
    """Tells whether there is a denoiser."""
    return _library() is not None


def denoise(color, albedo=None, normal=None, *, prefilter=True):
    """Returns `color` without noise, (h, w, 3) float32.

    color: (h, w, 3) float32, scene-linear, of any range. albedo, normal: the same of what the pixels see
    (passes Denoising Albedo and Denoising Normal), or None. prefilter: the features are noisy themselves and
    are denoised first. Raises DenoisingError; ValueError where shapes do not fit.
    """
    if normal is not None and albedo is None:
        raise ValueError("a denoiser with normals needs albedos, too")
    images = {"color": _plain(color)}
    for name, feature in zip(FEATURES, (albedo, normal), strict=True):
        if feature is not None:
            images[name] = _plain(feature)
    for name, image in images.items():
        if image.shape != images["color"].shape or image.ndim != 3 or image.shape[-1] != 3:
            raise ValueError(f"{name} is {image.shape}, not (h, w, 3) as {images['color'].shape}")
    with _lock:
        if prefilter:
            for name in FEATURES:
                if name in images:
                    images[name] = _filtered({name: images[name]})
        return _filtered(images, hdr=True, cleanAux=prefilter and len(images) > 1)


def _plain(image):
    """Returns finite, contiguous float32."""
    return np.nan_to_num(np.ascontiguousarray(image, np.float32), nan=0.0, posinf=0.0, neginf=0.0)


def _filtered(images, **options):
    """Returns the output of one filter. images: by the library's names."""
    library, device = _library(), _device()
    shape = next(iter(images.values())).shape
    output = np.empty(shape, np.float32)
    chosen = library.oidnNewFilter(device, b"RT")
    try:
        for name, image in {**images, "output": output}.items():
            data = image.ctypes.data_as(ctypes.c_void_p)
            library.oidnSetSharedFilterImage(chosen, name.encode(), data, FLOAT3, shape[1], shape[0], 0, 0, 0)
        for name, value in options.items():
            library.oidnSetFilterBool(chosen, name.encode(), value)
        library.oidnCommitFilter(chosen)
        library.oidnExecuteFilter(chosen)
        _check(library, device)
    finally:
        library.oidnReleaseFilter(chosen)
    return output


def _check(library, device):
    """Raises DenoisingError with the library's words where it has noted an error."""
    message = ctypes.c_char_p()
    if library.oidnGetDeviceError(device, ctypes.byref(message)):
        said = (message.value or b"unknown error").decode(errors="replace")
        raise DenoisingError(f"Open Image Denoise failed: {said}")


@functools.cache
def _device():
    """Returns the processor as a device, made once: that takes some milliseconds."""
    library = _library()
    if library is None:
        raise DenoisingError(UNAVAILABLE)
    device = library.oidnNewDevice(CPU)
    library.oidnSetDeviceBool(device, b"setAffinity", False)  # threads stay where the renderer's are
    library.oidnCommitDevice(device)
    _check(library, device)
    return device


@functools.cache
def _library():
    """Returns the library with its functions declared, or None."""
    for path in _candidates():
        try:
            library = ctypes.CDLL(str(path))
            _declare(library)
        except (OSError, AttributeError):  # damaged, or of version 1
            continue
        return library
    return None


def _candidates():
    """Yields paths where the library may be."""
    maps = Path("/proc/self/maps")
    if maps.exists():
        yield from dict.fromkeys(re.findall(rf"(/\S+/{LIBRARY}\.so[.\d]*)$", maps.read_text(), re.MULTILINE))
    found = importlib.util.find_spec("bpy")
    if found is not None and found.origin:
        yield from sorted(Path(found.origin).parent.glob(f"lib/{LIBRARY}.so*"))
    system = ctypes.util.find_library(LIBRARY.removeprefix("lib"))
    if system:
        yield system


def _declare(library):
    """Declares what is called. Raises AttributeError where the library has no such function."""
    pointer, text, size = ctypes.c_void_p, ctypes.c_char_p, ctypes.c_size_t
    image = [pointer, text, pointer, ctypes.c_int, *[size] * 5]
    functions = {
        "oidnNewDevice": (pointer, [ctypes.c_int]),
        "oidnSetDeviceBool": (None, [pointer, text, ctypes.c_bool]),
        "oidnCommitDevice": (None, [pointer]),
        "oidnGetDeviceError": (ctypes.c_int, [pointer, ctypes.POINTER(ctypes.c_char_p)]),
        "oidnNewFilter": (pointer, [pointer, text]),
        "oidnSetSharedFilterImage": (None, image),
        "oidnSetFilterBool": (None, [pointer, text, ctypes.c_bool]),
        "oidnCommitFilter": (None, [pointer]),
        "oidnExecuteFilter": (None, [pointer]),
        "oidnReleaseFilter": (None, [pointer]),
    }
    for name, (result, arguments) in functions.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
