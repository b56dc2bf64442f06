/* SPDX-License-Identifier: GPL-3.0-or-later
 * Tells callgrind what to count: bench/specialisation.py compiles this and calls it from Python. */
#include <valgrind/callgrind.h>

void start(void) {
    CALLGRIND_START_INSTRUMENTATION;
}

void stop(void) {
    CALLGRIND_STOP_INSTRUMENTATION;
}
