// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of the textures of textures.h and of tables.
#pragma once

#include "shading/program_bounds.h"
#include "shading/textures.h"

namespace nephele {

/// 1 where the checkerboard is odd over the box p, 0 where even.
Interval1 checker_bounds(const Interval3& p);
Interval1 gradient_bounds(Gradient kind, const Interval3& p);
/// Bounds of channel `channel` of a table of `channels` floats an entry at t.
Interval1 table_bounds(std::span<const float> table, std::size_t channels, std::size_t channel, Interval1 t);
/// Length of a vector.
Interval1 length(const Interval3& v);

}  // namespace nephele
