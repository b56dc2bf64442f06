// SPDX-License-Identifier: GPL-3.0-or-later
// Uniform sampling of the solid angle of a rectangle (Urena, Fajardo, King, EGSR 2013, "An Area-Preserving
// Parametrization for Spherical Rectangles"), in double precision, since the four dihedral angles nearly
// cancel for small rectangles.
#pragma once

#include "math/vec.h"

namespace nephele {

/// The rectangle [x0, x1] x [y0, y1] of the plane z = -height as seen from the origin; height > 0.
class SphericalRectangle {
  public:
    SphericalRectangle(double x0, double x1, double y0, double y1, double height);

    /// sr; 0 where it is too small for this method, and the caller has to sample the area.
    double solid_angle() const { return solid_angle_; }
    /// Point (x, y) of the rectangle, distributed uniformly in solid angle.
    Vec2f sample(Vec2f u) const;

  private:
    double x0_, x1_, y0_, y1_, z0_, b0_, b1_, g23_, solid_angle_;
};

inline SphericalRectangle::SphericalRectangle(double x0, double x1, double y0, double y1, double height)
    : x0_(x0), x1_(x1), y0_(y0), y1_(y1), z0_(-height) {
    // z components of the unit normals of the planes through the origin and the four edges.
    const auto normal_z = [this](double edge) { return edge / std::sqrt(z0_ * z0_ + edge * edge); };
    const double n0 = -normal_z(y0), n2 = normal_z(y1);
    // The paper's internal angles are pi/2 + asin(n n'), so that their sum less 2 pi is the sum of the asin.
    // Written as arc tangents of the edges they keep their digits for points in the rectangle's plane.
    const auto angle = [&](double a, double b) {
        return std::atan2(a * b, height * std::sqrt(height * height + a * a + b * b));
    };
    const double g0 = -angle(y0, x1), g1 = angle(x1, y1), g2 = -angle(y1, x0), g3 = angle(x0, y0);
    solid_angle_ = g0 + g1 + g2 + g3;
    b0_ = n0;
    b1_ = n2;
    g23_ = g2 + g3;
    if (!(solid_angle_ > 1e-6))
        solid_angle_ = 0;
}

inline Vec2f SphericalRectangle::sample(Vec2f u) const {
    // Abscissa: the cut x = xu leaves the share u.x of the solid angle on its side.
    const double au = double{u.x} * solid_angle_ - g23_;
    const double s = std::sin(au);
    const double fu = (std::cos(au) * b0_ + b1_) / s;
    const double cu = std::clamp((fu > 0 ? 1.0 : -1.0) / std::sqrt(fu * fu + b0_ * b0_), -1.0, 1.0);
    double xu = -(cu * z0_) / std::sqrt(std::max(1 - cu * cu, 1e-300));
    xu = std::clamp(xu, x0_, x1_);
    // Ordinate: sines along the cut are uniform.
    const double d2 = xu * xu + z0_ * z0_;
    const double h0 = y0_ / std::sqrt(d2 + y0_ * y0_), h1 = y1_ / std::sqrt(d2 + y1_ * y1_);
    const double hv = h0 + double{u.y} * (h1 - h0);
    const double rest = 1 - hv * hv;
    const double yv = rest > 1e-15 ? hv * std::sqrt(d2 / rest) : (hv > 0 ? y1_ : y0_);
    return {static_cast<float>(xu), static_cast<float>(std::clamp(yv, y0_, y1_))};
}

}  // namespace nephele
