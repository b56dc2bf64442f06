// SPDX-License-Identifier: GPL-3.0-or-later
// Point lamp: a sphere of constant radiance (or what Ball offers besides). A receiving point inside it sees
// it all around.
#pragma once

#include "lights/ball.h"
#include "lights/lamp_description.h"
#include "math/pose.h"

namespace nephele {

/// Radiance (r > 0) or intensity (r = 0) of a point or spot lamp; see lamp_description.h.
inline Rgb ball_emission(const LampDescription& lamp) {
    const float area = lamp.radius > 0 ? 4 * kPi * lamp.radius * lamp.radius : 4.0f;
    return lamp.power * (kInvPi / (lamp.normalize ? area : 1.0f));
}

struct PointLight {
    Ball ball;
    Rgb emission;  ///< W/(m^2 sr); W/sr where the radius is 0
    Pose axes;     ///< of its object

    static PointLight prepare(const LampDescription& lamp) {
        return {{lamp.position(), lamp.radius, !lamp.soft_falloff},
                ball_emission(lamp),
                Pose(transform_of(lamp.world_from_light))};
    }

    bool delta() const { return ball.radius == 0; }
    /// Total flux, W.
    Rgb power() const { return emission * (delta() ? 4 * kPi : 4 * kPi * kPi * ball.radius * ball.radius); }

    std::optional<LightSample> sample(Vec3f p, Vec2f u) const {
        const auto s = ball.sample(p, u);
        if (!s)
            return std::nullopt;
        const float scale = !s->point ? 1 : delta() ? 1 / sqr(s->distance) : s->solid_angle;
        return LightSample{s->wi, s->distance, emission * scale, s->pdf, s->point};
    }
    float pdf(Vec3f p, Vec3f wi) const {
        const auto h = ball.hit(p, wi);
        return h ? h->pdf : 0;
    }
    std::optional<LightHit> intersect(const Ray& ray) const {
        const auto h = ball.hit(ray.o, ray.d);
        if (!h || h->distance < ray.t_min || h->distance > ray.t_max)
            return std::nullopt;
        return LightHit{h->distance, emission, h->pdf};
    }
    /// Fluence rate at p, W/m^2.
    float importance(Vec3f p) const {
        if (!delta())
            return mean(emission) * ball.solid_angle(p);
        const Vec3f v = ball.center - p;
        return mean(emission) / std::max(dot(v, v), 1e-20f);
    }
};

}  // namespace nephele
