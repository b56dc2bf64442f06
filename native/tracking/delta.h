// SPDX-License-Identifier: GPL-3.0-or-later
// Weighted delta tracking (Kutz, Habel, Li, Novak, SIGGRAPH 2017, section 4, with path-aware probabilities):
// at a candidate the path meets the medium with probability P = <beta sigma_t> / <beta majorant>, < > the
// mean over RGB, and its throughput is multiplied by sigma_s / (majorant P) there, or by sigma_n / (majorant
// (1 - P)), sigma_n = majorant - sigma_t, where it goes on. In grey media these weights are the albedo and 1.
// Media that do not scatter are left out of P: they only weigh, which is ratio tracking. Analog delta
// tracking (Woodcock 1965) meets those, too, and absorption ends paths.
#pragma once

#include "tracking/candidate_flight.h"

namespace nephele {

template <KernelTraits k = kEverything>
Flight delta_flight(const Segment& segment, TrackingScratch& scratch, bool analog, bool global_majorant,
                    Rgb& beta, Rng& rng, Counters& counters) {
    Flight flight;
    scratch.start(segment, analog, global_majorant);
    const auto event = [&](float t, float majorant) {
        const auto c = detail::coefficients_at<k>(scratch, t, rng, counters);
        const Rgb sigma_n = max(Rgb(majorant) - c.sigma_t, Rgb(0));
        // Over the sum of both, so that an event of no weight has no chance, whatever the rounding.
        const float before = mean(beta), null = mean(beta * sigma_n);
        const float real = mean(beta * (analog ? c.sigma_t : c.sigma_t_scattering));
        if (real + null == 0)
            return detail::absorb(flight, t);
        const float p = real / (real + null);
        if (!rng.chance(p)) {
            beta *= sigma_n / (majorant * (1 - p));
            return true;
        }
        beta *= c.sigma_s / (majorant * p);
        detail::meet(flight, t, c, analog, before, beta, rng);
        return false;
    };
    return detail::fly<k>(segment, scratch, flight, analog, beta, rng, counters, event);
}

}  // namespace nephele
