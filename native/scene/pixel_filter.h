// SPDX-License-Identifier: GPL-3.0-or-later
// The film's reconstruction filter, sampled: each camera ray takes its offset from the pixel's centre with a
// density proportional to the filter, so that every sample has weight 1 (Ernst, Stamminger, Greiner 2006,
// "Filter Importance Sampling"). Shapes and widths as in Cycles: box is one pixel wide whatever the width;
// the Gaussian exp(-8 (x/w)^2) is cut at 1.5 w; the Blackman-Harris window reaches w to each side.
#pragma once

#include <vector>

#include "math/vec.h"

namespace nephele {

class PixelFilter {
  public:
    enum class Kind { box, gaussian, blackman_harris };

    /// width in pixels, > 0. Throws std::invalid_argument otherwise.
    PixelFilter(Kind kind, float width);
    PixelFilter() : PixelFilter(Kind::blackman_harris, 1.5f) {}

    /// Offset from the centre of the pixel, in pixels.
    Vec2f sample(Vec2f u) const { return {offset(u.x), offset(u.y)}; }
    /// Normalised filter along one axis, 1/pixel.
    float density(float x) const;
    /// Largest offset, pixels.
    float reach() const { return reach_; }

  private:
    float offset(float u) const;
    double value(double x) const;

    static constexpr int kCells = 512;  // of the tabulated half, in which the density is linear

    Kind kind_;
    float width_, reach_;
    double scale_ = 1;  // from value to density
    std::vector<float>
        values_;  // at the edges of the cells, from the centre outwards; scaled so that the half's
    std::vector<float> integrals_;  // integral, over cells of width 1, is 1
};

}  // namespace nephele
