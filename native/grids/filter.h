// SPDX-License-Identifier: GPL-3.0-or-later
// How a value between voxels follows from the voxels around it.
//
//     nearest     the voxel whose centre is nearest
//     trilinear   the 2^3 voxels around the point, linear along each axis
//     tricubic    the 4^3 voxels around the point, weighted by the uniform cubic B-spline along each axis:
//                 smooth to its second derivative, and no weight is negative, so that it stays within the
//                 voxels' range and one voxel can be picked in proportion to the weights
//
// All are separable. Below, f in [0, 1] is the point's distance from the voxel floor(p) along one axis; the
// cubic's four voxels are floor(p) - 1 .. floor(p) + 2.
#pragma once

#include <cstdint>

namespace nephele {

enum class Filter : std::uint8_t { nearest, trilinear, tricubic };

/// The cubic B-spline's value as three linear interpolations,
/// lerp(lerp(v0, v1, low), lerp(v2, v3, high), upper): exact where all voxels are equal.
struct CubicSpans {
    float low, high, upper;
};
constexpr CubicSpans cubic_spans(float f) {
    const float g = 1 - f;
    const float w0 = g * g * g * (1.0f / 6), w3 = f * f * f * (1.0f / 6);
    const float w1 = 2.0f / 3 - f * f * (1 - 0.5f * f), w2 = 2.0f / 3 - g * g * (1 - 0.5f * g);
    return {w1 / (w0 + w1), w3 / (w2 + w3), w2 + w3};
}

/// Offset from floor(p), -1 .. 2, of the voxel that u in [0, 1) picks in proportion to the cubic's weights.
constexpr int pick_cubic_offset(float f, float u) {
    const float g = 1 - f;
    const float w0 = g * g * g * (1.0f / 6), w3 = f * f * f * (1.0f / 6);
    const float w1 = 2.0f / 3 - f * f * (1 - 0.5f * f);
    return (u >= w0) + (u >= w0 + w1) + (u >= 1 - w3) - 1;
}

/// Voxels that a point p may see: from floor(p) - `below` to floor(p) + `above` along each axis. Where p is
/// an integer the topmost has no weight, so an interval [a, b] of integers sees a - below .. b + above - 1.
struct Reach {
    int below, above;
};
constexpr Reach reach_of(Filter filter) {
    return filter == Filter::tricubic ? Reach{1, 2} : Reach{0, 1};
}

}  // namespace nephele
