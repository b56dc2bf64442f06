// SPDX-License-Identifier: GPL-3.0-or-later
// Transmittance: closed form in homogeneous media, ratio tracking (Novak, Selle, Jarosz, SIGGRAPH Asia 2014)
// through grids. Transmittances of overlapping media multiply, and so do independent estimates of them, so
// each interval is tracked alone.
#pragma once

#include "tracking/candidates.h"

namespace nephele {

namespace detail {

inline constexpr float kRouletteTransmittance = 0.05f;

/// exp(-sigma_t length), also for infinite lengths.
inline Rgb homogeneous_transmittance(Rgb sigma_t, float length) {
    const auto one = [&](float s) { return s > 0 ? std::exp(-s * length) : 1.0f; };
    return {one(sigma_t.x), one(sigma_t.y), one(sigma_t.z)};
}

inline Rgb grid_transmittance(const Interval& interval, const Ray& ray, bool global_majorant, Rng& rng,
                              Counters& counters) {
    const Medium& m = *interval.medium;
    MajorantTrack track(interval, ray, global_majorant);
    Rgb T(1);
    float t = interval.t0, tau = rng.next_exponential();
    while (track.advance()) {
        const float end = track.piece_end(), majorant = track.majorant();
        while (majorant * (end - t) > tau) {
            t = std::min(t + tau / majorant, end);
            tau = rng.next_exponential();
            const float density = track.density(ray, t, rng, counters);
            T *= max(Rgb(1) - m.sigma_t * (density / majorant), Rgb(0));
            const float largest = max_component(T);
            if (largest >= kRouletteTransmittance)
                continue;
            const float survive =
                largest / kRouletteTransmittance;  // unbiased, and bounds the walk in dense media
            if (rng.next() >= survive)
                return Rgb(0);
            T /= survive;
        }
        tau -= majorant * (end - t);
        t = end;
    }
    return T;
}

}  // namespace detail

/// Unbiased estimate of exp(-integral of sigma_t) along the segment.
inline Rgb estimate_transmittance(const Segment& segment, bool global_majorant, Rng& rng,
                                  Counters& counters) {
    Rgb T(1);
    for (const Interval& interval : segment.intervals) {
        const Medium& m = *interval.medium;
        if (!m.interacts())
            continue;
        T *= m.density ? detail::grid_transmittance(interval, segment.ray, global_majorant, rng, counters)
                       : detail::homogeneous_transmittance(m.sigma_t, interval.t1 - interval.t0);
        if (is_zero(T))
            break;
    }
    return T;
}

}  // namespace nephele
