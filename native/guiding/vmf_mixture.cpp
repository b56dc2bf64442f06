// SPDX-License-Identifier: GPL-3.0-or-later
#include "guiding/vmf_mixture.h"

namespace nephele {

namespace {

/// yes ? a : b of values that are both at hand, without the branch that compilers make of it.
inline float select(bool yes, float a, float b) {
    const std::uint32_t mask = yes ? ~0u : 0u;
    return std::bit_cast<float>((std::bit_cast<std::uint32_t>(a) & mask) |
                                (std::bit_cast<std::uint32_t>(b) & ~mask));
}

}  // namespace

void VmfMixture::set(int k, float lobe_weight, const VmfLobe& lobe, float lobe_inverse_distance) {
    weight[i(k)] = lobe_weight;
    mu_x[i(k)] = lobe.mu.x;
    mu_y[i(k)] = lobe.mu.y;
    mu_z[i(k)] = lobe.mu.z;
    kappa[i(k)] = lobe.kappa;
    peak[i(k)] = vmf_peak(lobe.kappa);
    inverse_distance[i(k)] = lobe_inverse_distance;
}

Vec3f VmfMixture::sample(float choice, Vec2f u) const {
    int last = 0;
    float left = choice;
    for (int k = 0; k < kMostLobes; ++k) {
        if (!(weight[i(k)] > 0))
            continue;
        last = k;
        left -= weight[i(k)];
        if (left < 0)
            break;
    }
    return vmf_sample({mu(last), kappa[i(last)]}, u);
}

VmfMixture VmfMixture::seen_from(Vec3f offset) const {
    VmfMixture out = *this;
    // From the place itself the direction is mu: nearer than a tenth of the distance it would be anyone's.
    constexpr float kNearest2 = 0.01f;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        const float x = mu_x[k] - offset.x * inverse_distance[k];
        const float y = mu_y[k] - offset.y * inverse_distance[k];
        const float z = mu_z[k] - offset.z * inverse_distance[k];
        const float length2 = x * x + y * y + z * z;
        const bool moves = length2 > kNearest2;
        const float scale = 1 / std::sqrt(moves ? length2 : 1.0f);
        out.mu_x[k] = moves ? x * scale : mu_x[k];
        out.mu_y[k] = moves ? y * scale : mu_y[k];
        out.mu_z[k] = moves ? z * scale : mu_z[k];
    }
    return out;
}

VmfMixture::Product VmfMixture::times(const VmfLobe& lobe) const {
    Product out{*this};
    VmfMixture& m = out.mixture;
    const float other_peak = vmf_peak(lobe.kappa), k2 = lobe.kappa;
    constexpr float kWide = 0.05f;
    for (std::size_t k = 0; k < kMostLobes; ++k) {
        const float k1 = kappa[k];
        const float x = k1 * mu_x[k] + k2 * lobe.mu.x, y = k1 * mu_y[k] + k2 * lobe.mu.y,
                    z = k1 * mu_z[k] + k2 * lobe.mu.z;
        const float product = std::sqrt(x * x + y * y + z * z);
        const float dx = mu_x[k] - lobe.mu.x, dy = mu_y[k] - lobe.mu.y, dz = mu_z[k] - lobe.mu.z;
        const float apart = 0.5f * (dx * dx + dy * dy + dz * dz);  // 1 - cosine
        // product - k1 - k2 without cancellation.
        const float exponent = -2 * k1 * k2 * apart / (product + k1 + k2 + 1e-30f);
        const bool points = product > 1e-6f, wide = product < kWide;
        const float scale = 1 / (points ? product : 1.0f);
        m.kappa[k] = product;
        // vmf_peak(product), both ways for every lobe: a branch would keep the loop from vector instructions.
        const float narrow = select(wide, kWide, product);
        const float near_uniform = kInv4Pi * (1 + product + product * product / 3);
        const float peaked = narrow / (2 * kPi * (1 - exp_of_negative(-2 * narrow)));
        const float normal = select(wide, near_uniform, peaked);
        m.peak[k] = normal;
        m.weight[k] = weight[k] * peak[k] * other_peak * exp_of_negative(exponent) / normal;
        m.mu_x[k] = points ? x * scale : mu_x[k];
        m.mu_y[k] = points ? y * scale : mu_y[k];
        m.mu_z[k] = points ? z * scale : mu_z[k];
    }
    for (const float w : m.weight)
        out.integral += w;
    if (!(out.integral > 0))
        return {*this, 0};
    for (float& w : m.weight)
        w /= out.integral;
    return out;
}

LobeValues VmfMixture::responsibilities(Vec3f w) const {
    LobeValues out = densities(w);
    float sum = 0;
    for (const float d : out)
        sum += d;
    if (!(sum > 0))
        return weight;
    for (float& d : out)
        d /= sum;
    return out;
}

}  // namespace nephele
