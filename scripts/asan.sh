#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Runs the native tests built by `build.sh asan`; any finding of a sanitizer fails the test that made it.

source "$(dirname "$0")/common.sh"

export ASAN_OPTIONS=strict_string_checks=1:detect_stack_use_after_return=1:check_initialization_order=1
export UBSAN_OPTIONS=print_stacktrace=1

step "Native tests under the sanitizers"
ctest --test-dir build/asan --output-on-failure --no-tests=error --parallel "$(nproc)" --timeout 1800
