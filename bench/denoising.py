# SPDX-License-Identifier: GPL-3.0-or-later
"""What denoising is worth at equal samples, by what it is guided by, and beside Cycles.

    python bench/denoising.py [--scenes cloud,suite/fog_lamps] [--samples 16] [--reference 2048] -o FOLDER

Errors against a long render of ours: relMSE and FLIP of the noisy image; denoised without features; with
those of surfaces alone (passes Albedo and Normal); with those that know volumes (Denoising Albedo and
Denoising Normal), which is what `denoise` does. Cycles at as many samples, with its own features, through the
same library. Prints Markdown and writes a PNG of each picture to FOLDER.
"""

import argparse
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from nephele import denoising, metrics  # noqa: E402
from PIL import Image  # noqa: E402

from bench import cycles, ours  # noqa: E402  the project's root is on the path only now

FEATURES = ("Denoising Albedo", "Denoising Normal")
SURFACES = ("Albedo", "Normal")
REFERENCE_SEED = 1000


def denoised(images, features):
    """Returns Combined of one seed, bottom row first for the denoiser and top row first again."""
    layers = [np.ascontiguousarray(images[name][0][::-1, :, :3]) for name in ("Combined", *features)]
    return denoising.denoise(*layers)[::-1]


def variants(path, folder, size, samples):
    """Returns (name -> image, reference-ready description.Scene)."""
    scene = ours.export(path, folder, size)
    mine, _ = ours.render(scene, (1,), ("Combined", *FEATURES, *SURFACES), samples=samples)
    job = cycles.Job(str(path), size, samples, (1,), 1024, passes=("Combined", *FEATURES))
    theirs = cycles.render(job).passes
    return {
        "noisy": mine["Combined"][0],
        "denoised, no features": denoised(mine, ()),
        "denoised, surfaces' features": denoised(mine, SURFACES),
        "denoised": denoised(mine, FEATURES),
        "Cycles, noisy": theirs["Combined"][0],
        "Cycles, denoised": denoised(theirs, FEATURES),
    }, scene


def save(path, image, white):
    """Writes an image as PNG, `white` being the radiance of white."""
    encoded = np.clip(image / white, 0, 1) ** (1 / 2.2)
    Image.fromarray((255 * encoded + 0.5).astype(np.uint8)).save(path)


def main():
    """Measures and prints."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", default="cloud/cloud,suite/fog_lamps")
    parser.add_argument("--resolution", default="240x136")
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--reference", type=int, default=2048)
    parser.add_argument("-o", "--output", required=True, help="folder for the pictures")
    arguments = parser.parse_args()
    folder = Path(arguments.output)
    folder.mkdir(parents=True, exist_ok=True)
    size = tuple(map(int, arguments.resolution.split("x")))
    print("| scene | picture | relMSE | FLIP |\n|---|---|---|---|")
    for name in arguments.scenes.split(","):
        with tempfile.TemporaryDirectory() as unpacked:
            path = ROOT / "blend_scenes" / f"{name}.blend"
            images, scene = variants(path, unpacked, size, arguments.samples)
            long, _ = ours.render(scene, (REFERENCE_SEED,), samples=arguments.reference)
        images["reference"] = long["Combined"][0]
        reference = images["reference"].astype(np.float64)
        white = np.percentile(reference.max(-1), 99)
        for what, image in images.items():
            label = what.replace(",", "").replace("'", "").replace(" ", "_")
            save(folder / f"{Path(name).name}-{label}.png", image, white)
            if what == "reference":
                continue
            error = metrics.compare(image.astype(np.float64), reference, ("relmse", "flip"))
            print(f"| {Path(name).name} | {what} | {error['relmse']:.4g} | {error['flip']:.4f} |", flush=True)


if __name__ == "__main__":
    main()
