#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Runs the native tests, then the Python tests, and says at the end how each went; fails if either failed.
# Arguments go to pytest: `test.sh -k homogeneous`.

source "$(dirname "$0")/common.sh"

summary=()
failed=0

# run_part NAME COMMAND...
run_part() {
    local name=$1 began=$SECONDS result=passed
    shift
    step "$name tests"
    "$@" || { result="FAILED (status $?)"; failed=1; }
    summary+=("$(printf '%-8s %s, %d s' "$name" "$result" $((SECONDS - began)))")
}

run_part native ctest --test-dir build/release --output-on-failure --no-tests=error --parallel "$(nproc)" --timeout 900
run_part Python .venv/bin/python -m pytest tests --durations=15 "$@"

step "Summary"
printf '    %s\n' "${summary[@]}"
exit "$failed"
