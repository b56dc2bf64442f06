# SPDX-License-Identifier: GPL-3.0-or-later
"""Errors that are the user's to mend, told apart from faults of the program."""


class InputError(Exception):
    """Bad usage or input. Its text is one line that names the file or option and the fault; the exit code is
    2."""
