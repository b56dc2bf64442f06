// SPDX-License-Identifier: GPL-3.0-or-later
// Spot lamp: a point lamp seen through a cone with a soft edge. The cone is measured in the lamp's own space,
// so an object's scale squeezes it. From inside the sphere there is no cone: the radiance is that of a point
// lamp.
#pragma once

#include "lights/point.h"

namespace nephele {

struct SpotLight {
    PointLight lamp;
    Vec3f axis_x, axis_y,
        axis_z;  ///< unit axes over their scales: v -> (v.x, v.y, v.z) scales into the lamp's space
    float half_cotangent = 0;  ///< of half the cone's angle, over 2
    float edge = 0;            ///< 1 - cosine of the cone's half angle: narrow cones keep their digits
    float edge_width = 0;      ///< in cosine, over which the edge fades; 0: hard

    static SpotLight prepare(const LampDescription& lamp) {
        SpotLight s;
        s.lamp = PointLight::prepare(lamp);
        s.axis_x = lamp.axis(0) / lamp.scale(0);
        s.axis_y = lamp.axis(1) / lamp.scale(1);
        s.axis_z = lamp.axis(2) / lamp.scale(2);
        s.half_cotangent =
            static_cast<float>(0.5 / std::tan(0.5 * std::clamp(double{lamp.spot_size}, 1e-6, 3.14159)));
        s.edge = 2 * sqr(std::sin(lamp.spot_size / 4));
        s.edge_width = s.edge * lamp.spot_blend;
        return s;
    }

    bool delta() const { return lamp.delta(); }
    /// Flux through the cone as if it had a hard edge and no squeeze, W.
    Rgb power() const { return lamp.power() * (0.5f * edge); }

    /// Share of the radiance left in the direction w of travel, away from the lamp; smoothstep over the edge.
    float falloff(Vec3f w) const {
        const Vec3f v = safe_normalize({dot(w, axis_x), dot(w, axis_y), dot(w, axis_z)});
        const float sine2 = v.x * v.x + v.y * v.y;
        const float inside = edge - (v.z < 0 ? sine2 / (1 - v.z) : 1 + v.z);  // from 1 - cosine
        if (inside <= 0)
            return 0;
        if (inside >= edge_width)
            return 1;
        const float x = inside / edge_width;
        return x * x * (3 - 2 * x);
    }

    std::optional<LightSample> sample(Vec3f p, Vec2f u) const {
        auto s = lamp.sample(p, u);
        if (!s)
            return std::nullopt;
        if (!lamp.ball.contains(p))
            s->Li *= falloff(-s->wi);
        if (is_zero(s->Li))
            return std::nullopt;
        return s;
    }
    float pdf(Vec3f p, Vec3f wi) const { return lamp.pdf(p, wi); }
    std::optional<LightHit> intersect(const Ray& ray) const {
        auto h = lamp.intersect(ray);
        if (!h)
            return std::nullopt;
        if (!lamp.ball.contains(ray.o))
            h->Le *= falloff(-ray.d);
        if (is_zero(h->Le))
            return std::nullopt;
        return h;
    }
    /// A bare point is weighed by its cone; a ball by the whole of it, since parts of it may lie in the cone.
    float importance(Vec3f p) const {
        return delta() ? lamp.importance(p) * falloff(safe_normalize(p - lamp.ball.center))
                       : lamp.importance(p);
    }
};

}  // namespace nephele
