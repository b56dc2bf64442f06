#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Rewrites all sources in the project's format and applies ruff's safe corrections; `make lint` tells what is left.

source "$(dirname "$0")/common.sh"

step "clang-format"
find native tests/native \( -name '*.cpp' -o -name '*.h' \) -exec clang-format -i {} +
step "ruff"
.venv/bin/ruff check --fix-only .
.venv/bin/ruff format .
