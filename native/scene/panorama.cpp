// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/panorama.h"

#include <algorithm>
#include <cmath>

namespace nephele {

namespace {

Vec3f vector(double x, double y, double z) {
    return normalize(Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)));
}

/// At the angle theta off the axis, on the side of the picture where (x, y) is from its middle.
Vec3f off_axis(double x, double y, double theta) {
    const double r = std::hypot(x, y), scale = r > 0 ? std::sin(theta) / r : 0;
    return vector(x * scale, y * scale, -std::cos(theta));
}

double mix(double a, double b, double t) {
    return a + (b - a) * t;
}

}  // namespace

bool Panorama::finite() const {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

std::optional<Vec3f> Panorama::direction(double x, double y) const {
    const auto& v = values;
    const double cx = x - 0.5, cy = y - 0.5;  // from the middle
    switch (lens) {
        case Lens::equirectangular: {
            const double longitude = mix(v[0], v[1], x), latitude = mix(v[2], v[3], y);
            return vector(std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                          -std::cos(latitude) * std::cos(longitude));
        }
        case Lens::fisheye_equidistant: {
            const double r = 2 * std::hypot(cx, cy);
            if (r > 1)
                return std::nullopt;
            return off_axis(cx, cy, 0.5 * r * v[0]);
        }
        case Lens::fisheye_equisolid: {
            const double sx = cx * v[2], sy = cy * v[3], r = std::hypot(sx, sy);
            if (r > 2 * v[1] * std::sin(0.25 * v[0]))
                return std::nullopt;
            return off_axis(sx, sy, 2 * std::asin(std::min(1.0, r / (2 * v[1]))));
        }
        case Lens::fisheye_polynomial: {
            const double sx = cx * v[1], sy = cy * v[2], r = std::hypot(sx, sy);
            const double theta = -(v[3] + r * (v[4] + r * (v[5] + r * (v[6] + r * v[7]))));
            if (std::fabs(theta) > 0.5 * v[0])
                return std::nullopt;
            return off_axis(sx, sy, theta);
        }
        case Lens::mirror_ball: {
            const double bx = 2 * cx, by = 2 * cy, square = 1 - bx * bx - by * by;
            if (square < 0)
                return std::nullopt;
            const double s = std::sqrt(square);
            return vector(2 * s * bx, 2 * s * by, 1 - 2 * square);
        }
        case Lens::equiangular_cubemap: {
            constexpr double kRightAngle = 0.5 * double{kPi};
            return vector(std::tan(kRightAngle * cx), std::tan(kRightAngle * cy), -1);
        }
        case Lens::central_cylindrical: {
            const double angle = mix(v[0], v[1], x);
            return vector(std::sin(angle), mix(v[2], v[3], y) / v[4], -std::cos(angle));
        }
    }
    return std::nullopt;
}

}  // namespace nephele
