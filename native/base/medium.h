// SPDX-License-Identifier: GPL-3.0-or-later
// What a participating medium is to the trackers: bounds along a ray.
#pragma once

#include "math/vec.h"

namespace nephele {

/// A piece of a ray, up to t_end, on which a field (unitless, of a grid) never exceeds `majorant`.
struct MajorantPiece {
    float t_end = 0;
    float majorant = 0;
};

}  // namespace nephele
