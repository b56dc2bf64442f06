// SPDX-License-Identifier: GPL-3.0-or-later
// Residual ratio tracking (Novak, Selle, Jarosz, SIGGRAPH Asia 2014) with the minorant of each piece as
// control: what lies below it is integrated exactly, ratio tracking estimates the rest.
#pragma once

#include "tracking/ratio.h"

namespace nephele {

/// Unbiased estimate of exp(-integral of sigma_t) over the track's interval.
inline Rgb residual_ratio_transmittance(MajorantTrack track, Rng& rng, Counters& counters) {
    Rgb T(1);
    float t = track.interval().t0, tau = rng.next_exponential();
    while (track.advance()) {
        const float begin = t, end = track.piece_end(), minorant = track.minorant();
        const float residual = track.majorant() - max_component(track.unit()) * minorant;
        const Rgb unit = track.unit() / std::max(residual, 1e-30f);
        CandidateSteps steps(t, end, residual, tau);
        while (steps.more()) {
            const auto at = static_cast<float>(steps.at());
            steps.advance(rng.next_exponential());
            const Rgb rest = max(track.scale(at, rng, counters) - Rgb(minorant), Rgb(0));
            T *= max(Rgb(1) - unit * rest, Rgb(0));
            if (!detail::survives_roulette(T, rng))
                return Rgb(0);
        }
        tau = steps.beyond();
        t = end;
        if (minorant > 0) {
            T *= exp(track.unit() * (-minorant * (end - begin)));
            if (!detail::survives_roulette(T, rng))
                return Rgb(0);
        }
    }
    return T;
}

}  // namespace nephele
