// SPDX-License-Identifier: GPL-3.0-or-later
// Maps from the unit square to the distributions that light transport needs, with their densities.
#pragma once

#include "math/vec.h"

namespace nephele {

/// Uniform disc of radius 1 (concentric map of Shirley and Chiu, 1997), in polar coordinates; r in [-1, 1].
struct DiscPoint {
    float r = 0, phi = 0;

    explicit DiscPoint(Vec2f u) {
        const float a = 2 * u.x - 1, b = 2 * u.y - 1;
        if (a == 0 && b == 0)
            return;
        const bool wide = std::fabs(a) > std::fabs(b);
        r = wide ? a : b;
        phi = wide ? kPi / 4 * (b / a) : kPi / 2 - kPi / 4 * (a / b);
    }
};
inline Vec2f sample_disc(Vec2f u) {
    const DiscPoint p(u);
    return {p.r * std::cos(p.phi), p.r * std::sin(p.phi)};
}

/// Cosine-weighted hemisphere around +z; density cos/pi. The cosine comes from the radius itself: by x and y
/// it would have no digits at the horizon.
inline Vec3f sample_cosine_hemisphere(Vec2f u) {
    const DiscPoint p(u);
    return {p.r * std::cos(p.phi), p.r * std::sin(p.phi), std::sqrt((1 - p.r) * (1 + p.r))};
}

/// Unit vector with cosine `c` to +z and azimuth 2 pi u.
inline Vec3f spherical(float c, float u) {
    const float s = std::sqrt(std::max(0.0f, (1 - c) * (1 + c))), phi = 2 * kPi * u;
    return {s * std::cos(phi), s * std::sin(phi), c};
}

/// Uniform sphere; density 1 / (4 pi).
inline Vec3f sample_sphere(Vec2f u) {
    return spherical(1 - 2 * u.x, u.y);
}

/// Uniform cone around +z; one_minus_cos = 1 - cos(half angle), kept apart so that tiny cones stay exact.
inline Vec3f sample_cone(Vec2f u, float one_minus_cos) {
    const float t = u.x * one_minus_cos;  // 1 - cos(theta)
    const float s = std::sqrt(std::max(0.0f, t * (2 - t))), phi = 2 * kPi * u.y;
    return {s * std::cos(phi), s * std::sin(phi), 1 - t};
}
inline float cone_pdf(float one_minus_cos) {
    return 1 / (2 * kPi * one_minus_cos);
}

/// Power heuristic (Veach and Guibas 1995), beta = 2, written so that huge densities do not overflow.
inline float power_heuristic(float pdf, float other) {
    if (pdf == 0)
        return 0;
    const float r = other / pdf;
    return 1 / (1 + r * r);
}

/// Equirectangular map as Blender's Environment Texture has it: u, v in [0,1]; v = 1 is up (+z). Not by an
/// arc cosine, which loses half of the digits at the poles.
inline Vec2f equirectangular_from_direction(Vec3f d) {
    const float theta = std::atan2(std::hypot(d.x, d.y), d.z);
    return {-std::atan2(d.y, d.x) / (2 * kPi) + 0.5f, 1 - theta / kPi};
}
inline Vec3f direction_from_equirectangular(Vec2f uv) {
    const float phi = -2 * kPi * (uv.x - 0.5f), theta = kPi * (1 - uv.y), s = std::sin(theta);
    return {s * std::cos(phi), s * std::sin(phi), std::cos(theta)};
}

}  // namespace nephele
