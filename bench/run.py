# SPDX-License-Identifier: GPL-3.0-or-later
"""What `nephele bench` does: measures the scenes of a suite one after the other, and writes report.html,
report.json and report.csv anew after each, so that what was measured stays after an interrupt."""

import csv
import json
import tempfile

from nephele import statistics
from nephele.errors import InputError
from nephele.output import atomic

from bench import analysis, check, page, reference
from bench.measure import SceneBench

COLUMNS = ("scene", "method", "seed", "slice", "cpu", "samples", *analysis.ERRORS, "bias")


def measure_suite(suite, scenes, options, native_module, say):
    """Measures the BenchScenes and writes the report into options.folder. say: called with lines of
    progress."""
    about = {
        "command": options.command,
        "version": native_module.__version__,
        "commit": statistics.commit(dict(native_module.build_info())),
        "machine": statistics.machine(),
        "options": {
            "methods": list(options.methods),
            "against": list(options.others),
            "budgets": list(options.budgets),
            "seeds": options.seeds,
            "resolution": list(options.resolution),
            "threads": options.threads,
        },
    }
    done = {}
    for scene in scenes:
        with tempfile.TemporaryDirectory() as folder:
            bench = SceneBench(scene, options, folder, lambda text, name=scene.name: say(f"{name}: {text}"))
            result = bench.run()
        done[scene.name] = (scene, result, analysis.summary(result))
        write(suite, done, about, options.folder)
        say(f"{scene.name}: {in_words(done[scene.name][2])}")


def in_words(summary):
    """Returns the gains of a scene in a line."""
    gains = {method: told["against_base"]["gain"] for method, told in summary.items()}
    return "gain " + ", ".join(f"{method} {'-' if g is None else f'{g:.2f}'}" for method, g in gains.items())


def write(suite, done, about, folder):
    """Writes the three files of the report."""
    title = f"Nephele: error against run time, suite {suite}"
    with atomic(folder / "report.html") as temporary:
        temporary.write_text(page.page(title, done, about), encoding="utf-8")
    content = {"suite": suite, "about": about, "scenes": {}}
    for name, (scene, result, summary) in done.items():
        content["scenes"][name] = {
            "about": scene.about,
            "bounces": scene.bounces,
            "reference": result.of
            | {
                "noise": result.reference.noise,
                "mean_error": result.reference.mean_error,
                "provenance": result.reference.provenance,
            },
            "summary": summary,
            "runs": result.rows,
            "told": result.told,
            "failed": result.failed,
        }
    with atomic(folder / "report.json") as temporary:
        temporary.write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    with (
        atomic(folder / "report.csv") as temporary,
        temporary.open("w", newline="", encoding="utf-8") as file,
    ):
        writer = csv.DictWriter(file, COLUMNS, extrasaction="ignore")
        writer.writeheader()
        for name, (_, result, _) in done.items():
            writer.writerows({"scene": name} | row for row in result.rows)


def make_references(scenes, options, say):
    """Makes the references of the BenchScenes, checks them against Cycles and stores them in
    bench/references."""
    for scene in scenes:
        if scene.path.parent.parent.name != "blend_scenes":
            raise InputError(f"{scene.path}: only references of bundled scenes are stored")
        with tempfile.TemporaryDirectory() as folder:
            bench = SceneBench(scene, options, folder, lambda text, name=scene.name: say(f"{name}: {text}"))
            made = bench.make_reference()
            made.provenance["check"] = check.against_cycles(made, bench)
            path = reference.STORED / reference.file_name(scene.name, options.resolution)
            reference.save(path, made, bench.of)
        found = made.provenance["check"]
        say(
            f"{scene.name}: {path}, its own relMSE {made.noise['relmse']:.2g}; {found['program']} is "
            f"{100 * found['difference']:+.2f} % brighter ({found['z']:+.1f} standard errors)"
        )
