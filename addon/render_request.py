# SPDX-License-Identifier: GPL-3.0-or-later
"""What `nephele render` is asked to do: its arguments, checked before anything slow begins."""

import dataclasses
import re
from pathlib import Path

from . import archive, parameters, passes, pictures, preset_files
from .errors import InputError
from .output import check_suffix, check_writable, frame_path

# The first bytes of a .blend: plain, zstd or gzip.
BLEND_MAGIC = (b"BLENDER", b"\x28\xb5\x2f\xfd", b"\x1f\x8b")
OUTPUTS = ("image", "png", "stats", "report", "description", "guiding_save")  # attributes of a Request
FLAGS = (
    "samples",
    "time_limit",
    "target_error",
    "seed",
    "threads",
    "denoise",
)  # settings with an option of their own


@dataclasses.dataclass(frozen=True)
class Request:
    """A checked `nephele render`. frames: numbers, or (None,) for the scene's own. overrides: checked
    settings. passes: names, or () for the scene's own."""

    scene: str
    is_description: bool
    frames: tuple = (None,)
    several: bool = False
    resolution: tuple | None = None
    overrides: dict = dataclasses.field(default_factory=dict)
    passes: tuple = ()
    image: str | None = None
    png: str | None = None
    stats: str | None = None
    report: str | None = None
    description: str | None = None
    guiding_save: str | None = None
    guiding_load: str | None = None
    resume: bool = False
    quiet: bool = False

    def path(self, kind, frame):
        """Returns where `kind` (see OUTPUTS) of `frame` goes, or None."""
        template = getattr(self, kind)
        return frame_path(template, frame, self.several) if template else None

    def applied(self, scene):
        """Returns a description.Scene with the overrides and passes. Raises InputError where they do not fit
        it."""
        try:
            settings = parameters.checked(scene.settings | self.overrides)
        except (KeyError, ValueError) as error:
            raise InputError(f"{self.scene}: {error.args[0]}") from error
        film = dataclasses.replace(scene.film, passes=self.passes or own_passes(scene, settings))
        check_png_pass(self.png, film.passes)
        scene = dataclasses.replace(scene, settings=settings, film=film)
        try:
            pictures.denoises(scene)
        except pictures.denoising.DenoisingError as error:
            raise InputError(f"{self.scene}: {error}") from error
        return scene


def own_passes(scene, settings):
    """Returns the names of the passes that a description.Scene asks for by itself, with these settings."""
    wanted = set(scene.film.passes or ("Combined",)) - {"Noisy Image"}
    if settings["denoise"] and "Combined" in wanted:
        wanted.add("Noisy Image")
    return tuple(row.name for row in passes.PASSES if row.name in wanted)


def from_arguments(arguments):
    """Returns the Request of parsed arguments. Raises InputError."""
    frames = (None,)
    if arguments.frame is not None:
        frames = (arguments.frame,)
    elif arguments.frames:
        frames = parsed_frames(arguments.frames)
    request = Request(
        scene=arguments.scene,
        is_description=is_description(arguments.scene),
        frames=frames,
        several=arguments.frames is not None,
        resolution=parsed_resolution(arguments.resolution) if arguments.resolution else None,
        overrides=parsed_settings(arguments),
        passes=parsed_passes(arguments.passes) if arguments.passes is not None else (),
        image=arguments.output,
        png=arguments.png,
        stats=arguments.stats,
        report=arguments.report,
        description=arguments.save_description,
        guiding_save=arguments.guiding_save,
        guiding_load=arguments.guiding_load,
        resume=arguments.resume,
        quiet=arguments.quiet,
    )
    if request.is_description and frames != (None,):
        raise InputError(
            f"{request.scene}: a description file holds one frame; leave --frame and --frames out"
        )
    check_outputs(request)
    if request.passes:
        check_png_pass(request.png, request.passes)
    return request


def is_description(path):
    """Tells whether `path` is a description file (else a .blend). Raises InputError where it is neither."""
    if not Path(path).is_file():
        raise InputError(f"{path}: no such file")
    try:
        with Path(path).open("rb") as file:
            start = file.read(7)
        if archive.is_archive(path):
            return True
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    if not start.startswith(BLEND_MAGIC):
        raise InputError(f"{path}: neither a .blend nor a Nephele scene description")
    return False


def parsed_frames(text):
    """Returns the frames of "A-B" as a tuple."""
    match = re.fullmatch(r"(-?\d+)-(-?\d+)", text)
    if not match or int(match[1]) > int(match[2]):
        raise InputError(f"--frames: '{text}' is not a range such as 1-24")
    return tuple(range(int(match[1]), int(match[2]) + 1))


def parsed_resolution(text):
    """Returns (width, height) of "WxH"."""
    match = re.fullmatch(r"(\d+)x(\d+)", text)
    if not match or not (1 <= int(match[1]) <= 65536 and 1 <= int(match[2]) <= 65536):
        raise InputError(f"--resolution: '{text}' is not a size in pixels such as 640x360")
    return int(match[1]), int(match[2])


def parsed_settings(arguments):
    """Returns the checked settings of --preset, of --set NAME=VALUE and of the options that are settings: the
    later win."""
    values = preset_files.values(preset_files.find(arguments.preset)) if arguments.preset else {}
    try:
        for text in arguments.set:
            name, equals, value = text.partition("=")
            if not equals:
                raise InputError(f"--set: '{text}' is not of the form NAME=VALUE")
            values[name] = parameters.lookup(name).parse(value)
        for name in FLAGS:
            if getattr(arguments, name) is not None:
                values[name] = parameters.lookup(name).parse(getattr(arguments, name))
        if arguments.report:
            values["estimate_error"] = True
    except (KeyError, ValueError) as error:
        raise InputError(f"settings: {error.args[0]}") from error
    return values


def parsed_passes(text):
    """Returns the names of a comma-separated list of passes, each once, in the order of the table."""
    try:
        wanted = {passes.lookup(name).name for name in text.split(",")}
    except KeyError as error:
        raise InputError(f"--passes: {error.args[0]}") from error
    return tuple(p.name for p in passes.PASSES if p.name in wanted)


def check_outputs(request):
    """Raises InputError where an output cannot be written or two are the same file."""
    if not request.image and not request.description:
        raise InputError("nothing to write: name an image with -o OUT.exr")
    for option, path in (
        ("--png", request.png),
        ("--stats", request.stats),
        ("--report", request.report),
        ("--resume", request.resume),
        ("--guiding-save", request.guiding_save),
        ("--guiding-load", request.guiding_load),
    ):
        if path and not request.image:
            raise InputError(f"{option} needs an image: name one with -o OUT.exr")
    for option, suffix, path in (
        ("-o", ".exr", request.image),
        ("--png", ".png", request.png),
        ("--report", ".html", request.report),
    ):
        if path:
            check_suffix(path, suffix, option)
    taken = {Path(request.scene).resolve()}
    if request.guiding_load:
        taken.add(Path(request.guiding_load).resolve())
    for kind in OUTPUTS:
        path = request.path(kind, request.frames[0])
        if path is None:
            continue
        if path.resolve() in taken:
            raise InputError(f"{path}: is named twice; inputs and outputs must differ")
        taken.add(path.resolve())
        check_writable(path)


def check_png_pass(png, names):
    """Raises InputError where a PNG is wanted of a render without Combined."""
    if png and "Combined" not in names:
        raise InputError(f"{png}: a PNG shows the pass Combined, which --passes leaves out")
