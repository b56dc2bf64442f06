#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Checks format (clang-format, ruff), style (ruff) and, with clang-tidy, the C++ files given as arguments or else
# those that differ from HEAD. All checks run; the script fails if one of them did.

source "$(dirname "$0")/common.sh"

failed=0

# check NAME COMMAND...
check() {
    step "$1"
    "${@:2}" || failed=1
}

# Prints the .cpp files of native/, tests/native/ and tests/fuzz/ that are new or differ from the last commit.
changed_sources() {
    {
        git diff --name-only --diff-filter=d HEAD -- native tests/native tests/fuzz &&
            git ls-files --others --exclude-standard -- native tests/native tests/fuzz
    } | { grep '\.cpp$' || true; } | sort -u
}

mapfile -t cpp_files < <(find native tests/native tests/fuzz -name '*.cpp' -o -name '*.h' | sort)
check "clang-format" clang-format --dry-run -Werror "${cpp_files[@]}"
check "ruff check" .venv/bin/ruff check .
check "ruff format" .venv/bin/ruff format --check .

tidy_files=("$@")
if (($# == 0)); then
    changed=$(changed_sources) || fail "git could not tell what differs from HEAD: name the files with FILES=\"...\""
    mapfile -t tidy_files < <(printf '%s' "$changed")
fi
if ((${#tidy_files[@]} == 0)); then
    step "clang-tidy: no C++ file differs from HEAD (FILES=\"...\" names files to check)"
else
    scripts/build.sh tables
    # One process per file; a file takes seconds, most of them OpenVDB's headers.
    check "clang-tidy on ${#tidy_files[@]} files" \
        xargs --max-args=1 --max-procs="$(nproc)" clang-tidy -p build/release --quiet < <(printf '%s\n' "${tidy_files[@]}")
fi
exit "$failed"
