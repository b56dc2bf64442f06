# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele inspect`: an EXR's maps of guiding, variance and cost, as one HTML page to look at."""

from pathlib import Path

from .. import exr, inspection, maps, output
from ..errors import InputError


def add_parser(subparsers):
    """Adds the command's arguments."""
    parser = subparsers.add_parser(
        "inspect", help="show an EXR's maps of guiding and cost on an HTML page", allow_abbrev=False
    )
    parser.add_argument("image", metavar="OUT.exr", help="what nephele render or Blender wrote")
    parser.add_argument(
        "-o", "--output", metavar="PAGE.html", required=True, help="one file, images included"
    )
    parser.add_argument("--stats", metavar="STATS.json", help="also show the statistics of the render")
    parser.set_defaults(run=run)


def run(arguments):
    """Writes the page. Returns the exit code."""
    output.check_suffix(arguments.output, ".html", "--output")
    output.check_writable(arguments.output)
    statistics = inspection.read_statistics(arguments.stats) if arguments.stats else None
    images = exr.read(arguments.image)
    render = inspection.read_render(arguments.image, exr.read_attributes(arguments.image))
    shown = maps.maps_of(images)
    if not shown:
        wanted = ",".join(name.lower().replace(" ", "_") for name in maps.ORDER if name in maps.BY_NAME)
        raise InputError(
            f"{arguments.image}: has no pass that this page shows (it has {', '.join(images)}); "
            f"render it with nephele render --passes and some of {wanted}"
        )
    page = inspection.page(Path(arguments.image).name, images, shown, render, statistics)
    with output.atomic(arguments.output) as temporary:
        temporary.write_text(page, encoding="utf-8")
    print(f"{arguments.output}: {', '.join(item.name for item in shown)}")
    return 0
