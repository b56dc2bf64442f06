# SPDX-License-Identifier: GPL-3.0-or-later
"""What guiding brings and costs, of the volume scattering probability (VSP) and by the field: error times CPU
time against delta tracking, at equal samples and at equal CPU time, in scenes that ask for more, less and
the same scattering, and in two lit only indirectly.

    python bench/vsp.py [--scenes alley,milk] [--configs delta,vspg] [--resolution 160x90] [--seeds 5]
        [--samples 64] [--reference-samples 8192] [--no-equal-time] [--cycles] [--output FILE.json]

Two passes over each scene. First every configuration renders the same samples with every seed, in turns;
its efficiency is (relMSE x CPU seconds) of delta tracking over its own. Then each gets as many samples as
fit into delta tracking's CPU time, and its gain is delta tracking's relMSE over its own. CPU time is that
of the process from the scene in memory to the finished image: preparation and learning count. The
reference is delta tracking's, in the scenes lit indirectly that of the whole field (see reference.py).
--cycles: Cycles too, without and with its path guiding. --mitsuba: Mitsuba 3's volpathmis too, in the scenes
that it can express. Prints Markdown, writes out/bench/vsp.json.
"""

import argparse
import json
import statistics
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from nephele import parameters  # noqa: E402  the project's root is on the path only now

from bench import cycles, mitsuba, ours, reference, vsp_report  # noqa: E402
from bench.foundation import cpu_seconds  # noqa: E402


@dataclass(frozen=True)
class Workload:
    """A bundled scene. wants: in a word, how an ideal VSP compares with delta tracking's, or what is hard.
    bounces: of each kind and of all together. reference: the configuration that renders it."""

    path: str
    wants: str
    bounces: int
    reference: str = "delta"


SCENES = {
    "alley": Workload("guiding/alley.blend", "wants more", 16),
    "mist": Workload("guiding/mist.blend", "wants more", 16),
    "ember": Workload("guiding/ember.blend", "wants less", 32),
    "smoke_screen": Workload("guiding/smoke_screen.blend", "wants less", 16),
    "cumulus": Workload("guiding/cumulus.blend", "wants about the same", 32),
    "milk": Workload("guiding/milk.blend", "adverse", 128),
    "overlap": Workload("overlap/overlap.blend", "chromatic", 16),
    "door": Workload("indirect/door.blend", "indirect light", 32, "everything"),
    "window": Workload("indirect/window.blend", "indirect light", 32, "everything"),
}


def vspg(control, criterion="variance", **extensions):
    """Returns the settings of VSP guiding with only the named extensions on."""
    off = {"vsp_cost": False, "vsp_product": False, "vsp_gather": False, "train_field": "never"}
    return (
        {"distance_sampling": "vspg", "vsp_control": control, "vsp_criterion": criterion} | off | extensions
    )


def field(**techniques):
    """Returns the settings of the guiding field used always, for the named techniques only."""
    off = dict.fromkeys(("guide_directions", "vsp_secondary", "guided_roulette"), False)
    return {"train_field": "always"} | off | techniques


NO_FIELD = {"train_field": "never"}
DELTA = "delta"
CONFIGS = {
    DELTA: {"distance_sampling": "delta", **NO_FIELD},
    "nds": {"distance_sampling": "nds", **NO_FIELD},
    "nds_plus": {"distance_sampling": "nds_plus", **NO_FIELD},
    "exact contribution": vspg("exact", "contribution"),
    "exact variance": vspg("exact"),
    "conditional": vspg("conditional"),
    "conditional+cost": vspg("conditional", vsp_cost=True),
    "conditional+product": vspg("conditional", vsp_product=True),
    "conditional+gather": vspg("conditional", vsp_gather=True),
    "vspg": {"distance_sampling": "vspg", **NO_FIELD},
    "directions": field(guide_directions=True),
    "segments": field(vsp_secondary=True),
    "directions+segments": field(guide_directions=True, vsp_secondary=True),
    "everything": field(guide_directions=True, vsp_secondary=True, guided_roulette=True),
    "auto": {},  # as users get it
}
CYCLES = {"Cycles": False, "Cycles, guided": True}  # whether by its path guiding


class Bench:
    """One scene in memory with its reference; measures images of it."""

    def __init__(self, name, options, folder):
        self.name, self.work, self.options = name, SCENES[name], options
        self.path = ROOT / "blend_scenes" / self.work.path
        self.scene = ours.export(self.path, folder, options.resolution)
        self.description = Path(folder, "scene.nephele")
        limits = dict.fromkeys(("max_bounces", "surface_bounces", "volume_bounces"), self.work.bounces)
        self.shared = {"pixel_filter": "box", "threads": options.threads, **limits}
        ours.render(self.scene, (0,), samples=1, **self.shared)  # from now on the grids are in memory
        self.reference = reference.load_or_render(
            options.output.parent / "vsp_references",
            name,
            self.scene,
            options.reference_samples,
            **self.shared,
            **CONFIGS[self.work.reference],
        )

    def measure(self, config, seed, samples):
        """Returns one run: seed, samples, CPU seconds and errors."""
        before = cpu_seconds()
        settings = self.shared | CONFIGS[config]
        images, told = ours.render(self.scene, (seed,), samples=samples, **settings)
        cpu = cpu_seconds() - before
        if told[0]["nonfinite_samples"]:
            raise RuntimeError(f"{self.name}, {config}: {told[0]['nonfinite_samples']} samples not finite")
        error = self.reference.error(images["Combined"][0])
        return {"seed": seed, "samples": samples, "cpu": cpu, **error}

    def equal_samples(self):
        """Returns {configuration: runs}, in turns, so that what else the machine does meets all alike."""
        runs = {config: [] for config in self.options.configs}
        for seed in range(1, self.options.seeds + 1):
            for config in self.options.configs:
                runs[config].append(self.measure(config, seed, self.options.samples))
        return runs

    def equal_time(self, first):
        """Returns {configuration: runs} at the sample counts that `first`, the runs of equal samples, say."""
        budget = median(first[DELTA], "cpu")
        counts = {
            c: fitting_samples(self.options.samples, median(r, "cpu"), budget) for c, r in first.items()
        }
        runs = {config: [] for config in first}
        for seed in range(101, 101 + self.options.seeds):
            for config, samples in counts.items():
                runs[config].append(self.measure(config, seed, samples))
        return runs

    def with_cycles(self, budget, guiding):
        """Returns runs of Cycles at about `budget` CPU seconds an image; the first seed, which pays for what
        Cycles keeps from one image to the next, is left out. guiding: whether by its path guiding."""
        pilot = self.cycles_job(8, (1, 2), guiding)
        samples = fitting_samples(8, cycles.render(pilot).cpu_seconds[-1], budget)
        seeds = tuple(range(201, 202 + self.options.seeds))
        renders = cycles.render(self.cycles_job(samples, seeds, guiding))
        rows = zip(seeds, renders.cpu_seconds, renders.passes["Combined"], strict=True)
        return [
            {"seed": seed, "samples": samples, "cpu": float(cpu), **self.reference.error(image)}
            for seed, cpu, image in list(rows)[1:]
        ]

    def with_mitsuba(self, budget):
        """Returns runs of Mitsuba at about `budget` CPU seconds an image, none where it cannot render this
        scene. Surfaces differ a little: the error holds that difference too."""
        try:
            _, seconds = mitsuba.render(self.description, 8, (1, 2), self.work.bounces)
        except mitsuba.NotExpressible as error:
            print(f"{self.name}: not for Mitsuba: {error}", file=sys.stderr)
            return []
        samples = fitting_samples(8, seconds[-1], budget)
        seeds = tuple(range(301, 301 + self.options.seeds))
        images, seconds = mitsuba.render(self.description, samples, seeds, self.work.bounces)
        return [
            {"seed": seed, "samples": samples, "cpu": float(cpu), **self.reference.error(image)}
            for seed, cpu, image in zip(seeds, seconds, images, strict=True)
        ]

    def cycles_job(self, samples, seeds, guiding):
        """Returns the cycles.Job of this scene, with the light tree, as Cycles' users have it."""
        return cycles.Job(
            str(self.path),
            self.options.resolution,
            samples,
            seeds,
            self.work.bounces,
            threads=self.options.threads,
            pixel_filter="BOX",
            guiding=guiding,
            light_tree=True,
        )

    def run(self):
        """Returns everything measured in this scene as JSON values."""
        row = {
            "wants": self.work.wants,
            "bounces": self.work.bounces,
            "reference_noise": self.reference.noise,
        }
        row["equal_samples"] = self.equal_samples()
        if self.options.equal_time:
            row["equal_time"] = self.equal_time(row["equal_samples"])
        budget = median(row["equal_samples"][DELTA], "cpu")
        row["others"] = {}
        if self.options.cycles:
            row["others"] = {name: self.with_cycles(budget, guiding) for name, guiding in CYCLES.items()}
        if self.options.mitsuba and (runs := self.with_mitsuba(budget)):
            row["others"]["Mitsuba"] = runs
        row["summary"] = summary(row)
        return row


def median(runs, key):
    """Returns the median over seeds."""
    return statistics.median(run[key] for run in runs)


def relative_cpu(runs, base):
    """Returns the median over turns of the CPU seconds over those of `base` in the same turn: what else the
    machine does slows down both."""
    return statistics.median(run["cpu"] / other["cpu"] for run, other in zip(runs, base, strict=True))


def fitting_samples(samples, cpu, budget):
    """Returns how many samples fit into `budget` CPU seconds if `samples` took `cpu`; at least 1."""
    return max(1, round(samples * budget / cpu))


def standard_error(values):
    """Returns the standard error of the mean of a list, None for one value."""
    return float(np.std(values, ddof=1) / len(values) ** 0.5) if len(values) > 1 else None


def medians(runs):
    """Returns the medians of one configuration's runs, the spread of trimmed relMSE and the mean bias."""
    row = {key: median(runs, key) for key in ("samples", "cpu", "relmse", "relmse_trimmed")}
    trimmed, bias = ([run[key] for run in runs] for key in ("relmse_trimmed", "bias"))
    spread = standard_error(trimmed)
    row["relative_error"] = spread / abs(row["relmse_trimmed"]) if spread and row["relmse_trimmed"] else None
    return row | {"bias": statistics.fmean(bias), "bias_error": standard_error(bias)}


def ratio(a, b):
    """Returns a / b, None where noise has made one of the errors 0 or less."""
    return a / b if a > 0 and b > 0 else None


def summary(row):
    """Returns {configuration: medians and gains over delta tracking} of one scene's runs."""
    result = {}
    base = medians(row["equal_samples"][DELTA])
    for config, runs in row["equal_samples"].items():
        own = medians(runs)
        cost = relative_cpu(runs, row["equal_samples"][DELTA])
        for name, gain in (("relmse", "efficiency"), ("relmse_trimmed", "efficiency_trimmed")):
            own[gain] = ratio(base[name], own[name] * cost)
        result[config] = {"equal_samples": own}
    timed = row.get("equal_time", {}) | row.get("others", {})
    base = medians(timed[DELTA]) if DELTA in timed else base
    for config, runs in timed.items():
        own = medians(runs)
        for name, gain in (("relmse", "gain"), ("relmse_trimmed", "gain_trimmed")):
            own[gain] = ratio(base[name], own[name])
        result.setdefault(config, {})["equal_time"] = own
    return result


def parsed_size(text):
    """Returns (width, height) of "WxH"; argparse reports the ValueError."""
    width, height = (int(number) for number in text.split("x"))
    return width, height


def parsed_options():
    """Returns the checked arguments."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--scenes", type=lambda text: text.split(","), default=list(SCENES))
    parser.add_argument("--configs", type=lambda text: text.split(","), default=list(CONFIGS))
    parser.add_argument("--resolution", type=parsed_size, default=(160, 90), metavar="WxH")
    parser.add_argument("--samples", type=int, default=64, help="of a pixel, at equal samples")
    parser.add_argument("--seeds", type=int, default=5, help="images of each configuration")
    parser.add_argument("--reference-samples", type=int, default=8192)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--no-equal-time", dest="equal_time", action="store_false")
    parser.add_argument(
        "--cycles", action="store_true", help="also Cycles at equal CPU time, without and with path guiding"
    )
    parser.add_argument("--mitsuba", action="store_true", help="also Mitsuba 3 (scripts/setup.sh bench)")
    parser.add_argument("--output", type=Path, default=ROOT / "out" / "bench" / "vsp.json")
    options = parser.parse_args()
    for what, names, known in (
        ("scene", options.scenes, SCENES),
        ("configuration", options.configs, CONFIGS),
    ):
        for name in names:
            if name not in known:
                parser.error(f"no {what} is called '{name}'; there are {', '.join(known)}")
    if min(options.samples, options.seeds) < 1 or options.reference_samples < 2:
        parser.error("--samples and --seeds must be at least 1, --reference-samples at least 2")
    options.configs = list(dict.fromkeys([DELTA, *options.configs]))
    for config in options.configs:
        parameters.checked(CONFIGS[config])
    return options


def main():
    options = parsed_options()
    options.output.parent.mkdir(parents=True, exist_ok=True)
    told = {key: value for key, value in vars(options).items() if key != "output"}
    results = {"options": told, "configs": CONFIGS, "scenes": {}}
    for name in options.scenes:
        with tempfile.TemporaryDirectory() as folder:
            results["scenes"][name] = Bench(name, options, folder).run()
        options.output.write_text(json.dumps(results, indent=2))  # what is there stays after an interrupt
        print(vsp_report.scene_table(name, results), flush=True)
    if len(results["scenes"]) > 1:
        print(vsp_report.overview(results))


if __name__ == "__main__":
    main()
