// SPDX-License-Identifier: GPL-3.0-or-later
// The world as a light: directions drawn from a piecewise constant density over an equirectangular grid
// (Pharr et al., PBRT, "Infinite Area Lights"), mixed with a small share of uniform directions, so that what
// the grid missed is still found. A world of constant radiance is drawn uniformly. Density in solid angle
// throughout.
#pragma once

#include <functional>
#include <vector>

#include "base/light.h"
#include "lights/distribution.h"

namespace nephele {

class EnvironmentLight {
  public:
    /// Share of uniform directions.
    static constexpr float kUniformShare = 0.05f;

    /// radiance(unit direction) is asked once per cell of the grid; width, height >= 1. A grid as fine as the
    /// image behind the world finds all of it. Throws std::invalid_argument where a radiance is negative or
    /// not finite.
    EnvironmentLight(const std::function<Rgb(Vec3f)>& radiance, int width, int height);

    struct Sample {
        Vec3f wi;
        float pdf;
    };
    Sample sample(Vec2d u) const;
    float pdf(Vec3f wi) const;

    bool black() const { return is_zero(mean_radiance_); }
    bool constant() const { return rows_.empty(); }  ///< drawn uniformly
    Rgb mean_radiance() const { return mean_radiance_; }
    /// Fluence rate, W/m^2, the same everywhere.
    float importance() const { return 4 * kPi * mean(mean_radiance_); }

  private:
    void build(const std::vector<float>& weights);
    double cos_of_row(int row) const;

    int width_ = 0, height_ = 0;
    Rgb mean_radiance_;
    DiscreteDistribution marginal_;           // over rows, bottom row first
    std::vector<DiscreteDistribution> rows_;  // over the cells of a row; empty: uniform over the sphere
};

}  // namespace nephele
