// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of Blender's fractal noise over a box.
//
// The noise is sampled on a lattice inside the box. Between samples it can rise above all of them by no more
// than trilinear interpolation errs: for a spacing s, s^2 / 8 times its largest second derivative, summed
// over the axes. Perlin's noise with the quintic fade has continuous second derivatives with known bounds,
// also across its cells. Octaves too fine for the lattice get their whole range.
#pragma once

#include "shading/noise.h"
#include "shading/program_bounds.h"

namespace nephele {

/// Bounds, in one to four dimensions, of Perlin's noise and of its first and second derivatives along
/// an axis (magnitudes).
inline constexpr double kPerlinRange[] = {0, 1.002, 1.002, 1.025, 1.5},
                        kPerlinSlope[] = {0, 2.85, 3.25, 4, 5.5},
                        kPerlinCurvature[] = {0, 15.8, 12.5, 12.8, 18};

/// Bounds of noise_value or noise_color at any point of p, w the fourth coordinate; settings' intervals:
/// detail, roughness and lacunarity.
Interval3 noise_bounds(const Interval3& p, Interval1 w, const Interval3& fractal, Interval1 distortion,
                       bool normalize, int dimensions, bool color);

}  // namespace nephele
