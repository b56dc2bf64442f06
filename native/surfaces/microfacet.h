// SPDX-License-Identifier: GPL-3.0-or-later
// Microfacet distributions in a local frame whose z is the macroscopic normal and whose x is the direction of
// brushing, GGX
// (Trowbridge-Reitz; Walter et al. 2007) and Beckmann, with Smith's height-correlated shadowing G2 = 1 / (1 +
// Lambda(wo) + Lambda(wi)) (Heitz 2014). GGX samples the normals visible from wo (Dupuy and Benyoub 2023,
// "Sampling Visible GGX Normals with Spherical Caps"); Beckmann samples D cos. A brushed surface is an
// isotropic one of the same alpha, stretched (Heitz 2014, section 5.3): slopes are `stretch` times as large
// along x, and as much smaller along y.
#pragma once

#include "math/vec.h"

namespace nephele {

struct Microfacet {
    static constexpr float kSpecularAlpha = 1e-4f;  ///< below it the surface counts as perfectly smooth

    float alpha = 0;  ///< geometric mean of those along x and y
    bool beckmann = false;
    float stretch = 1, squeeze = 1;  ///< along x; squeeze: 1 / stretch

    /// As rough as alpha along and across together; neither is rougher than 1.
    static Microfacet brushed(float alpha, bool beckmann, float stretch) {
        if (stretch == 1)
            return {alpha, beckmann};
        const float along = std::min(alpha * stretch, 1.0f), across = std::min(alpha / stretch, 1.0f);
        const float mean = std::sqrt(along * across);
        if (!(mean > 0))
            return {0, beckmann};
        return {mean, beckmann, along / mean, mean / along};
    }

    bool specular() const { return alpha < kSpecularAlpha; }

    /// Roughness of the GGX surface of about the same albedo: Beckmann's tails are shorter and lose less.
    float ggx_roughness() const { return std::sqrt(beckmann ? 0.7f * alpha : alpha); }

    /// Density of normals h (h.z > 0) per solid angle and projected area.
    float D(Vec3f h) const {
        const float cos2 = h.z * h.z, sin2 = sqr(h.x * squeeze) + sqr(h.y * stretch);
        if (!beckmann)
            return 1 / (kPi * sqr(alpha * cos2 + sin2 / alpha));
        const float d = std::exp(-sin2 / (alpha * alpha * cos2));
        return d > 0 ? d / (kPi * sqr(alpha * cos2)) : 0;  // near the horizon both are 0
    }

    /// Smith's Lambda of a direction on either side.
    float Lambda(Vec3f w) const {
        constexpr float kLeastCos2 = 1e-36f;  // the square of less is no float
        const float tan2 =
            alpha * alpha * (sqr(w.x * stretch) + sqr(w.y * squeeze)) / std::max(w.z * w.z, kLeastCos2);
        if (!beckmann)
            return 0.5f * (std::sqrt(1 + tan2) - 1);
        if (tan2 == 0)
            return 0;
        const float a =
            1 / std::sqrt(tan2);  // exact for Beckmann: (erf(a) - 1) / 2 + exp(-a^2) / (2 a sqrt(pi))
        return 0.5f * (std::exp(-a * a) / (a * std::sqrt(kPi)) - std::erfc(a));
    }

    /// Draws a normal, given wo with wo.z > 0.
    Vec3f sample_normal(Vec3f wo, Vec2f u) const {
        const float phi = 2 * kPi * u.x;
        if (beckmann) {
            const float slope = alpha * std::sqrt(-std::log(1 - u.y));
            return normalize(Vec3f(slope * stretch * std::cos(phi), slope * squeeze * std::sin(phi), 1));
        }
        const float along = alpha * stretch, across = alpha * squeeze;
        const Vec3f w = normalize(Vec3f(along * wo.x, across * wo.y, wo.z));
        const float z = 1 - u.y * (1 + w.z), s = std::sqrt(std::max(0.0f, 1 - z * z));
        const Vec3f h = Vec3f(s * std::cos(phi), s * std::sin(phi), z) + w;
        return normalize(Vec3f(along * h.x, across * h.y, std::max(1e-7f, h.z)));
    }

    /// Density of sample_normal per solid angle, divided by wo.h (the factor that reflection and refraction
    /// cancel). d: D(h). lambda_o: Lambda(wo).
    float normal_pdf_over_cosine(Vec3f wo, Vec3f h, float d, float lambda_o) const {
        return beckmann ? d * h.z / dot(wo, h) : d / ((1 + lambda_o) * wo.z);
    }
};

}  // namespace nephele
