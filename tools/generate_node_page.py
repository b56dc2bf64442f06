# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes docs/nodes.md from the table of addon/export/node_support.py.

python tools/generate_node_page.py
"""

import importlib.util
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def main():
    spec = importlib.util.spec_from_file_location(
        "node_support", ROOT / "addon" / "export" / "node_support.py"
    )
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look their module up
    spec.loader.exec_module(module)
    (ROOT / "docs" / "nodes.md").write_text(module.page(), encoding="utf-8")


if __name__ == "__main__":
    main()
