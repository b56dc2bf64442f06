// SPDX-License-Identifier: GPL-3.0-or-later
// A placement that changes while the shutter is open. Between the matrices that are given, translation,
// rotation and stretch are interpolated apart (polar decomposition and slerp: Shoemake and Duff 1992, "Matrix
// Animation and Polar Decomposition"); that curve is kept as so many matrices that linear interpolation
// between them is as good, since Embree's hierarchies, shading points and the camera must agree on one
// motion.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "compiled/motion.h"
#include "math/transform.h"

namespace nephele {

/// Most matrices or vertex positions of one motion: Embree takes no more.
inline constexpr std::size_t kMaxMotionSteps = 129;

/// The step before a time in [0, 1] of so many equally spaced ones, and the way from it to the next.
struct MotionPlace {
    std::size_t step;
    float fraction;

    MotionPlace(float time, std::size_t steps) {
        const float x = clamp01(time) * static_cast<float>(steps - 1);
        step = std::min(static_cast<std::size_t>(x), steps - 2);
        fraction = x - static_cast<float>(step);
    }
};

class Motion {
  public:
    /// Stands still.
    Motion() = default;
    /// Row-major matrices at equally spaced times, at least two. Throws std::invalid_argument where one is
    /// singular or there are too many.
    explicit Motion(std::span<const std::array<double, 16>> matrices);

    bool moves() const { return compiled::motion && !steps_.empty(); }
    /// The placement at equally spaced times.
    const std::vector<Transform>& steps() const { return steps_; }
    /// The placement at a time in [0, 1] of the shutter; only where it moves.
    Transform at(float time) const;

  private:
    std::vector<Transform> steps_;
};

}  // namespace nephele
