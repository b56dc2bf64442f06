// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps for tests, and Monte Carlo estimates of the irradiance that they give.
#pragma once

#include <cmath>
#include <functional>
#include <string>

#include "lights/any.h"
#include "math/sampler.h"

namespace nephele::test {

using Kind = LampDescription::Kind;

inline LampDescription lamp_of(Kind kind, float power = 1000) {
    LampDescription d;
    d.name = "lamp";
    d.kind = kind;
    d.power = Rgb(power);
    return d;
}

/// Places a lamp: rotation x, then y, then z (radians, Blender's XYZ Euler order), then location.
inline void place(LampDescription& d, Vec3f location, Vec3f euler = {}, Vec3f scale = Vec3f(1)) {
    const double cx = std::cos(double{euler.x}), sx = std::sin(double{euler.x}),
                 cy = std::cos(double{euler.y}), sy = std::sin(double{euler.y}),
                 cz = std::cos(double{euler.z}), sz = std::sin(double{euler.z});
    const double r[3][3] = {{cy * cz, sx * sy * cz - cx * sz, cx * sy * cz + sx * sz},
                            {cy * sz, sx * sy * sz + cx * cz, cx * sy * sz - sx * cz},
                            {-sy, sx * cy, cx * cy}};
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j)
            d.world_from_light[4 * i + j] = r[i][j] * double{scale[j]};
        d.world_from_light[4 * i + 3] = double{location[i]};
    }
}

/// What makes one lamp differ from another of its kind; all of them are at (0, 0, 2) and shine down.
using LampSetter = std::function<void(LampDescription&)>;

inline constexpr float kDegree = kPi / 180;
inline LampSetter ball(float radius, bool soft = false, bool normalize = true) {
    return [=](LampDescription& d) {
        d.radius = radius;
        d.soft_falloff = soft;
        d.normalize = normalize;
    };
}
inline LampSetter sun(float degrees, bool normalize = true, float tilt = 0) {
    return [=](LampDescription& d) {
        d.angle = degrees * kDegree;
        d.normalize = normalize;
        place(d, {0, 0, 2}, {tilt, 0, 0});
    };
}
inline LampSetter area(float x, float y, bool ellipse = false, float spread = 180, bool normalize = true,
                       Vec3f scale = Vec3f(1)) {
    return [=](LampDescription& d) {
        d.size_x = x;
        d.size_y = y;
        d.ellipse = ellipse;
        d.spread = spread * kDegree;
        d.normalize = normalize;
        place(d, {0, 0, 2}, {}, scale);
    };
}
inline LampSetter spot(float radius, float blend = 0.5f, float degrees = 60, bool soft = false,
                       Vec3f scale = Vec3f(1)) {
    return [=](LampDescription& d) {
        d.radius = radius;
        d.spot_size = degrees * kDegree;
        d.spot_blend = blend;
        d.soft_falloff = soft;
        place(d, {0, 0, 2}, {}, scale);
    };
}
inline LampSetter tilted_area() {
    return [](LampDescription& d) {
        d.size_y = 2;
        place(d, {0, 0, 1.1f}, {0.7f, 0.3f, 0.2f});
    };
}

/// A lamp at (0, 0, 2), shining down.
inline Lamp hanging(Kind kind, const LampSetter& set) {
    LampDescription d = lamp_of(kind);
    place(d, {0, 0, 2});
    set(d);
    return prepare_lamp(d);
}

struct Estimate {
    double mean = 0, error = 0;  ///< error: standard error of the mean
};

/// Irradiance (W/m^2, channel 0) at p of a surface with unit normal n, by n light samples; is_finite is
/// checked by NaNs that spread into the mean. n = 0: the fluence rate.
template <typename Light>
Estimate irradiance(const Light& light, Vec3f p, Vec3f normal, int samples, std::uint64_t seed) {
    Rng rng(seed);
    double sum = 0, sum2 = 0;
    for (int i = 0; i < samples; ++i) {
        const auto s = light.sample(p, rng.next2());
        double value = 0;
        if (s) {
            const double cosine = is_zero(normal) ? 1.0 : std::max(0.0, double{dot(normal, s->wi)});
            value = double{s->Li.x} * cosine / double{s->pdf};
        }
        sum += value;
        sum2 += value * value;
    }
    const double mean = sum / samples;
    return {mean, std::sqrt(std::max(0.0, sum2 / samples - mean * mean) / samples)};
}

/// Six standard errors (false alarm 2e-9 each) and the rounding of single precision.
inline double six_sigma(const Estimate& e, double rounding = 1e-5) {
    return 6 * e.error + rounding * std::fabs(e.mean);
}

}  // namespace nephele::test
