// SPDX-License-Identifier: GPL-3.0-or-later
// Shading points and programs for the tests of surfaces.
#pragma once

#include <cmath>
#include <initializer_list>
#include <map>
#include <string>

#include "surfaces/bsdf.h"

namespace nephele::testing {

/// Unit vector at an angle to +z (degrees) and an azimuth (degrees).
inline Vec3f at_angle(double theta, double phi = 0) {
    const double t = theta * M_PI / 180, p = phi * M_PI / 180;
    return {static_cast<float>(std::sin(t) * std::cos(p)), static_cast<float>(std::sin(t) * std::sin(p)),
            static_cast<float>(std::cos(t))};
}

/// A point of a flat surface with normal +z, seen along wo.
inline ShadingPoint point_seen_from(Vec3f wo, bool backfacing = false) {
    ShadingPoint point;
    point.ng = point.ns = Vec3f(0, 0, 1);
    point.wo = wo;
    point.backfacing = backfacing;
    return point;
}

/// A program without code: one register an input, plus one of ones for the weights.
class ConstantProgram {
  public:
    ConstantProgram() { program.registers = {Vec3f(1)}; }

    /// Adds a closure with these input values; inputs beyond them read 0, normals are not connected.
    ConstantProgram& add(ClosureKind kind, std::initializer_list<Vec3f> values,
                         Distribution mode = Distribution::ggx, float weight = 1) {
        ClosureRow row;
        row.kind = kind;
        row.mode = static_cast<std::int16_t>(mode);
        row.weight = hold(Vec3f(weight));
        std::size_t i = 0;
        for (const Vec3f v : values)
            row.inputs[i++] = std::isnan(v.x) ? std::int16_t{-1} : hold(v);
        program.closures.push_back(row);
        return *this;
    }

    Program program;

  private:
    std::int16_t hold(Vec3f v) {
        program.registers.push_back(v);
        return static_cast<std::int16_t>(program.registers.size() - 1);
    }
};

inline const Vec3f kNoNormal{NAN, NAN, NAN};

/// The inputs of a Principled closure, Blender's defaults unless set.
struct PrincipledInputs {
    Vec3f base_color{0.8f};
    float metallic = 0, roughness = 0.5f, ior = 1.5f, alpha = 1, specular_ior_level = 0.5f;
    Vec3f specular_tint{1};
    float transmission = 0, coat = 0, coat_roughness = 0.03f, coat_ior = 1.5f;
    Vec3f coat_tint{1};
    float sheen = 0, sheen_roughness = 0.5f;
    Vec3f sheen_tint{1}, emission_color{1};
    float emission_strength = 0;
    float diffuse_roughness = 0, anisotropic = 0, anisotropic_rotation = 0;
    Vec3f tangent{1, 0, 0};
    float subsurface = 0;
    Vec3f subsurface_radius{1, 0.2f, 0.1f};
    float subsurface_scale = 0.05f, subsurface_ior = 1.4f, subsurface_anisotropy = 0;
    float film_thickness = 0, film_ior = 1.33f;

    Program program(Distribution mode = Distribution::multi_ggx) const {
        const auto s = [](float v) { return Vec3f(v); };
        return ConstantProgram()
            .add(ClosureKind::principled,
                 {base_color,
                  s(metallic),
                  s(roughness),
                  s(ior),
                  s(alpha),
                  kNoNormal,
                  s(specular_ior_level),
                  specular_tint,
                  s(transmission),
                  s(coat),
                  s(coat_roughness),
                  s(coat_ior),
                  coat_tint,
                  kNoNormal,
                  s(sheen),
                  s(sheen_roughness),
                  sheen_tint,
                  emission_color,
                  s(emission_strength),
                  s(diffuse_roughness),
                  s(anisotropic),
                  s(anisotropic_rotation),
                  tangent,
                  s(subsurface),
                  subsurface_radius,
                  s(subsurface_scale),
                  s(subsurface_ior),
                  s(subsurface_anisotropy),
                  s(film_thickness),
                  s(film_ior)},
                 mode)
            .program;
    }
};

}  // namespace nephele::testing
