// SPDX-License-Identifier: GPL-3.0-or-later
// Ratio tracking (Novak, Selle, Jarosz, SIGGRAPH Asia 2014): transmittance as the product of 1 - sigma_t /
// majorant over the candidates.
#pragma once

#include "tracking/candidates.h"

namespace nephele {

namespace detail {

/// Once no channel of a transmittance exceeds this, Russian roulette goes on with T / threshold: unbiased,
/// and it bounds the walk in dense media. False where the walk ends.
inline bool survives_roulette(Rgb& T, Rng& rng) {
    constexpr float kThreshold = 0.05f;
    const float largest = max_component(T);
    if (largest >= kThreshold)
        return true;
    const float survive = largest / kThreshold;
    if (rng.next() >= survive)
        return false;
    T /= survive;
    return true;
}

}  // namespace detail

/// Unbiased estimate of exp(-integral of sigma_t) over the track's interval.
inline Rgb ratio_transmittance(MajorantTrack track, Rng& rng, Counters& counters) {
    Rgb T(1);
    float t = track.interval().t0, tau = rng.next_exponential();
    while (track.advance()) {
        const float end = track.piece_end(), majorant = track.majorant();
        const Rgb unit = track.unit() / std::max(majorant, 1e-30f);
        double at = double{t};  // floats cannot tell the candidates of dense media apart
        while (double{majorant} * (double{end} - at) > double{tau}) {
            at = std::min(at + double{tau} / double{majorant}, double{end});
            tau = rng.next_exponential();
            T *= max(Rgb(1) - unit * track.scale(static_cast<float>(at), rng, counters), Rgb(0));
            if (!detail::survives_roulette(T, rng))
                return Rgb(0);
        }
        tau -= static_cast<float>(double{majorant} * (double{end} - at));
        t = end;
    }
    return T;
}

}  // namespace nephele
