// SPDX-License-Identifier: GPL-3.0-or-later
// The loop of all free flights that go from candidate to candidate.
#pragma once

#include "tracking/deep_media.h"

namespace nephele::detail {

/// The loop of all methods. `event(t, majorant)` decides what happens at a candidate: it updates beta and the
/// flight, and returns whether the path goes on. `analog`: see meet().
template <KernelTraits k, class Event>
Flight fly(const Segment& segment, TrackingScratch& scratch, Flight& flight, bool analog, Rgb& beta, Rng& rng,
           Counters& counters, Event&& event) {
    const auto gather = [&](double t0, double t1) {
        const Rgb emitted = emission_between<k>(scratch, t0, t1, rng, counters);
        if (!is_zero(emitted))
            flight.emitted += beta * emitted;
    };
    const auto next_depth = [&] { return rng.next_exponential(); };
    for_each_candidate<k>(scratch.tracks, segment.ray.t_min, 1, next_depth, gather,
                          [&](double t, float majorant, const auto&) {
                              if (!event(static_cast<float>(t), majorant))
                                  return false;
                              return !flies_on_deep<k>(flight, scratch, t, analog, beta, rng, counters);
                          });
    if (!scratch.absorbers.empty())
        beta *= scratch.absorbed_to(flight.event == Flight::Event::passed ? segment.ray.t_max : flight.t);
    if (is_zero(beta))
        flight.event = Flight::Event::absorbed;
    return flight;
}

}  // namespace nephele::detail
