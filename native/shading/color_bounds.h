// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of the colour arithmetic of color_math.h. HSV's and HSL's channels count as independent of each
// other.
#pragma once

#include "opcodes_table.h"
#include "shading/program_bounds.h"

namespace nephele {

/// b blended over a by t.
Interval3 blend_bounds(BlendMode mode, const Interval3& a, const Interval3& b, Interval1 t);
/// The operations from rgb_to_hsv to blackbody of opcodes.py.
Interval3 color_bounds(Op op, const Interval3& a, const Interval3& b, const Interval3& c);

}  // namespace nephele
