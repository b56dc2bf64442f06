# SPDX-License-Identifier: GPL-3.0-or-later
"""Reference images with their own noise, where they came from, and errors against them.

A reference R is the mean of two independent halves A and B. Its own noise shows in their difference:
E[((A - B) / 2)^2] = Var[R]. An image I that is independent of it has E[(I - R)^2] = Var[I] + Var[R] + bias^2,
so that the squared errors that are reported are those of I less the noise of R.

A reference is one EXR file of half floats; its header says in JSON what it is of, how it was made and how
well a second renderer agrees. Those of the suites lie in bench/references (`nephele bench SUITE
--make-references`); others are made when they are needed.
"""

import hashlib
import json
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import OpenEXR
from nephele import exr, metrics, statistics
from nephele.description_file import unique_vdbs
from nephele.errors import InputError
from nephele.output import atomic

from bench import ours

HALF_SEEDS = (1_000_001, 1_000_002)  # far from any seed that is measured
STORED = Path(__file__).resolve().parent / "references"


@dataclass(frozen=True)
class Reference:
    """image: (height, width, 3), top row first. noise: its relMSE against the truth, {"relmse",
    "relmse_trimmed"}. mean_error: standard error of its mean over pixels and channels. provenance: JSON
    values."""

    image: np.ndarray
    noise: dict
    mean_error: float
    provenance: dict = field(default_factory=dict)

    @classmethod
    def of(cls, halves, provenance=None):
        """Returns the Reference of two halves, (2, height, width, 3). Raises ValueError where a pixel is not
        finite."""
        if not np.isfinite(halves).all():
            raise ValueError("an image has pixels that are not finite")
        image = halves.astype(np.float64).mean(axis=0)
        apart = (halves[0].astype(np.float64) - halves[1]) / 2
        noise = metrics.relmse((image + apart).reshape(-1, 3), image.reshape(-1, 3))
        return cls(image, noise, mean_error(apart**2), provenance or {})

    def errors(self, image):
        """Returns {metric: value} of an image (height, width, 3), its squared errors less the reference's
        noise: an image as good as the reference may come out below 0. Raises ValueError where a pixel is not
        finite."""
        if not np.isfinite(image).all():
            raise ValueError("an image has pixels that are not finite")
        found = metrics.compare(np.asarray(image, np.float64), self.image)
        del found["nonfinite_pixels"]
        return found | {name: found[name] - self.noise[name] for name in self.noise}

    def bias_z(self, images):
        """Returns the difference between the mean of images (seeds, height, width, 3) and the reference's in
        standard errors, by the spread over seeds in each pixel; None for a single seed."""
        if len(images) < 2:
            return None
        images = images.astype(np.float64)
        spread = mean_error(images.var(axis=0, ddof=1) / len(images))
        error = np.hypot(spread, self.mean_error)
        return float((images.mean() - self.image.mean()) / error) if error > 0 else None


def mean_error(variance):
    """Returns the standard error of the mean over pixels and channels of an image whose pixels, independent
    of one another, have this variance, (height, width, 3). The channels of a pixel are not independent: their
    deviations are added up."""
    deviation = np.sqrt(variance).mean(axis=-1)
    return float(np.sqrt((deviation**2).sum()) / deviation.size)


def scene_digest(path, scene):
    """Returns a text that changes with the content of the .blend at `path` and of the VDB files of its
    description.Scene."""
    digest = hashlib.sha256(Path(path).read_bytes())
    for vdb in unique_vdbs(scene):
        digest.update(Path(vdb).read_bytes())
    return digest.hexdigest()


def file_name(name, resolution):
    """Returns the name of a reference's file."""
    return f"{name}-{resolution[0]}x{resolution[1]}.exr"


def wanted(bench_scene, scene, resolution):
    """Returns what a reference must be of, as JSON values."""
    return {
        "scene": bench_scene.name,
        "digest": scene_digest(bench_scene.path, scene),
        "resolution": list(resolution),
        "bounces": bench_scene.bounces,
    }


def load(path, of):
    """Returns the Reference in a file, None where there is none or it is of another scene than `of`, see
    wanted(). Raises InputError where the file is damaged."""
    if not path.exists():
        return None
    try:
        told = json.loads(exr.read_attributes(path)["reference"])
        if told["of"] != of:
            return None
        image = exr.read(path)["Combined"][1].astype(np.float64)
        return Reference(image, told["noise"], told["mean_error"], told["provenance"])
    except (KeyError, ValueError) as error:
        raise InputError(f"{path}: not a reference image, or damaged: {error}; remove it") from error


def save(path, reference, of):
    """Writes a Reference. Raises InputError where radiance is beyond what half floats hold."""
    told = {
        "of": of,
        "noise": reference.noise,
        "mean_error": reference.mean_error,
        "provenance": reference.provenance,
    }
    half = reference.image.astype(np.float16)
    if not np.isfinite(half).all():
        raise InputError(f"{path}: radiance above 65504 does not fit into a reference image")
    channels = {letter: np.ascontiguousarray(half[..., i]) for i, letter in enumerate("RGB")}
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "nephele/reference": json.dumps(told),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic(path) as temporary, OpenEXR.File(header, channels) as file:
        file.write(str(temporary))


def make(scene, samples, settings, method, command):
    """Returns the Reference of a description.Scene: `samples` a pixel with the `settings` of a method.
    command: that repeats it."""
    halves, told = ours.render(scene, HALF_SEEDS, samples=max(1, samples // 2), **settings)
    from nephele import rendering  # the native module is there: it has just rendered

    native = rendering.native_module()
    provenance = {
        "command": command,
        "method": method,
        "samples": 2 * max(1, samples // 2),
        "seeds": list(HALF_SEEDS),
        "settings": settings,
        "version": native.__version__,
        "commit": statistics.commit(dict(native.build_info())),
        "cpu_seconds": sum(one["render_cpu_seconds"] for one in told),
        "machine": statistics.machine(),
    }
    return Reference.of(halves["Combined"], provenance)
