// SPDX-License-Identifier: GPL-3.0-or-later
// Affine transforms (3x4, row-major, column vectors), orthonormal frames and the robust ray offset.
#pragma once

#include <array>
#include <bit>

#include "math/vec.h"

namespace nephele {

/// Affine map p_to = A p_from + b. Built from double precision, stored as float.
struct Transform {
    std::array<Vec3f, 3> row{Vec3f(1, 0, 0), Vec3f(0, 1, 0), Vec3f(0, 0, 1)};
    Vec3f translation;

    Vec3f point(Vec3f p) const { return vector(p) + translation; }
    Vec3f vector(Vec3f v) const { return {dot(row[0], v), dot(row[1], v), dot(row[2], v)}; }
    /// A^T n: with the inverse transform this maps normals.
    Vec3f transposed_vector(Vec3f n) const { return row[0] * n.x + row[1] * n.y + row[2] * n.z; }
    Vec3f column(int i) const { return {row[0][i], row[1][i], row[2][i]}; }
    float determinant() const { return dot(row[0], cross(row[1], row[2])); }
};

/// First b, then a.
inline Transform operator*(const Transform& a, const Transform& b) {
    Transform out;
    for (std::size_t r = 0; r < 3; ++r)
        out.row[r] = b.transposed_vector(a.row[r]);
    out.translation = a.point(b.translation);
    return out;
}

/// Inverse of an affine map given as 16 row-major doubles; throws std::invalid_argument where it is singular.
Transform inverse_of(const double (&matrix)[16]);
Transform transform_of(const double (&matrix)[16]);
/// Inverse of a map that is not singular, in single precision.
Transform inverse_of(const Transform& transform);
/// a * b.
void multiply(const double (&a)[16], const double (&b)[16], double (&out)[16]);

/// Orthonormal basis around the unit vector z (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
struct Frame {
    Vec3f x, y, z;

    explicit Frame(Vec3f n) : z(n) {
        const float sign = std::copysign(1.0f, n.z);
        const float a = -1.0f / (sign + n.z);
        const float b = n.x * n.y * a;
        x = {1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x};
        y = {b, sign + n.y * n.y * a, -n.y};
    }
    /// x along t as far as n lets it; any x where t is along n.
    Frame(Vec3f n, Vec3f t) : Frame(n) {
        const Vec3f across = cross(n, t);
        const float sine2 = dot(across, across);
        if (!(sine2 > 1e-12f * dot(t, t)) || !std::isfinite(sine2))
            return;
        y = across / std::sqrt(sine2);
        x = cross(y, n);
    }
    Vec3f to_world(Vec3f v) const { return x * v.x + y * v.y + z * v.z; }
    Vec3f to_local(Vec3f v) const { return {dot(x, v), dot(y, v), dot(z, v)}; }
};

/// Moves p off its surface along n, by an amount that scales with p's rounding error
/// (Waechter and Binder, Ray Tracing Gems, chapter 6). reach: in proportion to what p was made of, whose
/// rounding it has; where that is small, so is the least step.
inline Vec3f offset_point(Vec3f p, Vec3f n, float reach = 1) {
    constexpr float kLargestOrigin = 1.0f / 32.0f, kFloatScale = 1.0f / 2048.0f, kIntScale = 256.0f;
    const float origin = std::min(reach, kLargestOrigin);
    Vec3f out;
    for (int i = 0; i < 3; ++i) {
        const auto step = static_cast<std::int32_t>(kIntScale * n[i]);
        const float moved =
            std::bit_cast<float>(std::bit_cast<std::int32_t>(p[i]) + (p[i] < 0 ? -step : step));
        out[i] = std::fabs(p[i]) < origin ? p[i] + kFloatScale * origin * n[i] : moved;
    }
    return out;
}

}  // namespace nephele
