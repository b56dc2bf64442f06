// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of Blender's fractal noise over a box.
//
// An octave that the box resolves is enclosed by the mean value theorem: its value at the centre, and the
// range of its gradient over the box times the box's half size; gradients of several octaves are added before
// that, since the point is the same in all. The gradient's range comes from the hashed gradients of the
// lattice cells that the box meets. Coarser boxes are cut into smaller ones; octaves finer than a box get
// their whole range.
#pragma once

#include "shading/noise.h"
#include "shading/program_bounds.h"

namespace nephele {

/// Bounds of |perlin| in one, two and three dimensions. In three it exceeds 1 a little.
inline constexpr double kPerlinRange[] = {0, 1.002, 1.002, 1.02};

/// Bounds of noise_value or noise_color at any point of p; settings' intervals: detail, roughness and
/// lacunarity.
Interval3 noise_bounds(const Interval3& p, const Interval3& fractal, Interval1 distortion, bool normalize,
                       int dimensions, bool color);

}  // namespace nephele
