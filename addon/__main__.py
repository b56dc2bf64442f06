# SPDX-License-Identifier: GPL-3.0-or-later
"""`python -m nephele`: the command line."""

from .cli import entry

if __name__ == "__main__":
    entry()
