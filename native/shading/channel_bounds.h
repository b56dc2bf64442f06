// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of the operations of shading programs that act on each channel by itself; program.cpp has the
// operations, under the same names.
#pragma once

#include "opcodes_table.h"
#include "shading/interval.h"

namespace nephele {

Interval1 divide(Interval1 a, Interval1 b);
/// x ^ b for x > 0 inside a, and x = 0 where a reaches it; infinite where that overflows.
Interval1 positive_power(Interval1 a, Interval1 b);
Interval1 arctan2(Interval1 y, Interval1 x);
Interval1 map_range(Interval1 a, Interval1 from_low, Interval1 from_high, Interval1 to_low, Interval1 to_high,
                    std::int32_t mode);
Interval1 channel_bounds(Op op, Interval1 a, Interval1 b, Interval1 c);

}  // namespace nephele
