// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of what shading programs read from the shading point (shading_inputs.h), over a box.
#pragma once

#include "shading/program_bounds.h"

namespace nephele {

/// a from one space to another, as the mode of "convert_space" says.
Interval3 converted_bounds(std::int32_t mode, const Interval3& a, const BoundsInput& input);
/// Unit vectors, and those that programs make of vectors so short that their length is denormal.
inline constexpr Interval1 kDirection(-1.25, 1.25);

/// row . p + translation.
Interval1 row_bounds(Vec3f row, double translation, const Interval3& p);

Interval3 input_bounds(Op op, std::int32_t mode, const BoundsInput& input);

}  // namespace nephele
