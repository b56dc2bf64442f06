# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line `nephele`: reads the arguments, runs a command, turns its outcome into an exit code.

Exit codes: 0 done; 2 bad usage or input, told in one line on stderr; 130 cancelled. A fault of the program
itself shows its traceback and exits with 1.
"""

import argparse
import os
import sys

from . import rendering
from .errors import InputError

BAD_INPUT = 2
CANCELLED = 130


class Parser(argparse.ArgumentParser):
    """An ArgumentParser whose complaint is one line."""

    def error(self, message):
        self.exit(BAD_INPUT, f"{self.prog}: error: {message} (see {self.prog} --help)\n")


def build_parser():
    """Returns the parser of every command; parsed arguments hold the command's function as `run`."""
    # Imported here, inside main(), where Ctrl-C has its exit code already: they take a while.
    from .commands import bench, compare, info, inspect, render, settings

    parser = Parser(prog="nephele", description="Renders Blender scenes with volumes.", allow_abbrev=False)
    commands = parser.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for command in (render, compare, inspect, info, bench, settings):
        command.add_parser(commands)
    return parser


def main(argv=None):
    """Runs the command that `argv` (default: sys.argv[1:]) asks for. Returns the exit code."""
    try:
        arguments = build_parser().parse_args(argv)
        return arguments.run(arguments)
    except SystemExit as leaving:  # argparse: --help or bad usage
        return leaving.code
    except InputError as error:
        print(f"nephele: error: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt:
        print("nephele: cancelled", file=sys.stderr)
        return CANCELLED
    except BrokenPipeError:  # the reader of our output, such as `head`, has gone: nothing more to say
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0


def entry():
    """The installed script `nephele`: main() with the process's arguments; does not return."""
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    if rendering.abandoned():
        # A native call is still busy; it must not meet an interpreter that is being torn down.
        os._exit(code)
    sys.exit(code)
