#!/usr/bin/env bash
# SPDX-License-Identifier: GPL-3.0-or-later
#
# Runs those native tests under ThreadSanitizer that use several threads (`build.sh tsan` builds them): renders with
# others looking on, learning, updates of the field, the grid cache, the film. `tsan.sh REGEX` runs others.

source "$(dirname "$0")/common.sh"

threaded='^threads\.|^field\.|GridCache|^core\.Film|VdbFile\..*Thread'

export TSAN_OPTIONS="suppressions=$root/scripts/tsan_suppressions.txt halt_on_error=0 second_deadlock_stack=1"

step "Native tests under ThreadSanitizer"
ctest --test-dir build/tsan --output-on-failure --no-tests=error --tests-regex "${1:-$threaded}" --timeout 1800
