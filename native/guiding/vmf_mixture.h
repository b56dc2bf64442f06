// SPDX-License-Identifier: GPL-3.0-or-later
// A mixture of von Mises-Fisher lobes: the distribution over directions of the light that arrives in a region
// of space. Each lobe knows how far away its light comes from, so that the mixture can be seen from anywhere
// in the region (parallax; Ruppert, Herholz, Lensch 2020, "Robust Fitting of Parallax-Aware Mixtures for Path
// Guiding").
#pragma once

#include <array>

#include "guiding/vmf.h"

namespace nephele {

inline constexpr int kMostLobes = 8;

/// One value a lobe; loops over all of them become vector instructions.
using LobeValues = std::array<float, kMostLobes>;

/// exp(x) for x <= 0, relative error about 1e-6 (that of x, where x is large); 0 below about -87, and never a
/// denormal, which would cost a hundred cycles. Compilers vectorise it: floats are bounded as the integers
/// that their bits are, which unlike std::max needs no order of comparisons to be kept.
inline float exp_of_negative(float x) {
    constexpr std::uint32_t kMagnitude = 0x7fffffff;
    constexpr float kMost = 126;
    const float y = std::bit_cast<float>(std::min(std::bit_cast<std::uint32_t>(x * 1.44269504f) & kMagnitude,
                                                  std::bit_cast<std::uint32_t>(kMost)));
    const int whole = static_cast<int>(y);
    const float g = (static_cast<float>(whole) - y + 0.5f) * 0.693147181f;
    const float e = 1 + g * (1 + g * (0.5f + g * (1.0f / 6 + g * (1.0f / 24 + g * (1.0f / 120 + g / 720)))));
    // 2^(-whole - 1), whose bits are those of 0 at the end.
    return e * 1.41421356f * std::bit_cast<float>((126 - whole) << 23);
}

struct VmfMixture {
    struct Product;

    alignas(32) LobeValues weight{};  ///< adds up to 1; 0: the lobe is not there
    alignas(32) LobeValues mu_x{}, mu_y{}, mu_z{};
    alignas(32) LobeValues kappa{};
    alignas(32) LobeValues peak{};              ///< vmf_peak(kappa)
    alignas(32) LobeValues inverse_distance{};  ///< to where a lobe's light comes from, 1/m; 0: from infinity

    Vec3f mu(int k) const { return {mu_x[i(k)], mu_y[i(k)], mu_z[i(k)]}; }
    void set(int k, float lobe_weight, const VmfLobe& lobe, float lobe_inverse_distance);
    /// Density of a direction, 1/sr.
    float pdf(Vec3f w) const;
    Vec3f sample(float choice, Vec2f u) const;
    /// The mixture as seen from a place `offset` away from where it holds.
    VmfMixture seen_from(Vec3f offset) const;
    /// The product with a lobe, normalised, and its integral.
    Product times(const VmfLobe& lobe) const;
    /// Shares of the lobes in the density at w, which add up to 1.
    LobeValues responsibilities(Vec3f w) const;

  private:
    static constexpr std::size_t i(int k) { return static_cast<std::size_t>(k); }
    /// Weighted densities of the lobes at w.
    LobeValues densities(Vec3f w) const;
};

struct VmfMixture::Product {
    VmfMixture mixture;
    float integral = 0;  ///< of the mixture's density times the lobe's, 1/sr
};

inline LobeValues VmfMixture::densities(Vec3f w) const {
    alignas(32) LobeValues out;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        const float x = w.x - mu_x[k], y = w.y - mu_y[k], z = w.z - mu_z[k];
        const float less_one = -0.5f * (x * x + y * y + z * z);
        out[k] = weight[k] * peak[k] * exp_of_negative(kappa[k] * less_one);
    }
    return out;
}

inline float VmfMixture::pdf(Vec3f w) const {
    const LobeValues d = densities(w);
    return ((d[0] + d[1]) + (d[2] + d[3])) + ((d[4] + d[5]) + (d[6] + d[7]));
}

}  // namespace nephele
