// SPDX-License-Identifier: GPL-3.0-or-later
// Ratio tracking (Novak, Selle, Jarosz, SIGGRAPH Asia 2014): transmittance as the product of 1 - sigma_t /
// majorant over the candidates.
#pragma once

#include <type_traits>

#include "tracking/candidates.h"

namespace nephele {

namespace detail {

/// Once no channel of a transmittance exceeds this, Russian roulette goes on with T / threshold: unbiased,
/// and it bounds the walk in dense media. False where the walk ends.
template <class Transmittance>
bool survives_roulette(Transmittance& T, Rng& rng) {
    constexpr float kThreshold = 0.05f;
    const float largest = max_component(Rgb(T));
    if (largest >= kThreshold)
        return true;
    const float survive = largest / kThreshold;
    if (!rng.chance(survive))
        return false;
    T *= 1 / survive;
    return true;
}

}  // namespace detail

/// Unbiased estimate of exp(-integral of sigma_t) over the track's interval.
template <KernelTraits k = kEverything>
Rgb ratio_transmittance(MajorantTrack track, Rng& rng, Counters& counters) {
    std::conditional_t<k.chromatic, Rgb, float> T(1);
    float t = track.interval().t0, tau = rng.next_exponential();
    while (track.advance()) {
        const float end = track.piece_end(), majorant = track.majorant();
        const Rgb unit = track.unit<k>() / std::max(majorant, 1e-30f);
        CandidateSteps steps(t, end, majorant, tau);
        while (steps.more()) {
            const auto at = static_cast<float>(steps.at());
            steps.advance(rng.next_exponential());
            const Rgb scale = track.scale<k>(at, rng, counters);
            if constexpr (k.chromatic)
                T *= max(Rgb(1) - unit * scale, Rgb(0));
            else
                T *= std::max(1 - unit.x * scale.x, 0.0f);
            if (!detail::survives_roulette(T, rng))
                return Rgb(0);
        }
        tau = steps.beyond();
        t = end;
    }
    return Rgb(T);
}

}  // namespace nephele
