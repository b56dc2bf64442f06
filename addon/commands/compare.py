# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele compare`: how far an image is from a reference, pass by pass."""

import json

from .. import exr, metrics
from ..errors import InputError


def add_parser(subparsers):
    """Adds the command's arguments."""
    parser = subparsers.add_parser("compare", help="compare the passes of two EXR files", allow_abbrev=False)
    parser.add_argument("image", metavar="A.exr")
    parser.add_argument("reference", metavar="REF.exr")
    parser.add_argument(
        "--metric", default=",".join(metrics.NAMES), help="comma-separated; default: %(default)s"
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.set_defaults(run=run)


def run(arguments):
    """Prints the metrics of every pass that both files hold. Returns the exit code."""
    names = arguments.metric.split(",")
    for name in names:
        if name not in metrics.NAMES:
            raise InputError(
                f"--metric: no metric is called '{name}'; valid names: {', '.join(metrics.NAMES)}"
            )
    image, reference = exr.read(arguments.image), exr.read(arguments.reference)
    common = [name for name in image if name in reference]
    if not common:
        raise InputError(
            f"{arguments.image} ({', '.join(image)}) and {arguments.reference} ({', '.join(reference)}) "
            "have no pass in common"
        )
    report = {
        "image": arguments.image,
        "reference": arguments.reference,
        "passes": {},
        "only_in_image": [name for name in image if name not in reference],
        "only_in_reference": [name for name in reference if name not in image],
    }
    for name in common:
        report["passes"] |= compare_pass(arguments, name, image, reference, names)
    if arguments.json:
        print(json.dumps(report, indent=2))
    else:
        print_table(report)
    return 0


def compare_pass(arguments, name, image, reference, names):
    """Returns a dict of row name -> metrics for one pass; alpha, being no colour, has a row of its own."""
    letters, a = image[name]
    reference_letters, r = reference[name]
    shared = "".join(letter for letter in letters if letter in reference_letters)
    if not shared:
        raise InputError(
            f"pass {name} has channels {letters} in {arguments.image} "
            f"but {reference_letters} in {arguments.reference}"
        )
    if a.shape[:2] != r.shape[:2]:
        sizes = [f"{pixels.shape[1]}x{pixels.shape[0]}" for pixels in (a, r)]
        raise InputError(
            f"pass {name} is {sizes[0]} in {arguments.image} but {sizes[1]} in {arguments.reference}"
        )
    colour = {"R", "G", "B"} <= set(shared)
    groups = {name: shared.replace("A", "") if colour else shared}
    if colour and "A" in shared:
        groups[f"{name}.A"] = "A"
    rows = {}
    for row, group in groups.items():
        picked = [
            a[..., [letters.index(c) for c in group]],
            r[..., [reference_letters.index(c) for c in group]],
        ]
        variance = combined_variance(image, reference, a.shape[:2]) if row == "Combined" else None
        size = {"width": a.shape[1], "height": a.shape[0], "channels": group}
        rows[row] = size | metrics.compare(
            *picked, names, colour=len(group) >= 3 and colour, variance=variance
        )
    return rows


def combined_variance(image, reference, shape):
    """Returns the (h, w) variance of Combined's difference: the sum of both files' Variance passes. A file
    without counts as exact, so a noisy reference without Variance makes bias_z too large. None where neither
    has one."""
    found = [file["Variance"][1][..., 0] for file in (image, reference) if "Variance" in file]
    if not found or any(pixels.shape != shape for pixels in found):
        return None
    return sum(found)


def print_table(report):
    """Prints the report as columns."""
    columns = []
    for row in report["passes"].values():
        columns += [key for key in row if key not in columns and key not in ("width", "height", "channels")]
    width = max(len(name) for name in report["passes"])
    print(
        f"{'pass':<{width}}  {'size':>11}  {'channels':<8}" + "".join(f"  {column:>16}" for column in columns)
    )
    for name, row in report["passes"].items():
        cells = (f"  {text(row[column]) if column in row else '':>16}" for column in columns)
        print(f"{name:<{width}}  {row['width']}x{row['height']:<6}  {row['channels']:<8}" + "".join(cells))
    for key, file in (("only_in_image", report["image"]), ("only_in_reference", report["reference"])):
        if report[key]:
            print(f"only in {file}: {', '.join(report[key])}")


def text(value):
    """Returns a number as a cell."""
    return "undefined" if value is None else str(value) if isinstance(value, int) else f"{value:.6g}"
