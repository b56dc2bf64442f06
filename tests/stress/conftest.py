# SPDX-License-Identifier: GPL-3.0-or-later
"""The table at the end of a run: by group of cases, what came out worst."""

from collections import defaultdict


def pytest_terminal_summary(terminalreporter):
    groups = defaultdict(list)
    for report in terminalreporter.stats.get("passed", []) + terminalreporter.stats.get("failed", []):
        if report.when == "call" and "test_extreme[" in report.nodeid:
            name = report.nodeid.split("[", 1)[1].rstrip("]")
            groups[name.split("-")[0]].append((name, dict(report.user_properties), report.passed))
    if not groups:
        return
    write = terminalreporter.write_line
    terminalreporter.section("extreme cases")
    write("| cases | rows | renders | passed | worst t / allowed | worst deviation | most CPU s | CPU s |")
    write("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for group, rows in groups.items():
        figures = [
            max((row.get(name, 0.0) for _, row, _ in rows), default=0.0) for name in ("t", "deviation", "cpu")
        ]
        names = {name.rsplit("-", 1)[0] for name, _, _ in rows}
        write(
            f"| {group} | {len(names)} | {len(rows)} | {sum(good for _, _, good in rows)} "
            f"| {figures[0]:.2f} | {figures[1]:.2g} | {figures[2]:.1f} "
            f"| {sum(row.get('cpu', 0.0) for _, row, _ in rows):.0f} |"
        )
