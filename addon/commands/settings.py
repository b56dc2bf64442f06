# SPDX-License-Identifier: GPL-3.0-or-later
"""`nephele settings`: the parameter table, and the presets."""

import json

from .. import parameters, preset_files


def add_parser(subparsers):
    """Adds the command's arguments."""
    parser = subparsers.add_parser("settings", help="list the render settings", allow_abbrev=False)
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--presets", action="store_true", help="the presets alone")
    parser.set_defaults(run=run)


def run(arguments):
    """Prints every setting with its default, range and meaning, and the presets. Returns the exit code."""
    rows = [preset_row(name) for name in preset_files.NAMES]
    if not arguments.presets:
        rows = [row(parameter) for parameter in parameters.PARAMETERS]
    if arguments.json:
        print(json.dumps(rows, indent=2))
        return 0
    if not arguments.presets:
        print_settings(rows)
        print()
    print_presets()
    return 0


def print_settings(rows):
    """Prints row()s of parameters."""
    width = max(len(entry["name"]) for entry in rows)
    for entry in rows:
        default = str(entry["default"]).lower() if entry["kind"] == "bool" else entry["default"]
        unit = f" {entry['unit']}" if entry["unit"] else ""
        print(f"{entry['name']:<{width}}  {default}{unit}  [{allowed(entry)}]  {entry['doc']}")
        for item in entry.get("items", ()):
            print(f"{'':<{width}}    {item['name']}: {item['doc']}")


def print_presets():
    """Prints what the presets are for, and where they differ from the defaults."""
    print("Presets, for `nephele render --preset NAME`; what they do not name has its default:")
    for name in preset_files.NAMES:
        entry = preset_row(name)
        print(f"{entry['name']:<9}  {entry['doc']}")
        print(" " * 11 + ", ".join(f"{key}={value}".lower() for key, value in entry["settings"].items()))


def preset_row(name):
    """Returns what the JSON says of a bundled preset."""
    path = preset_files.find(name)
    return {"name": name.lower(), "doc": preset_files.about(path), "settings": preset_files.stated(path)}


def row(parameter):
    """Returns what the JSON says of a parameters.Parameter."""
    entry = {
        "name": parameter.name,
        "kind": parameter.kind,
        "default": parameter.default,
        "unit": parameter.unit,
        "label": parameter.label,
        "doc": parameter.doc,
        "group": parameter.group,
    }
    if parameter.kind in ("int", "float"):
        entry |= {"minimum": parameter.minimum, "maximum": parameter.maximum}
    if parameter.kind == "enum":
        entry["items"] = [{"name": name, "label": label, "doc": doc} for name, label, doc in parameter.items]
    return entry


def allowed(entry):
    """Returns the values that a row() admits, as text."""
    if entry["kind"] == "bool":
        return "true or false"
    if entry["kind"] == "enum":
        return " | ".join(item["name"] for item in entry["items"])
    form = "d" if entry["kind"] == "int" else "g"
    return f"{entry['minimum']:{form}} to {entry['maximum']:{form}}"
