// SPDX-License-Identifier: GPL-3.0-or-later
// Where a ray meets a lamp, as the lamp's node tree sees it. Texture coordinates: of an area lamp its
// rectangle, of a spot lamp the square around its cone, of a point lamp longitude and latitude.
#pragma once

#include "lights/any.h"

namespace nephele {

struct LampPoint {
    Vec3f p, n;  ///< suns: p is the direction towards them
    Vec2f uv{0, 0};
};

namespace detail {

inline Vec2f longitude_latitude(Vec3f v) {
    const float u = v.x == 0 && v.y == 0 ? 0.0f : 0.5f - std::atan2(v.x, v.y) * (0.5f * kInvPi);
    return {u, 1 - std::acos(std::clamp(v.z, -1.0f, 1.0f)) * kInvPi};
}

inline LampPoint lamp_point(const PointLight& light, Vec3f o, Vec3f d, float distance) {
    const Vec3f p = o + d * distance;
    const bool round = !light.delta() && light.ball.sphere;
    const Vec3f n = round ? safe_normalize(p - light.ball.center) : -d;
    return {p, n, longitude_latitude(light.axes.to_local(n))};
}

inline LampPoint lamp_point(const SpotLight& light, Vec3f o, Vec3f d, float distance) {
    LampPoint out = lamp_point(light.lamp, o, d, distance);
    const Vec3f v(dot(-d, light.axis_x), dot(-d, light.axis_y), dot(-d, light.axis_z));
    const float scale = v.z != 0 ? light.half_cotangent / -v.z : 0.0f;
    out.uv = {0.5f + v.x * scale, 0.5f + v.y * scale};
    return out;
}

inline LampPoint lamp_point(const AreaLight& light, Vec3f o, Vec3f d, float distance) {
    const Vec3f p = o + d * distance, v = p - light.center;
    return {p,
            light.normal,
            {0.5f + 0.5f * dot(v, light.x) / light.half_x, 0.5f + 0.5f * dot(v, light.y) / light.half_y}};
}

inline LampPoint lamp_point(const SunLight&, Vec3f, Vec3f d, float) {
    return {d, -d, {0, 0}};
}

}  // namespace detail

/// o, d: of the ray where the lamp stands as at the frame; distance: at which it meets the lamp.
inline LampPoint lamp_point(const AnyLight& light, Vec3f o, Vec3f d, float distance) {
    return std::visit([&](const auto& l) { return detail::lamp_point(l, o, d, distance); }, light);
}

}  // namespace nephele
