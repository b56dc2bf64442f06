// SPDX-License-Identifier: GPL-3.0-or-later
// Uniform sampling of the solid angle of a triangle (Arvo, SIGGRAPH 1995, "Stratified Sampling of Spherical
// Triangles"), seen from the origin. In double precision, and only for triangles that fill enough of the
// view: for small ones uniform sampling of the area is as good, cheaper and more exact.
#pragma once

#include "math/vec.h"

namespace nephele {

class SphericalTriangle {
  public:
    /// Corners relative to the receiving point.
    SphericalTriangle(Vec3f a, Vec3f b, Vec3f c) : a_(a), b_(b), c_(c) {
        // Far triangles, by their bounding sphere, are not worth the trigonometry below.
        const Vec3f middle = (a + b + c) * (1.0f / 3);
        const float extent2 = std::max(dot(a - middle, a - middle),
                                       std::max(dot(b - middle, b - middle), dot(c - middle, c - middle)));
        if (!(dot(middle, middle) < 25 * extent2))
            return;
        prepare();
    }

    /// The caller has to sample the area where this is false.
    bool usable() const { return solid_angle_ > 0; }
    float solid_angle() const { return static_cast<float>(solid_angle_); }  ///< sr
    /// Weights of the corners of a point distributed uniformly in solid angle.
    Vec3f sample(Vec2f u) const;

  private:
    struct Vec3d {
        double x, y, z;
        Vec3d(double vx, double vy, double vz) : x(vx), y(vy), z(vz) {}
        explicit Vec3d(Vec3f v) : x(v.x), y(v.y), z(v.z) {}
        Vec3d operator+(Vec3d o) const { return {x + o.x, y + o.y, z + o.z}; }
        Vec3d operator-(Vec3d o) const { return {x - o.x, y - o.y, z - o.z}; }
        Vec3d operator*(double s) const { return {x * s, y * s, z * s}; }
    };
    static double dot_of(Vec3d a, Vec3d b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
    static Vec3d cross_of(Vec3d a, Vec3d b) {
        return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
    }
    static Vec3d unit(Vec3d a) { return a * (1 / std::sqrt(dot_of(a, a))); }
    /// Part of a at right angles to the unit vector b, unit length.
    static Vec3d orthogonal(Vec3d a, Vec3d b) { return unit(a - b * dot_of(a, b)); }

    void prepare();

    Vec3f a_, b_, c_;
    double solid_angle_ = 0, alpha_ = 0, cos_alpha_ = 0, sin_alpha_ = 0, cos_c_ = 0;
};

inline void SphericalTriangle::prepare() {
    const Vec3d a = unit(Vec3d(a_)), b = unit(Vec3d(b_)), c = unit(Vec3d(c_));
    // Solid angle by Van Oosterom and Strackee (1983), which does not cancel.
    const double volume = std::fabs(dot_of(a, cross_of(b, c)));
    const double omega = 2 * std::atan2(volume, 1 + dot_of(a, b) + dot_of(b, c) + dot_of(c, a));
    // Thin slivers and triangles seen edge-on have no well-defined angle at a.
    if (!(omega > 1e-4) || !(volume > 1e-6))
        return;
    const Vec3d ab = orthogonal(b, a), ac = orthogonal(c, a);
    cos_alpha_ = std::clamp(dot_of(ab, ac), -1.0, 1.0);
    const Vec3d turn = cross_of(ab, ac);
    sin_alpha_ = std::sqrt(dot_of(turn, turn));
    if (!(sin_alpha_ > 1e-6))
        return;
    alpha_ = std::atan2(sin_alpha_, cos_alpha_);
    cos_c_ = dot_of(a, b);
    solid_angle_ = omega;
}

inline Vec3f SphericalTriangle::sample(Vec2f u) const {
    const Vec3d a = unit(Vec3d(a_)), b = unit(Vec3d(b_)), c = unit(Vec3d(c_));
    // A sub-triangle a, b, c' of the share u.x of the solid angle: c' lies on the arc from a to c.
    const double part = static_cast<double>(u.x) * solid_angle_;
    const double s = std::sin(part - alpha_), t = std::cos(part - alpha_);
    const double v = t - cos_alpha_, w = s + sin_alpha_ * cos_c_;
    const double below = (w * s + v * t) * sin_alpha_;
    const double q = below != 0 ? std::clamp(((w * t - v * s) * cos_alpha_ - w) / below, -1.0, 1.0) : 1.0;
    const Vec3d c_part = a * q + orthogonal(c, a) * std::sqrt(1 - q * q);
    // A point on the arc from b to c', its cosine to b uniform.
    const double z = 1 - static_cast<double>(u.y) * (1 - dot_of(c_part, b));
    const Vec3d away = c_part - b * dot_of(c_part, b);
    const double away2 = dot_of(away, away);
    const Vec3d d = away2 > 0 ? b * z + away * (std::sqrt(std::max(0.0, 1 - z * z) / away2)) : b;

    // Barycentric weights of the ray along d: solve b0 a + b1 b + b2 c = k d.
    const Vec3d pa(a_), pb(b_), pc(c_);
    const double b0 = dot_of(d, cross_of(pb, pc)), b1 = dot_of(d, cross_of(pc, pa)),
                 b2 = dot_of(d, cross_of(pa, pb));
    const double sum = b0 + b1 + b2;
    const auto share = [sum](double x) { return static_cast<float>(std::clamp(x / sum, 0.0, 1.0)); };
    const float w0 = share(b0), w1 = share(b1);
    return {w0, w1, std::max(0.0f, 1 - w0 - w1)};
}

}  // namespace nephele
