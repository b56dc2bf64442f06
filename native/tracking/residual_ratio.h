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
        double at = double{t};  // floats cannot tell the candidates of dense media apart
        while (double{residual} * (double{end} - at) > double{tau}) {
            at = std::min(at + double{tau} / double{residual}, double{end});
            tau = rng.next_exponential();
            const Rgb rest = max(track.scale(static_cast<float>(at), rng, counters) - Rgb(minorant), Rgb(0));
            T *= max(Rgb(1) - unit * rest, Rgb(0));
            if (!detail::survives_roulette(T, rng))
                return Rgb(0);
        }
        tau -= static_cast<float>(double{residual} * (double{end} - at));
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
