# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele render`: a .blend or a scene description in, images and statistics out."""

import contextlib

from .. import frame_render, interrupts, render_request, rendering
from ..progress import Reporter


def add_parser(subparsers):
    """Adds the command's arguments."""
    parser = subparsers.add_parser("render", help="render a scene", allow_abbrev=False)
    parser.add_argument(
        "scene", metavar="SCENE", help="a .blend, or a description that --save-description wrote"
    )
    parser.add_argument(
        "-o", "--output", metavar="OUT.exr", help="multilayer EXR; # stands for the frame's digits"
    )
    parser.add_argument(
        "--png", metavar="OUT.png", help="also write Combined with the scene's colour management"
    )
    frames = parser.add_mutually_exclusive_group()
    frames.add_argument(
        "--frame", type=int, metavar="N", help="default: the frame that the .blend was saved at"
    )
    frames.add_argument("--frames", metavar="A-B", help="several frames, both ends included")
    parser.add_argument("--samples", metavar="N", help="paths per pixel")
    parser.add_argument("--time-limit", metavar="S", help="stop after S seconds and write what is there")
    parser.add_argument(
        "--target-error", metavar="E", help="stop at this estimated error (relMSE) and write what is there"
    )
    parser.add_argument("--seed", metavar="N", help="seed of every random decision")
    parser.add_argument(
        "--denoise",
        action="store_const",
        const="true",
        help="take the noise out of Combined; Noisy Image keeps it",
    )
    parser.add_argument("--threads", metavar="N", help="render threads; 0 uses every core")
    parser.add_argument("--resolution", metavar="WxH", help="pixels, instead of the scene's")
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="a setting; see nephele settings"
    )
    parser.add_argument(
        "--preset", metavar="NAME", help="preview, final, reference, benchmark, or a file that Blender saved"
    )
    parser.add_argument("--passes", metavar="P,P,...", help="passes to write, instead of the view layer's")
    parser.add_argument("--stats", metavar="STATS.json", help="write statistics")
    parser.add_argument(
        "--report", metavar="REPORT.html", help="write a page of the estimated error against time"
    )
    parser.add_argument(
        "--resume", action="store_true", help="go on from OUT.exr.checkpoint.npz; skip what is complete"
    )
    parser.add_argument(
        "--guiding-save", metavar="FILE", help="also save what was learned, for --guiding-load"
    )
    parser.add_argument(
        "--guiding-load", metavar="FILE", help="start from what another render of these objects learned"
    )
    parser.add_argument("--quiet", action="store_true", help="show no progress and no warnings")
    parser.add_argument(
        "--save-description", metavar="FILE", help="also save the scene, to render it without Blender"
    )
    parser.set_defaults(run=run)


def run(arguments):
    """Renders every frame that is asked for. Returns the exit code."""
    request = render_request.from_arguments(arguments)
    reporter = Reporter(request.quiet)
    with opened(request) as source:
        parts = rendering.native_module().SceneParts() if len(request.frames) > 1 else None
        for number, frame in enumerate(request.frames):
            frame_render.render_frame(request, source, frame, reporter, first=number == 0, parts=parts)
    return 0


@contextlib.contextmanager
def opened(request):
    """Yields the request's BlendSource or DescriptionSource."""
    with interrupts.raised(), contextlib.ExitStack() as stack:
        if request.is_description:
            from ..description_source import DescriptionSource

            source = DescriptionSource(request.scene, request.resolution)
        else:
            from ..blend_source import BlendSource

            source = BlendSource(request.scene, request.resolution, several=len(request.frames) > 1)
        yield stack.enter_context(source)
