# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the tables of docs/stability.md from what the native tests of numerical stability measure.

    python tools/stability_page.py BINARY            (as `make stability` does)
    python tools/stability_page.py --check BINARY    fails where the page says something else

BINARY is build/release/tests/native/stability. The words of the tables are those of the tests; the figures
may differ by a factor of 2 from what is measured: compilers and processors round in their own ways. What
stands before the heading of the tables is written by hand.
"""

import argparse
import os
import re
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

PAGE = Path(__file__).resolve().parent.parent / "docs" / "stability.md"
FACTOR = 2  # between two machines' figures
MOST = 10  # differences to print
NOTHING = 1e-12  # errors below it count as none

TABLES = "## Formulas"
TABLE = "### "  # the heading of a room
HEADER = "| formula | file | what could go wrong | what is done | tried | worst error (bound) | relative to |"
RULE = "|---|---|---|---|---|---|---|"


@dataclass(frozen=True)
class Row:
    """One formula, as its test states and measures it."""

    room: str
    file: str
    formula: str
    risk: str
    form: str
    range: str
    unit: str
    bound: float
    worst: float

    def line(self):
        """Returns the row as a line of a table."""
        error = f"{number(self.worst)} ({number(self.bound)})"
        cells = (self.formula, f"`{self.file}`", self.risk, self.form, self.range, error, self.unit)
        return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def number(x):
    """Returns x with two digits at most, as 1.3e-7."""
    if x < NOTHING:
        return "0"
    return re.sub(r"e([+-])0*(\d)", lambda m: "e" + m[1].replace("+", "") + m[2], f"{x:.1e}").replace(
        ".0e", "e"
    )


def measure(binary):
    """Returns the rows that the tests measure; raises SystemExit where a test fails."""
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "rows.tsv"
        done = subprocess.run(
            [binary, "--gtest_brief=1"],
            env=os.environ | {"NEPHELE_STABILITY_ROWS": str(rows)},
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode != 0:
            raise SystemExit(f"{done.stdout}\n{binary} failed: the page would not be true")
        lines = rows.read_text().splitlines()
    cells = sorted((line.split("\t") for line in lines), key=lambda row: int(row[0]))
    return [Row(*words, float(bound), float(worst)) for _, *words, bound, worst in cells]


def page_of(introduction, rows):
    """Returns the page: the introduction, then a table for each room in the order of the tests."""
    parts = [introduction, f"{TABLES}\n"]
    for room in sorted({row.room for row in rows}):
        lines = [row.line() for row in rows if row.room == room]
        parts.append("\n".join([f"{TABLE}{room}", "", HEADER, RULE, *lines, ""]))
    return "\n".join(parts)


def split_error(line):
    """Returns a line of the page without its measured error, and that error or None."""
    found = re.search(r"\| (\S+) \(\S+\) \|", line)
    if not found:
        return line, None
    return line.replace(found[1], "", 1) if found[1] == "0" else line.replace(found[1] + " (", " ("), float(
        found[1]
    )


def differences(stated, measured):
    """Returns what two pages disagree about, as lines; figures may differ by FACTOR."""
    out = []
    old, new = stated.splitlines(), measured.splitlines()
    if len(old) != len(new):
        out.append(f"the page has {len(old)} lines, {len(new)} are measured")
    for a, b in zip(old, new, strict=False):
        (words_a, x), (words_b, y) = split_error(a), split_error(b)
        same = x == y or (x and y and max(x, y) <= FACTOR * min(x, y) * 1.05)  # both were rounded
        if words_a != words_b or not same:
            out.append(f"stated:   {a}\nmeasured: {b}")
    return out


def main():
    """Writes the page, or checks it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary", help="the native tests of stability")
    parser.add_argument("--check", action="store_true", help="compare instead of writing")
    arguments = parser.parse_args()
    stated = PAGE.read_text()
    introduction = stated[: stated.index(f"\n{TABLES}")].rstrip() + "\n"
    page = page_of(introduction, measure(arguments.binary))
    if not arguments.check:
        PAGE.write_text(page)
        return 0
    wrong = differences(stated, page)
    if wrong:
        print(
            "\n".join(wrong[:MOST]),
            f"\n{PAGE} is not what the tests measure: run `make stability`",
            file=sys.stderr,
        )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
