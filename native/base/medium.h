// SPDX-License-Identifier: GPL-3.0-or-later
// What a participating medium is to the trackers: coefficients at a point, and a majorant along a ray.
#pragma once

#include "math/vec.h"

namespace nephele {

/// Coefficients at a point, per metre of world space.
struct Coefficients {
    Rgb sigma_s, sigma_t;
};

/// A piece of a ray, up to t_end, on which `density` (unitless, of a grid) never exceeds `majorant`.
struct MajorantPiece {
    float t_end = 0;
    float majorant = 0;
};

}  // namespace nephele
