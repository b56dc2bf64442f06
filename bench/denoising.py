# SPDX-License-Identifier: GPL-3.0-or-later
"""What denoising is worth at equal samples, by what it is guided by, and beside Cycles.

    python bench/denoising.py [--scenes cumulus,fog_lamps] [--samples 16] [--references FOLDER] -o FOLDER

Errors against references of the suites (bench/reference.py): relMSE and FLIP of the noisy image; denoised
without features; with those of surfaces alone (passes Albedo and Normal); with those that know volumes
(Denoising Albedo and Denoising Normal), which is what `denoise` does. Cycles at as many samples, with its own
features, through the same library. Prints Markdown and writes a PNG of each picture to FOLDER.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from nephele import denoising  # noqa: E402
from nephele.errors import InputError  # noqa: E402
from PIL import Image  # noqa: E402

from bench import cycles, ours, reference, suites  # noqa: E402  the project's root is on the path only now

FEATURES = ("Denoising Albedo", "Denoising Normal")
SURFACES = ("Albedo", "Normal")


def denoised(images, features):
    """Returns Combined of the first seed without noise, top row first."""
    layers = [np.ascontiguousarray(images[name][0][::-1, :, :3]) for name in ("Combined", *features)]
    return denoising.denoise(*layers)[::-1]


def variants(bench_scene, scene, resolution, samples):
    """Returns a dict of what it is -> image, of a BenchScene and its description.Scene."""
    limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), bench_scene.bounces)
    wanted = ("Combined", *FEATURES, *SURFACES)
    mine, _ = ours.render(scene, (1,), wanted, samples=samples, pixel_filter="box", **limits)
    job = cycles.Job(
        str(bench_scene.path), resolution, samples, (1,), bench_scene.bounces,
        passes=("Combined", *FEATURES), pixel_filter="BOX",
    )  # fmt: skip
    theirs = cycles.render(job).passes
    return {
        "noisy": mine["Combined"][0],
        "denoised, no features": denoised(mine, ()),
        "denoised, surfaces' features": denoised(mine, SURFACES),
        "denoised": denoised(mine, FEATURES),
        "Cycles, noisy": theirs["Combined"][0],
        "Cycles, denoised": denoised(theirs, FEATURES),
    }


def save(path, image, white):
    """Writes an image as PNG, `white` being the radiance of white."""
    encoded = np.clip(image / white, 0, 1) ** (1 / 2.2)
    Image.fromarray((255 * encoded + 0.5).astype(np.uint8)).resize(
        (4 * image.shape[1], 4 * image.shape[0]), Image.Resampling.NEAREST
    ).save(path)


def measure(bench_scene, options):
    """Prints the rows of a scene and writes its pictures."""
    resolution = tuple(map(int, options.resolution.split("x")))
    with tempfile.TemporaryDirectory() as unpacked:
        scene = ours.export(bench_scene.path, unpacked, resolution)
        of = reference.wanted(bench_scene, scene, resolution)
        stored = reference.load(options.references / reference.file_name(bench_scene.name, resolution), of)
        if stored is None:
            raise InputError(f"{options.references}: has no reference of {bench_scene.name}")
        images = variants(bench_scene, scene, resolution, options.samples)
    white = np.percentile(stored.image.max(-1), 99)
    save(options.output / f"{bench_scene.name}-reference.png", stored.image, white)
    for what, image in images.items():
        label = what.replace(",", "").replace("'", "").replace(" ", "_")
        save(options.output / f"{bench_scene.name}-{label}.png", image, white)
        error = stored.errors(image)
        print(f"| {bench_scene.name} | {what} | {error['relmse']:.4g} | {error['flip']:.4f} |", flush=True)


def main():
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", default="cumulus,fog_lamps")
    parser.add_argument("--resolution", default="128x72")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--references", type=Path, default=reference.STORED)
    parser.add_argument("-o", "--output", type=Path, required=True, help="folder for the pictures")
    options = parser.parse_args()
    options.output.mkdir(parents=True, exist_ok=True)
    print("| scene | picture | relMSE | FLIP |\n|---|---|---|---|", flush=True)
    for bench_scene in suites.chosen("all", options.scenes.split(","), None):
        measure(bench_scene, options)


if __name__ == "__main__":
    main()
