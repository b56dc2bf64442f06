// SPDX-License-Identifier: GPL-3.0-or-later
// Weighted spectral decomposition tracking (Kutz, Habel, Li, Novak, SIGGRAPH 2017, sections 3 and 5). The
// media are split into a control part, what their minorants say is everywhere on a piece at least, and the
// residual rest. A candidate is a collision with the control part with probability <beta sigma_t_control> /
// <beta majorant>: that needs no lookup. Otherwise the density is looked up, and the candidate is a collision
// with the residual part or none, weighted as in delta.h.
#pragma once

#include "tracking/candidate_flight.h"

namespace nephele {

namespace detail {

/// What a track's medium is sure to hold on the current piece. A program's albedo has no lower bound: its
/// media have no control part.
template <KernelTraits k>
MediumPoint control_of(const MajorantTrack& track) {
    const Medium& m = track.medium();
    if (k.programs && m.program)
        return {};
    return {m.sigma_s * track.minorant(), m.sigma_t * track.minorant(), m.phase};
}

/// Sum of the control parts at t. `share`: fills scratch.shares with them.
template <KernelTraits k>
Coefficients control_at(TrackingScratch& scratch, float t, bool share) {
    Coefficients sum;
    scratch.shares.clear();
    for (const MajorantTrack& track : active_tracks<k>(scratch)) {
        if (!track.covers(t) || track.minorant() == 0)
            continue;
        const MediumPoint control = control_of<k>(track);
        sum.add(control.sigma_s, control.sigma_t);
        if (share && !is_zero(control.sigma_s))
            scratch.shares.push_back({control.sigma_s, control.phase});
    }
    return sum;
}

/// Sum of the residual parts at t; fills scratch.shares with them.
template <KernelTraits k>
Coefficients residual_at(TrackingScratch& scratch, float t, Rng& rng, Counters& counters) {
    Coefficients sum;
    scratch.shares.clear();
    for (const MajorantTrack& track : active_tracks<k>(scratch)) {
        if (!track.covers(t) || track.minorant() == track.scale_majorant() || !track.medium().interacts())
            continue;  // there is no rest
        const MediumPoint control = control_of<k>(track), all = track.point<k>(t, rng, counters);
        const Rgb sigma_s = max(all.sigma_s - control.sigma_s, Rgb(0));
        const Rgb sigma_t = max(all.sigma_t - control.sigma_t, Rgb(0));
        if (is_zero(sigma_t))
            continue;
        sum.add(sigma_s, sigma_t);
        scratch.shares.push_back({sigma_s, all.phase});
    }
    return sum;
}

}  // namespace detail

template <KernelTraits k = kEverything>
Flight decomposition_flight(const Segment& segment, TrackingScratch& scratch, bool global_majorant, Rgb& beta,
                            Rng& rng, Counters& counters) {
    Flight flight;
    scratch.start(segment, false, global_majorant);
    const auto event = [&](float t, float majorant) {
        const auto control = detail::control_at<k>(scratch, t, false);
        const Rgb above = max(Rgb(majorant) - control.sigma_t, Rgb(0));
        // Over the sum of both, so that an event of no weight has no chance, whatever the rounding.
        const float before = mean(beta), known = mean(beta * control.sigma_t_scattering),
                    rest = mean(beta * above);
        if (known + rest == 0)
            return detail::absorb(flight, t);
        const float p_control = known / (known + rest);
        if (rng.chance(p_control)) {
            detail::control_at<k>(scratch, t, true);
            beta *= control.sigma_s / (majorant * p_control);
            detail::meet(flight, t, control, false, before, beta, rng);
            return false;
        }
        const auto residual = detail::residual_at<k>(scratch, t, rng, counters);
        const Rgb sigma_n = max(above - residual.sigma_t, Rgb(0));
        const float real = mean(beta * residual.sigma_t_scattering), null = mean(beta * sigma_n);
        if (real + null == 0)
            return detail::absorb(flight, t);
        const float p_residual = real / (real + null), scale = 1 / (majorant * (1 - p_control));
        if (!rng.chance(p_residual)) {
            beta *= sigma_n * (scale / (1 - p_residual));
            return true;
        }
        beta *= residual.sigma_s * (scale / p_residual);
        detail::meet(flight, t, residual, false, before, beta, rng);
        return false;
    };
    return detail::fly<k>(segment, scratch, flight, false, beta, rng, counters, event);
}

}  // namespace nephele
