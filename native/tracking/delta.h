// SPDX-License-Identifier: GPL-3.0-or-later
// Weighted delta tracking (Kutz, Habel, Li, Novak, SIGGRAPH 2017, section 4, with path-aware probabilities):
// at a candidate the path meets the medium with probability P = <beta sigma_t> / (<beta> majorant), < > the
// mean over RGB, and its throughput is multiplied by sigma_s / (majorant P) there, or by (majorant - sigma_t)
// / (majorant (1 - P)) where it goes on. In grey media these weights are the albedo and 1. Analog delta
// tracking (Woodcock 1965) lets absorption end the path.
#pragma once

#include "tracking/flight.h"

namespace nephele {

inline Flight delta_flight(const Segment& segment, TrackingScratch& scratch, bool analog,
                           bool global_majorant, Rgb& beta, Rng& rng, Counters& counters) {
    Flight flight;
    return detail::fly(segment, scratch, flight, global_majorant, beta, rng, counters,
                       [&](float t, float majorant) {
                           const auto c = detail::coefficients_at(scratch, t, rng, counters);
                           const float before = mean(beta);
                           const float p = std::min(mean(beta * c.sigma_t) / (before * majorant), 1.0f);
                           if (rng.next() >= p) {
                               beta *= (Rgb(majorant) - min(c.sigma_t, Rgb(majorant))) / (majorant * (1 - p));
                               return true;
                           }
                           beta *= c.sigma_s / (majorant * p);
                           detail::meet(flight, t, c, analog, before, beta, rng);
                           return false;
                       });
}

}  // namespace nephele
