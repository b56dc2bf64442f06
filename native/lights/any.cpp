// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/any.h"

#include <stdexcept>

namespace nephele {

namespace {

[[noreturn]] void reject(const LampDescription& lamp, const std::string& fault) {
    throw std::invalid_argument("light '" + lamp.name + "': " + fault);
}

void check(const LampDescription& lamp) {
    for (const double m : lamp.world_from_light) {
        if (!std::isfinite(m))
            reject(lamp, "its transform is not finite; check its location, rotation and scale");
    }
    if (!is_finite(lamp.power))
        reject(lamp, "its power is not finite");
    if (min_component(lamp.power) < 0)
        reject(lamp, "its power is negative; use zero or more");
    if (!(lamp.radius >= 0 && std::isfinite(lamp.radius)))
        reject(lamp, "its radius must be 0 m or more");
    const auto sound = [](float x) { return x >= 0 && std::isfinite(x); };
    if (!sound(lamp.size_x) || !sound(lamp.size_y))
        reject(lamp, "its size must be 0 m or more, and finite");
    if (!sound(lamp.angle) || !sound(lamp.spread))
        reject(lamp, "its angle must be 0 or more, and finite");
    if (!sound(lamp.spot_size) || !sound(lamp.spot_blend))
        reject(lamp, "its spot size and blend must be 0 or more, and finite");
}

/// Whether the object's scale leaves the lamp something to shine with.
bool squeezed_flat(const LampDescription& lamp) {
    const bool x = lamp.scale(0) == 0, y = lamp.scale(1) == 0, z = lamp.scale(2) == 0;
    switch (lamp.kind) {
        case LampDescription::Kind::point:
            return false;
        case LampDescription::Kind::sun:
            return z;
        case LampDescription::Kind::spot:
            return x || y || z;
        case LampDescription::Kind::area:
            return x || y || z || lamp.size_x == 0 || lamp.size_y == 0;
    }
    return true;
}

}  // namespace

Lamp prepare_lamp(const LampDescription& description) {
    check(description);
    Lamp lamp{description.name,
              PointLight{},
              description.visibility,
              description.cast_shadow,
              description.max_bounces,
              description.linking,
              {}};
    if (!description.motion.empty()) {
        try {
            lamp.motion = LampMotion(transform_of(description.world_from_light), description.motion);
        } catch (const std::invalid_argument& e) {
            reject(description, e.what());
        }
    }
    // As in Cycles, a lamp without extent, by its size or its object's scale, gives no light: the black point
    // stays.
    if (squeezed_flat(description))
        return lamp;
    switch (description.kind) {
        case LampDescription::Kind::point:
            lamp.light = PointLight::prepare(description);
            break;
        case LampDescription::Kind::sun:
            lamp.light = SunLight::prepare(description);
            break;
        case LampDescription::Kind::spot:
            lamp.light = SpotLight::prepare(description);
            break;
        case LampDescription::Kind::area:
            lamp.light = AreaLight::prepare(description);
            break;
    }
    return lamp;
}

namespace {

LightBounds bounds(const PointLight& light) {
    const Vec3f r(light.ball.radius);
    const float area = light.delta() ? 1 : kPi * light.ball.radius * light.ball.radius;
    return {light.ball.center - r, light.ball.center + r, mean(light.emission) * area};
}
LightBounds bounds(const SpotLight& light) {
    return bounds(light.lamp);
}
LightBounds bounds(const AreaLight& light) {
    const Vec3f x = light.x * light.half_x, y = light.y * light.half_y;
    const Vec3f extent(std::fabs(x.x) + std::fabs(y.x), std::fabs(x.y) + std::fabs(y.y),
                       std::fabs(x.z) + std::fabs(y.z));
    return {light.center - extent, light.center + extent,
            mean(light.emission) * light.area() * light.peak_falloff()};
}
LightBounds bounds(const SunLight& light) {
    return {Vec3f(-kInfinity), Vec3f(kInfinity), mean(light.power())};
}

}  // namespace

LightBounds bounds_of(const AnyLight& light) {
    return std::visit([](const auto& l) { return bounds(l); }, light);
}

LightBounds bounds_of(const Lamp& lamp) {
    const LightBounds rest = bounds_of(lamp.light);
    if (!lamp.motion.moves() || lamp.infinite())
        return rest;
    LightBounds out{Vec3f(kInfinity), Vec3f(-kInfinity), rest.intensity};
    const std::size_t steps = lamp.motion.motion().steps().size();
    for (std::size_t step = 0; step < steps; ++step) {
        const auto now = lamp.motion.at(static_cast<float>(step) / static_cast<float>(steps - 1));
        for (unsigned corner = 0; corner < 8; ++corner) {
            const Vec3f p = now.point_from_rest({(corner & 1) ? rest.upper.x : rest.lower.x,
                                                 (corner & 2) ? rest.upper.y : rest.lower.y,
                                                 (corner & 4) ? rest.upper.z : rest.lower.z});
            out.lower = min(out.lower, p);
            out.upper = max(out.upper, p);
        }
    }
    // Between two steps it turns by up to 0.04: that far its corners may leave the box (see Motion).
    const Vec3f slack = (rest.upper - rest.lower) * 1e-3f;
    const Vec3f margin(max_component(slack));
    return {out.lower - margin, out.upper + margin, rest.intensity};
}

}  // namespace nephele
