# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/passes.md: the table of addon/passes.py between two texts.

python tools/generate_pass_page.py
"""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "passes.md"

HEAD = """\
# Render passes

Made by `tools/generate_pass_page.py`; edit that.

A pass is asked for in *View Layer Properties > Passes*, or with `nephele render --passes "Combined,Volume Direct"` (either
spelling: `volume_direct`). Passes that mean the same as Cycles' have its names, those of Blender 5, and its toggles, so that files
and compositor graphs that were made for Cycles go on working; Blender 4 calls some of them otherwise (*old name*), and there we do,
too. What nobody asks for is neither kept nor computed: light passes, cryptomattes and denoising data come from kernels of their own,
which trace the same paths; only in scenes of a single medium Combined may be rounded otherwise with them.

In EXR files channels are called `ViewLayer.Pass.Channel`. Colours are scene-linear Rec. 709, times the film's exposure where
they are light. World space is Blender's. Values are means over a pixel's samples but for those of the *first sample*, which cannot
be averaged: a mean over a silhouette would be a depth where nothing is.

"""

TAIL = """
**The sum.** Light is told apart by its first event, as in Cycles: translucency counts as diffuse, what glass reflects as
glossy, and light is direct where no other event followed. With D, G and T for Diffuse, Glossy and Transmission,

    Combined = Emission + Environment + Volume Direct + Volume Indirect
             + D Color (D Direct + D Indirect) + G Color (G Direct + G Indirect) + T Color (T Direct + T Indirect)
    Combined = Volume + Surface

to rounding, of the picture before it is denoised (Noisy Image). Where a colour is 0 its light passes are 0. `clamp` scales
all of a sample's parts alike. Volume and Surface also tell apart by first event, but count what volumes emit as Volume; what
Cycles 5 calls Volume Scatter and Volume Transmit is Volume Direct + Volume Indirect, and what passed a volume.

**Volumes and the geometry passes.** Depth, Position, Normal, Vector, UV, Mist and the indices see through volumes: they are those of the
first surface whose alpha is at least the view layer's *Alpha Threshold*, smooth also where fog lies before it. In Cycles a volume dims
Normal, UV and Mist, and hides Depth, Position and the indices at random. Colours and cryptomattes are dimmed by volumes in both: they
are what is left of a surface's share of the pixel. Mist is measured as in Cycles: by the distance from the camera, of all surfaces
that are seen through transparent ones.

**Cryptomattes** hold two ranks a pass, by coverage; *Levels* of the view layer says how many there are. All ids of a pixel are kept
until the end, so that ranks are exact and do not depend on the number of threads (there is nothing to choose between, as *Accurate
Mode* does in old Blenders). Files carry the manifest of names; Blender's Cryptomatte node and others take both.
Volumes have no id of their own.

**Denoising.** With the setting `denoise` (*Sampling > Denoise*, `--denoise`; off by default) Combined is denoised at the end of
a final render by Open Image Denoise, and the pass Noisy Image keeps it as it was; alpha and all other passes stay as they are. It is
guided by Denoising Albedo and Denoising Normal, which are those of the first event that is not a mirror or clear glass: on a surface
its albedo and normal, in a volume its single-scattering albedo and no normal, each by its share of the pixel, and the light of
emitters and the background up to 1. The library is Blender's own, which every Blender from blender.org and the module `bpy` have; where
a distribution's Blender lacks it (Debian's does), `denoise` is refused with a message that says so. The compositor's Denoise node
does the same with the same passes.

**What there is not.** Ambient Occlusion, Shadow, Shadow Catcher and subsurface passes, shader AOVs and light groups: asking for one
gives a warning, and it stays black. Ambient Occlusion and Shadow Catcher are no part of the light that a scene with volumes has.
"""


def load():
    """Returns the module addon/passes.py, loaded by path."""
    spec = importlib.util.spec_from_file_location("nephele_passes", ROOT / "addon" / "passes.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    return module


FIRST_SAMPLE = {"Depth", "Position", "Vector", "Object Index", "Material Index"}


def asked_by(row):
    """Returns what asks for a pass."""
    if row.view_layer:
        return "Blender"
    if row.cycles:
        return "Cycles, else Nephele"
    return "`denoise`" if row.denoised else "Nephele"


def page():
    """Returns the page's text."""
    lines = ["| pass | channels | unit | toggle | old name | what it is |", "|---|---|---|---|---|---|"]
    for row in load().PASSES:
        if row.levels > 1:
            continue  # further ranks of the same
        name = row.name[:-2] + "00 to 07" if row.levels else row.name
        doc = f"{row.doc} (first sample)" if row.name in FIRST_SAMPLE else row.doc
        doc = doc.replace(", ranks 1 and 2", ", two ranks each") if row.levels else doc
        lines.append(f"| {name} | {row.channels} | {row.unit} | {asked_by(row)} | {row.old_name} | {doc} |")
    return HEAD + "\n".join(lines) + "\n" + TAIL


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
