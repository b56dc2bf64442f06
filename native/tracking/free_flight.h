// SPDX-License-Identifier: GPL-3.0-or-later
// The free flight that the settings ask for.
#pragma once

#include "settings_table.h"
#include "tracking/decomposition.h"
#include "tracking/delta.h"

namespace nephele {

/// Samples a flight through the segment and updates beta.
template <KernelTraits k = kEverything>
Flight sample_flight(const Segment& segment, TrackingScratch& scratch, const Settings& settings, Rgb& beta,
                     Rng& rng, Counters& counters) {
    const bool global = settings.majorant == Settings::Majorant::global;
    switch (settings.tracking) {
        case Settings::Tracking::decomposition:
            return decomposition_flight<k>(segment, scratch, global, beta, rng, counters);
        case Settings::Tracking::delta:
            return delta_flight<k>(segment, scratch, true, global, beta, rng, counters);
        case Settings::Tracking::weighted_delta:
            break;
    }
    return delta_flight<k>(segment, scratch, false, global, beta, rng, counters);
}

}  // namespace nephele
