// SPDX-License-Identifier: GPL-3.0-or-later
// Closed forms of a stretch on which no medium varies: what gets through it, what scatters in it, and where.
#pragma once

#include "tracking/flight.h"

namespace nephele {

/// The integral of exp(-sigma_t s) over [0, length], accurate for all depths.
inline float transmitted_length(float sigma_t, float length) {
    const float depth = sigma_t * length;
    return depth > 1e-6f ? -std::expm1(-depth) / sigma_t : length * (1 - depth / 2);
}

/// Light that arrives at t0 + s of a constant piece, sigma_s included.
inline Rgb arriving(Rgb T, const detail::Coefficients& c, float s) {
    return T * c.sigma_s * homogeneous_transmittance(c.sigma_t, s);
}

/// Distance from t0 of a point of a constant piece, with density the mean over RGB of arriving() /
/// `integrals`' mean: one channel's truncated exponential, chosen by its integral (balance heuristic over the
/// channels).
inline float sample_constant(Rgb sigma_t, float length, Rgb integrals, float choice, float u) {
    float left = choice * (integrals.x + integrals.y + integrals.z);
    int channel = 0;
    while (channel < 2 && left >= integrals[channel])
        left -= integrals[channel++];
    while (channel > 0 && integrals[channel] == 0)
        --channel;
    const float sigma = sigma_t[channel], depth = sigma * length;
    if (depth < 1e-6f)
        return u * length;
    return std::min(-std::log1p(u * std::expm1(-depth)) / sigma, length);
}

/// sigma_s times transmitted_length(), which can be beyond floats where sigma_t is denormal.
inline float scattered_share(float sigma_s, float sigma_t, float length) {
    const float depth = sigma_t * length;
    return depth > 1e-6f ? sigma_s / sigma_t * -std::expm1(-depth) : sigma_s * length * (1 - depth / 2);
}

/// Integral of arriving() over the piece; channels that do not scatter have none, however long they are.
inline Rgb scattered(Rgb T, const detail::Coefficients& c, float length) {
    Rgb sum;
    for (int i = 0; i < 3; ++i) {
        if (c.sigma_s[i] > 0)
            sum[i] = T[i] * scattered_share(c.sigma_s[i], c.sigma_t[i], length);
    }
    return sum;
}

}  // namespace nephele
