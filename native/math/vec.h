// SPDX-License-Identifier: GPL-3.0-or-later
// Vectors of floats: Vec2f, Vec3f and Rgb. Directions, points and colours share one type; names tell them
// apart.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace nephele {

inline constexpr float kPi = 3.14159265358979323846f;
inline constexpr float kInvPi = 1.0f / kPi;
inline constexpr float kInv4Pi = 0.25f / kPi;
inline constexpr float kInfinity = __builtin_huge_valf();
inline constexpr float kOneMinusEpsilon = 0x1.fffffep-1f;

struct Vec2f {
    float x = 0, y = 0;
};

/// For what single precision is too coarse for.
struct Vec2d {
    double x = 0, y = 0;

    constexpr Vec2d() = default;
    constexpr Vec2d(double vx, double vy) : x(vx), y(vy) {}
    constexpr Vec2d(Vec2f v) : x(v.x), y(v.y) {}
};

struct Vec3f {
    float x = 0, y = 0, z = 0;

    constexpr Vec3f() = default;
    constexpr explicit Vec3f(float v) : x(v), y(v), z(v) {}
    constexpr Vec3f(float vx, float vy, float vz) : x(vx), y(vy), z(vz) {}

    constexpr float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    constexpr float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }

    constexpr Vec3f operator-() const { return {-x, -y, -z}; }
    constexpr Vec3f& operator+=(Vec3f b) { return *this = {x + b.x, y + b.y, z + b.z}; }
    constexpr Vec3f& operator-=(Vec3f b) { return *this = {x - b.x, y - b.y, z - b.z}; }
    constexpr Vec3f& operator*=(Vec3f b) { return *this = {x * b.x, y * b.y, z * b.z}; }
    constexpr Vec3f& operator*=(float s) { return *this = {x * s, y * s, z * s}; }
    constexpr Vec3f& operator/=(float s) { return *this *= 1.0f / s; }
    constexpr bool operator==(const Vec3f&) const = default;
};

using Rgb = Vec3f;

constexpr Vec3f operator+(Vec3f a, Vec3f b) {
    return a += b;
}
constexpr Vec3f operator-(Vec3f a, Vec3f b) {
    return a -= b;
}
constexpr Vec3f operator*(Vec3f a, Vec3f b) {
    return a *= b;
}
constexpr Vec3f operator*(Vec3f a, float s) {
    return a *= s;
}
constexpr Vec3f operator*(float s, Vec3f a) {
    return a *= s;
}
constexpr Vec3f operator/(Vec3f a, Vec3f b) {
    return {a.x / b.x, a.y / b.y, a.z / b.z};
}
constexpr Vec3f operator/(Vec3f a, float s) {
    return {a.x / s, a.y / s, a.z / s};
}

constexpr float dot(Vec3f a, Vec3f b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
constexpr Vec3f cross(Vec3f a, Vec3f b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// |a|, also where its square is no float: then of the vector over its largest component.
inline float length(Vec3f a) {
    const float square = dot(a, a);
    if (square > 1e-30f && square < 1e30f) [[likely]]
        return std::sqrt(square);
    const float largest = std::max(std::fabs(a.x), std::max(std::fabs(a.y), std::fabs(a.z)));
    if (!(largest > 0 && largest < kInfinity))
        return std::sqrt(square);  // of 0, infinity or NaN
    const Vec3f b = Vec3f(a.x / largest, a.y / largest, a.z / largest);
    return largest * std::sqrt(dot(b, b));
}
inline Vec3f normalize(Vec3f a) {
    return a / length(a);
}
/// a / |a|, or 0 where a is 0.
inline Vec3f safe_normalize(Vec3f a) {
    const float l = length(a);
    return l > 0 ? a / l : Vec3f(0);
}

constexpr Vec3f min(Vec3f a, Vec3f b) {
    return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)};
}
constexpr Vec3f max(Vec3f a, Vec3f b) {
    return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)};
}
constexpr float max_component(Vec3f a) {
    return std::max(a.x, std::max(a.y, a.z));
}
constexpr float min_component(Vec3f a) {
    return std::min(a.x, std::min(a.y, a.z));
}
constexpr float mean(Vec3f a) {
    return (a.x + a.y + a.z) * (1.0f / 3.0f);
}
constexpr bool is_zero(Vec3f a) {
    return a.x == 0 && a.y == 0 && a.z == 0;
}
inline bool is_finite(Vec3f a) {
    return std::isfinite(a.x) && std::isfinite(a.y) && std::isfinite(a.z);
}
inline Vec3f exp(Vec3f a) {
    return {std::exp(a.x), std::exp(a.y), std::exp(a.z)};
}
constexpr Vec3f lerp(Vec3f a, Vec3f b, float t) {
    return a + (b - a) * t;
}
constexpr float lerp(float a, float b, float t) {
    return a + (b - a) * t;
}
constexpr float clamp01(float x) {
    return x < 0 ? 0 : x > 1 ? 1 : x;
}
constexpr float sqr(float x) {
    return x * x;
}

/// Rec. 709 luminance.
constexpr float luminance(Rgb c) {
    return 0.2126729f * c.x + 0.7151522f * c.y + 0.0721750f * c.z;
}

/// A ray segment: points o + t d for t in [t_min, t_max]; d has unit length wherever distances matter.
struct Ray {
    Vec3f o, d;
    float t_min = 0;
    float t_max = kInfinity;
    float time = 0;  ///< of the shutter, in [0, 1]

    Vec3f at(float t) const { return o + d * t; }
    /// What of its line lies between two distances.
    Ray part(float from, float to) const { return {o, d, from, to, time}; }
};

}  // namespace nephele
