# SPDX-License-Identifier: GPL-3.0-or-later
"""One module per command: add_parser(subparsers), and run(arguments), which returns the exit code."""
