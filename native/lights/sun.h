// SPDX-License-Identifier: GPL-3.0-or-later
// Sun lamp: a cone of directions of constant radiance, the same from everywhere; a single direction for angle
// 0.
#pragma once

#include "lights/lamp_description.h"
#include "math/warp.h"

namespace nephele {

struct SunLight {
    Vec3f to_sun{0, 0, 1};
    float one_minus_cos = 0;  ///< of the disc's half angle; 0: delta
    Rgb emission;             ///< radiance; irradiance at normal incidence where delta

    static SunLight prepare(const LampDescription& lamp) {
        SunLight s;
        s.to_sun = lamp.axis(2);
        const float half = std::clamp(lamp.angle / 2, 0.0f, kPi / 2);
        s.one_minus_cos = 2 * sqr(std::sin(half / 2));
        // Below single precision's resolution of directions the disc is a point: its irradiance counts.
        if (half < 1e-7f)
            s.one_minus_cos = 0;
        const float area = half > 0 ? kPi * sqr(std::sin(half)) : 1;
        s.emission = lamp.normalize ? lamp.power / area : lamp.power;
        if (s.delta() && half > 0)
            s.emission *= area;
        return s;
    }

    bool delta() const { return one_minus_cos == 0; }
    float solid_angle() const { return 2 * kPi * one_minus_cos; }
    /// Fluence rate, W/m^2: a sun has no finite power.
    Rgb power() const { return delta() ? emission : emission * solid_angle(); }

    std::optional<LightSample> sample(Vec3f, Vec2f u) const {
        if (delta())
            return LightSample{to_sun, kInfinity, emission, 1, true};
        const Vec3f wi = normalize(Frame(to_sun).to_world(sample_cone(u, one_minus_cos)));
        return LightSample{wi, kInfinity, emission, cone_pdf(one_minus_cos), false};
    }
    float pdf(Vec3f, Vec3f wi) const { return covers(wi) ? cone_pdf(one_minus_cos) : 0; }
    std::optional<LightHit> intersect(const Ray& ray) const {
        if (ray.t_max < kInfinity || !covers(ray.d))
            return std::nullopt;
        return LightHit{kInfinity, emission, cone_pdf(one_minus_cos)};
    }
    float importance(Vec3f) const { return mean(power()); }

  private:
    /// 1 - cos by the chord: |wi - to_sun|^2 / 2, exact for tiny discs.
    bool covers(Vec3f wi) const {
        const Vec3f chord = wi - to_sun;
        return !delta() && 0.5f * dot(chord, chord) <= one_minus_cos;
    }
};

}  // namespace nephele
