// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/gabor.h"

#include "math/warp.h"
#include "shading/hash.h"

namespace nephele {
namespace {

constexpr int kImpulses = 8;  // in every cell

/// A complex number: the kernel's wave and its quadrature.
struct Phasor {
    float re = 0, im = 0;
};

/// One cell of the lattice; a 2D cell has no z.
struct Cell {
    float x, y, z;
    bool solid;

    float random(float number) const { return solid ? hash_unit(x, y, z, number) : hash_unit(x, y, number); }
    /// Where an impulse lies in the cell.
    Vec3f center(float number) const {
        if (!solid)
            return {hash_unit(x, y, number), hash_unit(number, x, y), 0};
        return {hash_unit(x, y, z, number), hash_unit(z, x, number, y), hash_unit(number, z, y, x)};
    }
    /// Two angles to turn a direction by.
    Vec2f angles(float number) const {
        return {kPi * hash_unit(x, y, z, number), kPi * hash_unit(z, x, number, y)};
    }
};

/// Direction of an impulse's wave.
Vec3f direction_of(const Cell& cell, float number, const GaborSettings& settings, float isotropy) {
    if (!cell.solid) {
        const float angle = settings.orientation + (cell.random(number) - 0.5f) * kPi * isotropy;
        return {std::cos(angle), std::sin(angle), 0};
    }
    const Vec3f& d = settings.direction;
    if (isotropy == 0)
        return d;
    const Vec2f turn = cell.angles(number);
    const float around = length(Vec3f(d.x, d.y, 0));
    const float inclination = std::acos(std::clamp(d.z, -1.0f, 1.0f)) + turn.x * isotropy;
    const float azimuth =
        (around > 0 ? std::copysign(std::acos(std::clamp(d.x / around, -1.0f, 1.0f)), d.y) : 0) +
        turn.y * isotropy;
    return {std::sin(inclination) * std::cos(azimuth), std::sin(inclination) * std::sin(azimuth),
            std::cos(inclination)};
}

/// Sum of a cell's impulses at the place p relative to it: Gaussians, brought to 0 at distance 1 by Hann's
/// window, times waves.
Phasor impulses(const Cell& cell, Vec3f p, const GaborSettings& settings, float isotropy) {
    Phasor sum;
    for (int i = 0; i < kImpulses; ++i) {
        const auto seed = static_cast<float>(3 * i);
        const Vec3f d = p - cell.center(seed + 1);
        const float r2 = dot(d, d);
        if (r2 >= 1)
            continue;
        const float sign = cell.random(seed + 2) < 0.5f ? -1.0f : 1.0f;
        const float envelope = sign * std::exp(-kPi * r2) * (0.5f + 0.5f * std::cos(kPi * r2));
        const float angle =
            2 * kPi * settings.frequency * dot(d, direction_of(cell, seed, settings, isotropy));
        sum.re += envelope * std::cos(angle);
        sum.im += envelope * std::sin(angle);
    }
    return sum;
}

}  // namespace

Gabor gabor_noise(Vec3f p, const GaborSettings& given) {
    GaborSettings settings = given;
    settings.frequency = std::max(settings.frequency, 0.001f);
    settings.direction = safe_normalize(settings.direction);
    const float isotropy = 1 - clamp01(settings.anisotropy);
    if (!is_finite(p) || !std::isfinite(settings.frequency))
        return {};
    const Vec3f cell(std::floor(p.x), std::floor(p.y), settings.solid ? std::floor(p.z) : 0);
    const Vec3f local(p.x - cell.x, p.y - cell.y, settings.solid ? p.z - cell.z : 0);
    Phasor sum;
    const int depth = settings.solid ? 1 : 0;
    for (int k = -depth; k <= depth; ++k) {
        for (int j = -1; j <= 1; ++j) {
            for (int i = -1; i <= 1; ++i) {
                const Vec3f offset(static_cast<float>(i), static_cast<float>(j), static_cast<float>(k));
                const Vec3f at = cell + offset;
                const Phasor part =
                    impulses({at.x, at.y, at.z, settings.solid}, local - offset, settings, isotropy);
                sum.re += part.re;
                sum.im += part.im;
            }
        }
    }
    // Six standard deviations: of one impulse, the squared kernel's integral times a sign's second moment.
    const float integral = settings.solid ? 0.25f / std::sqrt(2.0f) : 0.25f;
    const float scale = 6 * std::sqrt(kImpulses * 0.5f * integral);
    return {0.5f * sum.im / scale + 0.5f, (std::atan2(sum.im, sum.re) + kPi) / (2 * kPi),
            std::sqrt(sqr(sum.re) + sqr(sum.im)) / scale};
}

}  // namespace nephele
