// SPDX-License-Identifier: GPL-3.0-or-later
// The von Mises-Fisher distribution on the sphere: density kappa / (2 pi (1 - exp(-2 kappa))) exp(kappa (cos
// - 1)) around the axis mu; kappa = 0 is uniform. Fisher 1953; sampling after Jakob 2012, "Numerically stable
// sampling of the von Mises-Fisher distribution on S2"; product of two lobes as in Herholz et al. 2019.
#pragma once

#include "math/transform.h"

namespace nephele {

struct VmfLobe {
    Vec3f mu{0, 0, 1};
    float kappa = 0;
};

inline constexpr float kLargestKappa = 1e5f;  ///< a lobe of 0.2 degrees

/// The density on the axis: kappa / (2 pi (1 - exp(-2 kappa))), 1/sr.
inline float vmf_peak(float kappa) {
    if (kappa < 1e-6f)
        return kInv4Pi * (1 + kappa);
    return kappa / (2 * kPi * -std::expm1(-2 * kappa));
}

/// cos(mu, w) - 1 <= 0, without the cancellation that the difference has in narrow lobes.
inline float vmf_cosine_less_one(Vec3f mu, Vec3f w) {
    const Vec3f d = w - mu;
    return -0.5f * dot(d, d);
}

inline float vmf_pdf(const VmfLobe& lobe, Vec3f w) {
    return vmf_peak(lobe.kappa) * std::exp(lobe.kappa * vmf_cosine_less_one(lobe.mu, w));
}

inline Vec3f vmf_sample(const VmfLobe& lobe, Vec2f u) {
    // cos - 1 = log(1 - u (1 - exp(-2 kappa))) / kappa, u = 0 on the axis.
    const float less_one = lobe.kappa < 1e-6f
                               ? -2 * u.x
                               : std::max(std::log1p(u.x * std::expm1(-2 * lobe.kappa)) / lobe.kappa, -2.0f);
    const float sine = std::sqrt(std::max(-less_one * (2 + less_one), 0.0f));
    const float phi = 2 * kPi * u.y;
    return normalize(Frame(lobe.mu).to_world({sine * std::cos(phi), sine * std::sin(phi), 1 + less_one}));
}

/// Mean cosine to the axis: coth(kappa) - 1 / kappa, in [0, 1).
inline float vmf_mean_cosine(float kappa) {
    if (kappa < 0.05f)
        return kappa * (1.0f / 3 - kappa * kappa / 45);
    const double e = std::exp(-2 * double{kappa});
    return static_cast<float>((1 + e) / (1 - e) - 1 / double{kappa});
}

/// kappa of a mean cosine in [0, 1): Banerjee et al. 2005, improved by two steps of Newton's method.
inline float vmf_kappa(float mean_cosine) {
    const double r = std::clamp(double{mean_cosine}, 0.0, 1 - 1 / double{kLargestKappa});
    double kappa = r * (3 - r * r) / (1 - r * r);
    for (int i = 0; i < 2 && kappa > 0.05 && kappa < 50; ++i) {
        const double e = std::exp(-2 * kappa), coth = (1 + e) / (1 - e);
        kappa -= (coth - 1 / kappa - r) / (1 - coth * coth + 1 / (kappa * kappa));
    }
    if (kappa >= 50)  // coth is 1 there
        kappa = 1 / (1 - r);
    return static_cast<float>(std::min(kappa, double{kLargestKappa}));
}

/// A lobe about as wide as Henyey-Greenstein's for light that travels along `forward`: of the same mean
/// cosine.
inline VmfLobe vmf_of_henyey_greenstein(float g, Vec3f forward) {
    return {g < 0 ? -forward : forward, vmf_kappa(std::abs(g))};
}

}  // namespace nephele
