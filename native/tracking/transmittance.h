// SPDX-License-Identifier: GPL-3.0-or-later
// Transmittance of a segment: closed form in homogeneous media, and the estimator that the settings ask for
// in others. Transmittances of overlapping media multiply, and so do independent estimates of them, so each
// interval is estimated alone.
#pragma once

#include "settings_table.h"
#include "tracking/ray_marching.h"

namespace nephele {

/// Unbiased estimate of exp(-integral of sigma_t) along the segment.
template <KernelTraits k = kEverything>
Rgb estimate_transmittance(const Segment& segment, const Settings& settings, Rng& rng, Counters& counters) {
    const bool global = settings.majorant == Settings::Majorant::global;
    Rgb T(1);
    for (const Interval& interval : segment.intervals) {
        const Medium& m = *interval.medium;
        if (!m.interacts())
            continue;
        if (!m.bounds) {
            T *= homogeneous_transmittance(m.sigma_t, interval.t1 - interval.t0);
        } else {
            const MajorantTrack track(interval, segment, global);
            switch (settings.transmittance) {
                case Settings::Transmittance::ratio:
                    T *= ratio_transmittance<k>(track, rng, counters);
                    break;
                case Settings::Transmittance::residual_ratio:
                    T *= residual_ratio_transmittance(track, rng, counters);
                    break;
                case Settings::Transmittance::ray_marching:
                    T *= ray_marching_transmittance(track, rng, counters);
                    break;
            }
        }
        if (is_zero(T))
            break;
    }
    return T;
}

}  // namespace nephele
