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
    Lamp lamp{description.name, PointLight{}, description.visibility, description.cast_shadow,
              description.max_bounces};
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

}  // namespace nephele
