#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Runs what `build.sh asan` built: the native tests, then a handful of Python tests that render, with the module.
# Any finding of a sanitizer ends the process that made it, and fails the test.

source "$(dirname "$0")/common.sh"

export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1:check_initialization_order=1
export UBSAN_OPTIONS=print_stacktrace=1
failed=0

step "Native tests under the sanitizers"
ctest --test-dir build/asan --output-on-failure --no-tests=error --parallel "$(nproc)" --timeout 1800 || failed=1

# Python and Blender are not built with the sanitizers, so that the runtime is preloaded, and with it the C++ runtime
# whose exceptions it watches. Leaks are not looked for: Python and Blender keep memory to their end.
step "Python tests under the sanitizers"
preload=
for library in libasan.so libubsan.so libstdc++.so; do
    preload+="$(g++ -print-file-name=$library):"
done
ASAN_OPTIONS=$ASAN_OPTIONS:detect_leaks=0 PYTHONPATH=build/asan/native LD_PRELOAD=${preload%:} \
    .venv/bin/python -m pytest tests/render/test_bad_descriptions.py tests/addon/test_fuzz_corpus.py \
    tests/render/test_determinism.py tests/render/test_f12.py \
    -k "bad_descriptions or corpus or same_seed or checkpoint_continues or only_passes or border or vdb_stops" || failed=1
exit "$failed"
