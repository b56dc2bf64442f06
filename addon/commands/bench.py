# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele bench`: error against run time, of Nephele's methods and of other renderers.

The measuring itself is no part of the add-on: it lies in the folder bench/ of the source tree, with the
scenes.
"""

import shlex
import sys
from pathlib import Path

from .. import rendering
from ..errors import InputError

ROOT = Path(__file__).resolve().parents[2]


def add_parser(subparsers):
    """Adds the command's arguments."""
    parser = subparsers.add_parser(
        "bench", help="measure error against run time and write a report", allow_abbrev=False
    )
    parser.add_argument(
        "suite", metavar="SUITE", nargs="?", help="a suite of bundled scenes, all, or a .blend"
    )
    parser.add_argument("-o", "--output", metavar="DIR", help="directory of report.html, .json and .csv")
    parser.add_argument("--scenes", metavar="S,S,...", help="only these of the suite")
    parser.add_argument(
        "--methods",
        default="delta,vspg,auto",
        metavar="M,M,...",
        help="default: %(default)s; the first is the base",
    )
    parser.add_argument(
        "--against", default="", metavar="P,P,...", help="other programs: cycles, cycles_guided, mitsuba"
    )
    parser.add_argument(
        "--budgets",
        default="2,6,18",
        metavar="S,S,...",
        help="CPU seconds at which errors are taken; default: %(default)s",
    )
    parser.add_argument(
        "--seeds", type=int, default=3, metavar="N", help="images of each; default: %(default)s"
    )
    parser.add_argument("--resolution", default="128x72", metavar="WxH", help="default: %(default)s")
    parser.add_argument("--threads", type=int, default=2, metavar="N", help="default: %(default)s")
    parser.add_argument(
        "--bounces", type=int, default=16, metavar="N", help="of a .blend; default: %(default)s"
    )
    parser.add_argument(
        "--reference-samples", type=int, default=4096, metavar="N", help="of references that are not stored"
    )
    parser.add_argument(
        "--make-references",
        action="store_true",
        help="make the suite's references, check them against Cycles and store them in bench/references",
    )
    parser.add_argument("--list", action="store_true", help="list suites, methods and other programs")
    parser.set_defaults(run=run)


def run(arguments):
    """Measures what is asked for. Returns the exit code."""
    if not (ROOT / "bench" / "run.py").is_file():
        raise InputError(
            "nephele bench needs the folders bench and blend_scenes of Nephele's source tree; run it there"
        )
    sys.path.insert(0, str(ROOT))
    from bench import methods, suites

    if arguments.list:
        print_list(suites, methods)
        return 0
    scenes = suites.chosen(
        arguments.suite or suites.DEFAULT, names(arguments.scenes) or None, arguments.bounces
    )
    options = parsed(arguments, methods)
    from bench import run as bench_run

    if arguments.make_references:
        bench_run.make_references(scenes, options, say)
        return 0
    options.folder.mkdir(parents=True, exist_ok=True)
    native_module = rendering.native_module()
    bench_run.measure_suite(arguments.suite or suites.DEFAULT, scenes, options, native_module, say)
    print(options.folder / "report.html")
    return 0


def parsed(arguments, methods):
    """Returns the measure.Options. Raises InputError for what is out of range or unknown."""
    from bench.measure import Options

    if not (arguments.output or arguments.make_references):
        raise InputError("nephele bench: name the report's directory with -o DIR")
    budgets = tuple(numbers("--budgets", arguments.budgets))
    if list(budgets) != sorted(set(budgets)) or not budgets or budgets[0] <= 0:
        raise InputError(f"--budgets: {arguments.budgets} are not ascending CPU seconds, such as 5,15,45")
    width, height = numbers("--resolution", arguments.resolution, "x", 2)
    least = {"--seeds": 1, "--threads": 1, "--bounces": 1, "--reference-samples": 2}
    for option, minimum in least.items():
        value = getattr(arguments, option[2:].replace("-", "_"))
        if value < minimum:
            raise InputError(f"{option}: {value} is below {minimum}")
    if min(width, height) < 8:
        raise InputError(f"--resolution: {arguments.resolution} is below 8x8")
    return Options(
        methods=methods.checked(names(arguments.methods), methods.METHODS, "--methods"),
        others=methods.checked(names(arguments.against), methods.OTHERS, "--against"),
        budgets=budgets,
        seeds=arguments.seeds,
        resolution=(int(width), int(height)),
        threads=arguments.threads,
        reference_samples=arguments.reference_samples,
        folder=Path(arguments.output or "."),
        command=shlex.join(["nephele", *sys.argv[1:]]),
    )


def names(text):
    """Returns the names in a list with commas."""
    return [name.strip() for name in (text or "").split(",") if name.strip()]


def numbers(option, text, separator=",", count=None):
    """Returns the numbers in a text. Raises InputError where it holds anything else."""
    try:
        values = [float(part) for part in text.split(separator)]
    except ValueError:
        values = []
    if not values or (count is not None and len(values) != count):
        raise InputError(f"{option}: '{text}' cannot be read as numbers separated by '{separator}'")
    return values


def say(line):
    """Prints a line of progress."""
    print(line, file=sys.stderr, flush=True)


def print_list(suites, methods):
    """Prints what can be measured."""
    for suite, scenes in suites.SUITES.items():
        print(f"suite {suite}{' (default)' if suite == suites.DEFAULT else ''}")
        for scene in scenes:
            print(f"    {scene.name:<16} {scene.about}")
    print(f"methods: {', '.join(methods.METHODS)}")
    print(f"against: {', '.join(methods.OTHERS)}")
