# SPDX-License-Identifier: GPL-3.0-or-later
"""The judge of the extreme cases: what a row of the tables says, and what is asked of its renders.

Every render of a row must end within its CPU seconds, without a sample that is no number and without a
density above its bound; its image must be finite, and its mean what is expected: a closed form, or what a
twin renders (the plain integrator, another tracker, or the same scene in other numbers).

Pixels are independent estimates, so of image minus expectation every pixel has expectation 0, and the means
over the image and over its four quarters are held to 0 by Student's t, all channels together at a false alarm
of FALSE_ALARM a render (Sidak); seeds are fixed. A render too noisy to tell fails too.
"""

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import nephele_native
import numpy as np
import pytest
import scipy.stats
from truth import BOX_FILTER, NO_LIMIT

FALSE_ALARM = 1e-6
ANALOG = {"distance_sampling": "delta", "tracking": "delta", "train_field": "never"}
WAYS = {
    "default": {},
    "delta": ANALOG,
    "decomposition": {
        "distance_sampling": "delta",
        "tracking": "decomposition",
        "transmittance": "residual_ratio",
    },
    "exact": {"vsp_control": "exact"},
    "nds": {"distance_sampling": "nds"},
    "nds_plus": {"distance_sampling": "nds_plus"},
    "field": {"train_field": "always"},
    "kdtree": {"majorant": "kdtree"},
    "marching": {"transmittance": "ray_marching"},
    "plain": {"integrator": "plain"},
}
GUIDED = ("default", "exact", "field")
TRACKED = ("default", "delta", "decomposition", "exact", "nds", "field")
GRIDS = (*TRACKED, "nds_plus", "kdtree", "marching")


@dataclass(frozen=True)
class Twin:
    """Another render with the same expectation: of `scene` (the row's own where None) by these settings, its
    image times `scale`."""

    scene: Callable | None = None
    settings: dict = field(default_factory=dict)
    scale: float = 1.0


@dataclass(frozen=True)
class Case:
    """A row. scene: returns a truth.Scene, or a description.Scene in which only the settings are the judge's.
    expected: a number a channel, a Twin, or None (only finite, for what has no reference). ways: names of
    WAYS. rounding: relative error allowed besides, what single precision and the reference cost. most:
    largest standard error, relative. cpu: seconds, for building and rendering. quick: runs in `make test`,
    the first of its ways."""

    name: str
    scene: Callable
    expected: object
    ways: tuple = ("default",)
    samples: int = 64
    size: object = 16
    passes: tuple = ("Combined",)
    settings: dict = field(default_factory=dict)
    rounding: float = 1e-5
    most: float = 0.03
    cpu: float = 10.0
    quick: bool = False


@dataclass(frozen=True)
class Refusal:
    """A row that cannot be rendered: building it says so in one line, with all of `words`."""

    name: str
    scene: Callable
    words: tuple
    cpu: float = 5.0
    quick: bool = True


def render(scene, case, seed, **settings):
    """Returns (image, CPU seconds), image (height, width, 3) float64."""
    begin = time.process_time()
    if hasattr(scene, "description"):
        scene = scene.description(size=case.size, passes=case.passes)
    wanted = scene.settings | BOX_FILTER | NO_LIMIT | {"samples": case.samples, "seed": seed} | settings
    renderer = nephele_native.Renderer(dataclasses.replace(scene, settings=wanted))
    renderer.start()
    if not renderer.wait(120 + 20 * case.cpu):
        renderer.cancel()
        pytest.fail(f"no end after {120 + 20 * case.cpu:.0f} s")
    statistics = renderer.statistics()
    assert statistics["nonfinite_samples"] == 0
    assert statistics["bound_violations"] == 0
    for name in scene.film.passes:
        assert np.isfinite(renderer.read_pass(name)).all(), f"the pass {name} is not finite"
    image = renderer.read_pass("Combined")
    return image[..., :3].astype(np.float64), time.process_time() - begin


def quarters(image):
    """Returns the image and its four quarters, each (pixels, 3); parts of fewer than 16 pixels are left
    out."""
    h, w = image.shape[0] // 2, image.shape[1] // 2
    parts = [image, image[:h, :w], image[:h, w:], image[h:, :w], image[h:, w:]]
    return [p.reshape(-1, 3) for p in parts if p.size >= 48]


def deviation(image, expected, rounding):
    """Returns (t / allowed t, relative deviation, relative standard error), each the worst of all means."""
    expected = np.broadcast_to(np.asarray(expected, float), image.shape)
    scale = max(np.abs(expected).max(), 1e-300)  # squares of 1e-20 and 1e20 stay within reach
    parts = list(zip(quarters(image / scale), quarters(expected / scale), strict=True))
    worst = relative = noise = 0.0
    for ours, theirs in parts:
        n, wanted = len(ours), theirs.mean(0)
        off = ours - theirs
        # What is rare may be missing in a quarter: it counts as no less noisy than the image.
        error = np.maximum(off.std(0, ddof=1), (parts[0][0] - parts[0][1]).std(0, ddof=1)) / np.sqrt(n)
        beyond = np.abs(off.mean(0)) - rounding * np.abs(wanted)
        t = np.where(beyond > 0, beyond / np.maximum(error, 1e-15 * np.maximum(wanted, 1e-12)), 0)
        share = 1 - (1 - FALSE_ALARM) ** (1 / (3 * len(parts)))
        worst = max(worst, float(t.max() / scipy.stats.t.isf(share / 2, n - 1)))
        if n == parts[0][0].shape[0]:
            floor = np.maximum(np.abs(wanted), 0.01 * np.abs(wanted).max())
            floor = np.where(floor > 0, floor, 1)
            relative = max(relative, float((np.abs(off.mean(0)) / floor).max()))
            noise = max(noise, float((error / floor).max()))
    return worst, relative, noise


def judge(case, way, note):
    """Renders a row one way and holds it to what it says; note(name, value) keeps figures for the summary."""
    settings = WAYS[way] | case.settings
    image, cpu = render(case.scene(), case, 11, **settings)
    note("cpu", cpu)
    expected = case.expected
    if isinstance(expected, Twin):
        twin, _ = render((expected.scene or case.scene)(), case, 12, **(settings | expected.settings))
        expected = twin * expected.scale
    if expected is not None:
        worst, relative, noise = deviation(image, expected, case.rounding)
        note("deviation", relative)
        note("t", worst)
        text = (
            f"got {image.mean((0, 1))}, expected {np.mean(np.broadcast_to(expected, image.shape), (0, 1))}: "
            f"{worst:.2f} of the deviation allowed, {relative:.2g} relative, standard error {noise:.2g}"
        )
        assert worst <= 1, text
        assert noise <= case.most, f"too noisy to tell: {text}"
    assert cpu <= case.cpu, f"took {cpu:.1f} CPU seconds, allowed {case.cpu}"


def refuse(case, note):
    """Holds a row that cannot be rendered to its message."""
    begin = time.process_time()
    with pytest.raises((ValueError, RuntimeError)) as refused:
        render(case.scene(), Case(case.name, case.scene, None), 11)
    note("cpu", time.process_time() - begin)
    message = str(refused.value)
    assert "\n" not in message
    assert all(word in message for word in case.words), message
    assert time.process_time() - begin <= case.cpu
