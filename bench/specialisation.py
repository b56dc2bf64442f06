# SPDX-License-Identifier: GPL-3.0-or-later
"""What a feature costs scenes that lack it: the normal build against builds with one feature compiled out.

    python bench/specialisation.py [--features media,vsp] [--samples 8] [--runs 5] [-o REPORT.md]

Every build (NEPHELE_WITHOUT in cmake/NepheleFeatures.cmake) renders scenes that lack the feature, on one
thread.
Instructions: those of the render alone, by callgrind; both builds trace the same paths (without fused
multiply-adds they compute the same bits), so that they compare exactly, whatever else the machine does. CPU
time: medians of runs in turns. Then the size of the module and the CPU time of compiling the kernels, both
bounded. Prints Markdown; fails where a bound is exceeded.
"""

import argparse
import functools
import json
import os
import re
import resource
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from bench import feature_scenes  # noqa: E402  the project's root is on the path only now

FOLDER = ROOT / "build" / "features"
MODULE = "nephele_native*.so"
PLAIN = {"distance_sampling": "delta", "train_field": "never"}  # nothing is learned
VSP_ALONE = {"train_field": "never"}
FIELD_ALONE = {"distance_sampling": "delta", "train_field": "always"}

# Feature -> (scene that lacks it, settings)
CASES = {
    "media": (("floor", PLAIN), ("room", PLAIN), ("room", {})),
    "overlap": (("cloud", PLAIN), ("cloud", {}), ("flame", PLAIN)),
    "volume_emission": (("cloud", PLAIN), ("alley", PLAIN), ("smoke_screen", PLAIN)),
    "volume_programs": (("cloud", PLAIN), ("smoke_screen", PLAIN), ("flame", PLAIN)),
    "chromatic": (("cloud", PLAIN), ("alley", PLAIN)),
    "motion": (("floor", PLAIN), ("room", PLAIN), ("cloud", PLAIN)),
    "vsp": (("cloud", PLAIN), ("cloud", FIELD_ALONE)),
    "field": (("cloud", PLAIN), ("cloud", VSP_ALONE)),
    "passes": (("floor", PLAIN), ("cloud", PLAIN)),
    "adaptive_sampling": (("floor", PLAIN), ("cloud", PLAIN)),
}
MOST = 1.02  # what a feature may cost where it is not needed
MOST_MODULE_BYTES = 5 << 19  # 2.5 MiB
MOST_COMPILE_SECONDS = 40  # CPU time of integrators/path.cpp; 13 on the machine of docs/performance.md


def run(command, **options):
    """Returns what a command prints. Raises RuntimeError with its words where it fails."""
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False, **options)
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, command))}\n{done.stdout}\n{done.stderr}")
    return done.stdout + done.stderr


def build(without=""):
    """Returns the folder of the module without a feature: optimised as ever, with symbols for profiles, for
    x86-64-v3, since callgrind lacks the newest instructions."""
    run(
        [
            "cmake", "-S", ROOT, "-B", FOLDER / "tree", "-G", "Ninja",
            f"-DPython_EXECUTABLE={sys.executable}",
            "-DCMAKE_BUILD_TYPE=RelWithDebInfo", "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O3 -DNDEBUG -g1",
            "-DNEPHELE_ARCH=x86-64-v3", "-DNEPHELE_TESTS=OFF",
            "-DNEPHELE_COMPARABLE=ON", f"-DNEPHELE_WITHOUT={without}",
        ]
    )  # fmt: skip
    run(["cmake", "--build", FOLDER / "tree", "--target", "nephele_native"])
    place = FOLDER / (f"without_{without}" if without else "everything")
    place.mkdir(exist_ok=True)
    (module,) = (FOLDER / "tree" / "native").glob(MODULE)
    shutil.copy2(module, place)
    return place


def compiled_switch():
    """Returns the library by which a process under callgrind says what to count."""
    library = FOLDER / "callgrind_switch.so"
    run(["cc", "-shared", "-fPIC", "-o", library, ROOT / "bench" / "callgrind_switch.c"])
    return library


def told(output):
    """Returns the JSON that feature_run.py has printed."""
    return json.loads(re.search(r"^\{.*\}$", output, re.MULTILINE)[0])


def command(module, scene, settings, *more):
    """Returns the command line of one run."""
    program = ROOT / "bench" / "feature_run.py"
    return [sys.executable, program, module, scene, settings, "Combined", *more]


@functools.cache
def count(module, scene, settings, switch):
    """Returns (instructions, what the run told). settings: as JSON."""
    valgrind = ["valgrind", "--tool=callgrind", "--instr-atstart=no", "--callgrind-out-file=/dev/null"]
    environment = os.environ | {"PYTHONHASHSEED": "0"}
    output = run([*valgrind, *command(module, scene, settings, switch)], env=environment)
    return int(re.search(r"Collected : (\d+)", output)[1]), told(output)


def cpu_ratio(modules, scene, settings, runs):
    """Returns the median ratio of two modules' CPU times, run in turns."""
    seconds = [[told(run(command(m, scene, settings)))["cpu_seconds"] for m in modules] for _ in range(runs)]
    return statistics.median(a / b for a, b in seconds)


def module_bytes(folder):
    """Returns the size of the module in a folder without its symbols, as it is installed."""
    (module,) = folder.glob(MODULE)
    run(["strip", "-o", FOLDER / "stripped.so", module])
    return (FOLDER / "stripped.so").stat().st_size


def compile_seconds():
    """Returns the CPU seconds of compiling the kernels."""
    commands = json.loads((FOLDER / "tree" / "compile_commands.json").read_text())
    entry = next(c for c in commands if c["file"].endswith("integrators/path.cpp"))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    line = re.sub(r"^\S*ccache ", "", entry["command"])
    run(["sh", "-c", line], cwd=entry["directory"])
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measured(feature, whole, scenes, switch, samples, runs):
    """Yields a row for each case of a feature: (scene, settings in words, instructions, their ratio, CPU
    ratio or None, kernel, whether the image is the same)."""
    without = build(feature)
    for name, settings in CASES[feature]:
        counted = json.dumps(settings | {"samples": samples})
        (a, with_it), (b, without_it) = (count(m, scenes[name], counted, switch) for m in (whole, without))
        timed = json.dumps(settings | {"samples": 16 * samples})
        ratio = cpu_ratio((whole, without), scenes[name], timed, runs) if runs else None
        same = with_it["sha256"] == without_it["sha256"]
        words = ", ".join(f"{k}={v}" for k, v in settings.items()) or "default"
        yield name, words, a, a / b, ratio, with_it["kernel"], same


def main():
    """Measures, prints and writes the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--features", default=",".join(CASES), help=f"of {', '.join(CASES)}")
    parser.add_argument("--samples", type=int, default=8, help="per pixel where instructions are counted")
    parser.add_argument("--runs", type=int, default=5, help="of each build, for CPU time; 0: none")
    parser.add_argument("-o", "--output", help="also write the report here")
    arguments = parser.parse_args()
    features = arguments.features.split(",")
    if unknown := set(features) - set(CASES):
        parser.error(f"--features: no feature is called '{unknown.pop()}'; there are {', '.join(CASES)}")
    if shutil.which("valgrind") is None:
        parser.error("valgrind is missing: apt-get install valgrind")
    shutil.rmtree(FOLDER / "scenes", ignore_errors=True)  # of other sources, maybe
    (FOLDER / "scenes").mkdir(parents=True)
    whole, switch = build(), compiled_switch()
    scenes = feature_scenes.save(FOLDER / "scenes")
    size, seconds = module_bytes(whole), compile_seconds()
    lines = [
        "| without | scene | settings | kernel | instructions | with / without | CPU | same image |",
        "|---|---|---|---|---|---|---|---|",
    ]
    print("\n".join(lines), flush=True)
    worst = []
    for feature in features:
        for row in measured(feature, whole, scenes, switch, arguments.samples, arguments.runs):
            name, words, instructions, ratio, cpu, kernel, same = row
            time = "" if cpu is None else f"{cpu:.3f}"
            lines.append(
                f"| {feature} | {name} | {words} | {', '.join(kernel)} | {instructions / 1e6:.1f} M | "
                f"{ratio:.4f} | {time} | {'yes' if same else 'no'} |"
            )
            print(lines[-1], flush=True)
            if ratio > MOST:
                worst.append(f"{feature} costs {name} {100 * (ratio - 1):.1f} %, although it lacks it")
    lines += ["", f"Module: {size / 2**20:.2f} MiB. Compiling the kernels: {seconds:.1f} CPU s."]
    print("\n".join(lines[-2:]))
    if size > MOST_MODULE_BYTES:
        worst.append(f"the module takes {size} bytes, more than {MOST_MODULE_BYTES}")
    if seconds > MOST_COMPILE_SECONDS:
        worst.append(f"compiling the kernels takes {seconds:.0f} CPU s, more than {MOST_COMPILE_SECONDS}")
    if arguments.output:
        Path(arguments.output).write_text("\n".join(lines) + "\n")
    sys.exit("\n".join(worst) or 0)


if __name__ == "__main__":
    main()
