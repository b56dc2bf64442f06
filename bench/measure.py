# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders one scene of a suite by every method and program, seed after seed, in time slices.

The methods take turns within a seed, so that what else the machine does meets all alike. Time is the CPU
time of all threads from the built scene on; what is built before is told apart, for every program.
"""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bench import cycles, mitsuba, ours, reference, slices
from bench.methods import METHODS

PILOT_SAMPLES = 8  # of another program, to learn what a sample costs
VSP_PASSES = ("VSP Target", "VSP Achieved")


@dataclass(frozen=True)
class Options:
    """methods, others: names in methods.METHODS and methods.OTHERS. budgets: CPU seconds, ascending. seeds:
    how many. resolution: (width, height). folder: where references that are not stored are kept."""

    methods: tuple
    others: tuple
    budgets: tuple
    seeds: int
    resolution: tuple
    threads: int
    reference_samples: int
    folder: Path
    command: str = ""


@dataclass
class SceneResult:
    """rows: one dict per method, seed and slice: "method", "seed", "slice", "cpu", "samples" and the errors.
    images: method -> (seeds, slices, height, width, 3). maps: method -> {VSP pass: (height, width)}. told:
    method -> what each seed's run cost, a list of dicts. failed: method -> its words. of: what the reference
    is of."""

    reference: reference.Reference
    rows: list = field(default_factory=list)
    images: dict = field(default_factory=dict)
    maps: dict = field(default_factory=dict)
    told: dict = field(default_factory=dict)
    failed: dict = field(default_factory=dict)
    of: dict = field(default_factory=dict)

    def add(self, method, seed, images, cpu, samples, told):
        """Takes in the images of one run, one per slice."""
        for k, image in enumerate(images):
            row = {
                "method": method,
                "seed": seed,
                "slice": k,
                "cpu": float(cpu[k]),
                "samples": int(samples[k]),
            }
            self.rows.append(row | self.reference.errors(image))
        self.images.setdefault(method, []).append(np.asarray(images))
        self.told.setdefault(method, []).append(told)


class SceneBench:
    """One scene, exported once into `folder`, with its reference. say: is called with a line of progress."""

    def __init__(self, scene, options, folder, say):
        self.scene, self.options, self.say = scene, options, say
        self.exported = ours.export(scene.path, folder, options.resolution)
        self.description = str(Path(folder, "scene.nephele"))
        limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), scene.bounces)
        self.shared = {"pixel_filter": "box", "threads": options.threads, "time_limit": 0.0, **limits}
        self.of = reference.wanted(scene, self.exported, options.resolution)

    def find_reference(self):
        """Returns the stored reference, or one made with --reference-samples and kept in the folder."""
        name = reference.file_name(self.scene.name, self.options.resolution)
        stored = reference.load(reference.STORED / name, self.of)
        if stored is not None:
            return stored
        path = self.options.folder / "references" / name
        kept = reference.load(path, self.of)
        if kept is not None and kept.provenance["samples"] >= self.options.reference_samples:
            return kept
        made = self.make_reference()
        reference.save(path, made, self.of)
        return made

    def make_reference(self):
        """Returns a new reference."""
        self.say(f"reference by {self.scene.reference}, {self.options.reference_samples} samples")
        settings = self.shared | METHODS[self.scene.reference]
        return reference.make(
            self.exported,
            self.options.reference_samples,
            settings,
            self.scene.reference,
            self.options.command,
        )

    def run(self):
        """Returns the SceneResult."""
        result = SceneResult(self.find_reference(), of=self.of)
        for seed in range(1, self.options.seeds + 1):
            for method in self.options.methods:
                if method not in result.failed:
                    self.say(f"{method}, seed {seed}")
                    self.add_own(result, method, seed)
        for program in self.options.others:
            self.say(program)
            self.add_other(result, program)
        result.images = {method: np.stack(stack) for method, stack in result.images.items()}
        return result

    def add_own(self, result, method, seed):
        """Adds one run of ours, with the first seed the maps as well, from a run of their own."""
        settings = self.shared | METHODS[method]
        try:
            done = slices.render(slices.Job(self.description, settings, seed, self.options.budgets))
            if done.told["nonfinite_samples"]:
                raise slices.RunFailed(f"{done.told['nonfinite_samples']} samples were not finite")
            result.add(method, seed, done.images, done.cpu, done.samples, done.told)
            if seed == 1:
                middle = self.options.budgets[len(self.options.budgets) // 2]
                job = slices.Job(self.description, settings, seed, (middle,), VSP_PASSES)
                result.maps[method] = {k: v[..., 0] for k, v in slices.render(job).passes.items()}
        except slices.RunFailed as failure:
            result.failed[method] = str(failure)

    def add_other(self, result, program):
        """Adds all runs of another program: its images are rendered anew for every budget."""
        seeds = tuple(range(201, 201 + self.options.seeds))
        try:
            renders = [self.render_other(program, budget, seeds) for budget in self.options.budgets]
        except (mitsuba.NotExpressible, RuntimeError) as failure:
            result.failed[program] = " ".join(str(failure).split())[-300:]
            return
        for k, seed in enumerate(seeds):
            images = [images[k] for images, _, _, _ in renders]
            cpu = [seconds[k] for _, seconds, _, _ in renders]
            samples = [samples for _, _, samples, _ in renders]
            result.add(program, seed, images, cpu, samples, renders[-1][3])

    def render_other(self, program, budget, seeds):
        """Returns (images, CPU seconds, samples, told) of another program at about `budget` CPU seconds."""
        if program == "mitsuba":
            _, seconds = mitsuba.render(self.description, PILOT_SAMPLES, (1, 2), self.scene.bounces)
            samples = fitting_samples(PILOT_SAMPLES, seconds[-1], budget)
            images, seconds = mitsuba.render(self.description, samples, seeds, self.scene.bounces)
            return images, seconds, samples, {}
        guided = program == "cycles_guided"
        pilot = cycles.render(self.cycles_job(PILOT_SAMPLES, (1,), guided))
        samples = fitting_samples(PILOT_SAMPLES, pilot.cpu_seconds[-1], budget)
        done = cycles.render(self.cycles_job(samples, seeds, guided))
        told = {
            "build_cpu": done.warm_up_cpu,
            "peak_rss_bytes": done.peak_rss_bytes,
            "version": done.version,
        }
        return done.passes["Combined"], done.cpu_seconds, samples, told

    def cycles_job(self, samples, seeds, guided):
        """Returns the cycles.Job of this scene, with the light tree, as Cycles' users have it."""
        return cycles.Job(
            str(self.scene.path),
            self.options.resolution,
            samples,
            seeds,
            self.scene.bounces,
            threads=self.options.threads,
            pixel_filter="BOX",
            guiding=guided,
            light_tree=True,
            warm_up=True,
        )


def fitting_samples(samples, cpu, budget):
    """Returns how many samples fit into `budget` CPU seconds if `samples` took `cpu`; at least 1."""
    return max(1, round(samples * budget / cpu))
