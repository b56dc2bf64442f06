// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of the procedural textures over a box: those of procedural.h, operand by operand.
#pragma once

#include "shading/procedural.h"
#include "shading/program_bounds.h"

namespace nephele {

Interval3 noise_operation_bounds(std::int32_t mode, const Interval3& a, const Interval3& b,
                                 const Interval3& c, const Interval3& d);
Interval3 voronoi_operation_bounds(std::int32_t mode, const Interval3& a, const Interval3& b,
                                   const Interval3& c, const Interval3& d);
Interval3 gabor_operation_bounds(std::int32_t mode, const Interval3& b, const Interval3& c);
Interval3 brick_operation_bounds(const Interval3& a, const Interval3& b, const Interval3& c);

}  // namespace nephele
