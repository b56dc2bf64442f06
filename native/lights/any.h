// SPDX-License-Identifier: GPL-3.0-or-later
// A lamp of any kind. A new kind of lamp is its own header plus one name in the variant and one line in
// `prepare_lamp`.
#pragma once

#include <variant>

#include "lights/area.h"
#include "lights/lamp_motion.h"
#include "lights/point.h"
#include "lights/spot.h"
#include "lights/sun.h"

namespace nephele {

using AnyLight = std::variant<PointLight, SpotLight, SunLight, AreaLight>;

struct Lamp {
    std::string name;
    AnyLight light;
    std::uint32_t visibility = ~1u;  ///< bits of RayKind: rays that see it when they hit it
    bool cast_shadow = true;         ///< false: nothing blocks it
    int max_bounces = 1024;
    Linking linking;
    LampMotion motion;

    std::optional<LightSample> sample(const Receiver& at, Vec2f u) const {
        if (!motion.moves())
            return std::visit([&](const auto& l) { return l.sample(at.p, u); }, light);
        const LampMotion::Moment now = motion.at(at.time);
        auto s = std::visit([&](const auto& l) { return l.sample(now.point_to_rest(at.p), u); }, light);
        if (s)
            s->wi = now.from_rest(s->wi);
        return s;
    }
    float pdf(const Receiver& at, Vec3f wi) const {
        if (!motion.moves())
            return std::visit([&](const auto& l) { return l.pdf(at.p, wi); }, light);
        const LampMotion::Moment now = motion.at(at.time);
        return std::visit([&](const auto& l) { return l.pdf(now.point_to_rest(at.p), now.to_rest(wi)); },
                          light);
    }
    std::optional<LightHit> intersect(const Ray& ray) const {
        if (!motion.moves())
            return std::visit([&](const auto& l) { return l.intersect(ray); }, light);
        const LampMotion::Moment now = motion.at(ray.time);
        Ray at_rest = ray;
        at_rest.o = now.point_to_rest(ray.o);
        at_rest.d = now.to_rest(ray.d);
        return std::visit([&](const auto& l) { return l.intersect(at_rest); }, light);
    }
    float importance(const Receiver& at) const {
        const Vec3f p = motion.moves() ? motion.at(at.time).point_to_rest(at.p) : at.p;
        return std::visit([&](const auto& l) { return l.importance(p); }, light);
    }
    Rgb power() const {
        return std::visit([](const auto& l) { return l.power(); }, light);
    }
    bool delta() const {
        return std::visit([](const auto& l) { return l.delta(); }, light);
    }
    /// Its light does not thin out with distance: suns and parallel beams.
    bool infinite() const {
        const auto* area = std::get_if<AreaLight>(&light);
        return std::holds_alternative<SunLight>(light) || (area && area->delta());
    }
};

/// Checks the values and derives the rest. Throws std::invalid_argument naming the lamp and the fault.
Lamp prepare_lamp(const LampDescription& description);

/// Where a lamp of finite size is, and its largest radiant intensity (far from it the fluence rate is
/// intensity / d^2).
struct LightBounds {
    Vec3f lower, upper;
    float intensity = 0;
};
LightBounds bounds_of(const AnyLight& light);
/// The same of a lamp, wherever it goes while the shutter is open.
LightBounds bounds_of(const Lamp& lamp);

}  // namespace nephele
