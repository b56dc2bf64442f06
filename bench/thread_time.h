// SPDX-License-Identifier: GPL-3.0-or-later
// The clock of the native benchmarks.
#pragma once

#include <ctime>

namespace nephele::bench {

/// Processor time of this thread, s: other programs disturb it least.
inline double thread_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

}  // namespace nephele::bench
