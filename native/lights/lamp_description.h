// SPDX-License-Identifier: GPL-3.0-or-later
// A lamp as the scene description states it (addon/description.py, Light), and the parts all lamps share.
//
// Radiance of a lamp of power P (W; W/m^2 for suns), as Cycles 5.0 has it; `normalize` False drops 1/area:
//
//     point, spot   L = P / (pi A), A = 4 pi r^2; for r = 0 the intensity is P / (4 pi) W/sr (P / pi
//     unnormalised) area          L = P / (pi A), A = sx sy, times pi/4 for ellipses sun           L = P /
//     (pi sin^2(angle/2)), which gives the irradiance P at normal incidence; angle 0: delta
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/light.h"
#include "math/transform.h"
#include "shading/program.h"

namespace nephele {

/// Values of one lamp. Lengths in metres, angles in radians, power in W (suns: W/m^2). It shines along its
/// local -z.
struct LampDescription {
    enum class Kind { point, sun, spot, area };

    std::string name;
    Kind kind = Kind::point;
    double world_from_light[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    Rgb power{1, 1, 1};
    bool normalize = true;      ///< false: power per m^2 of the lamp's area
    float radius = 0;           ///< point, spot
    bool soft_falloff = false;  ///< point, spot: a disc that faces the receiving point instead of a sphere
    float angle = 0;            ///< sun: full angle of its disc
    float spot_size = kPi / 4;  ///< spot: full angle of the cone
    float spot_blend = 0.15f;   ///< spot: share of the cone, in cosine, over which its edge fades
    bool ellipse = false;       ///< area: an ellipse in place of a rectangle
    float size_x = 1, size_y = 1;
    float spread = kPi;  ///< area: full angle
    std::uint32_t visibility = ~1u;
    bool cast_shadow = true;
    int max_bounces = 1024;
    float random = 0;  ///< of its object, in [0, 1]
    Linking linking;
    std::optional<Program> program;              ///< its emission scales the radiance; none: 1
    std::vector<std::array<double, 16>> motion;  ///< of world_from_light over the shutter; empty: it stands

    Vec3f position() const { return transform_of(world_from_light).translation; }
    /// Unit vector along local axis i.
    Vec3f axis(int i) const { return safe_normalize(transform_of(world_from_light).column(i)); }
    /// Scale of the lamp's object along local axis i.
    float scale(int i) const { return length(transform_of(world_from_light).column(i)); }
};

/// Where a ray that light sampling could have made meets a light.
struct LightHit {
    float distance = kInfinity;  ///< m along the ray
    Rgb Le;                      ///< radiance towards the ray's origin
    float pdf = 0;  ///< what `pdf(ray.o, ray.d)` returns: solid angle, as seen from the ray's origin
};

}  // namespace nephele
