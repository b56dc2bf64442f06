// SPDX-License-Identifier: GPL-3.0-or-later
// Weighted spectral decomposition tracking (Kutz, Habel, Li, Novak, SIGGRAPH 2017, sections 3 and 5). The
// media are split into a control part, what their minorants say is everywhere on a piece at least, and the
// residual rest. A candidate is a collision with the control part with probability <beta sigma_t_control> /
// (<beta> majorant): that needs no lookup. Otherwise the density is looked up, and the candidate is a
// collision with the residual part or none, weighted as in delta.h.
#pragma once

#include "tracking/flight.h"

namespace nephele {

namespace detail {

/// What a track's medium is sure to hold on the current piece. A program's albedo has no lower bound: its
/// media have no control part.
inline MediumPoint control_of(const MajorantTrack& track) {
    const Medium& m = track.medium();
    if (m.program)
        return {};
    return {m.sigma_s * track.minorant(), m.sigma_t * track.minorant(), m.phase};
}

/// Sum of the control parts at t. `share`: fills scratch.shares with them.
inline Coefficients control_at(TrackingScratch& scratch, float t, bool share) {
    Coefficients sum;
    scratch.shares.clear();
    for (const MajorantTrack& track : scratch.tracks) {
        if (!track.covers(t) || track.minorant() == 0)
            continue;
        const MediumPoint control = control_of(track);
        sum.sigma_s += control.sigma_s;
        sum.sigma_t += control.sigma_t;
        if (share && !is_zero(control.sigma_s))
            scratch.shares.push_back({control.sigma_s, control.phase});
    }
    return sum;
}

/// Sum of the residual parts at t; fills scratch.shares with them.
inline Coefficients residual_at(TrackingScratch& scratch, float t, Rng& rng, Counters& counters) {
    Coefficients sum;
    scratch.shares.clear();
    for (const MajorantTrack& track : scratch.tracks) {
        if (!track.covers(t) || track.minorant() == track.scale_majorant() || !track.medium().interacts())
            continue;  // there is no rest
        const MediumPoint control = control_of(track), all = track.point(t, rng, counters);
        const Rgb sigma_s = max(all.sigma_s - control.sigma_s, Rgb(0));
        const Rgb sigma_t = max(all.sigma_t - control.sigma_t, Rgb(0));
        if (is_zero(sigma_t))
            continue;
        sum.sigma_s += sigma_s;
        sum.sigma_t += sigma_t;
        scratch.shares.push_back({sigma_s, all.phase});
    }
    return sum;
}

}  // namespace detail

inline Flight decomposition_flight(const Segment& segment, TrackingScratch& scratch, bool global_majorant,
                                   Rgb& beta, Rng& rng, Counters& counters) {
    Flight flight;
    return detail::fly(
        segment, scratch, flight, global_majorant, beta, rng, counters, [&](float t, float majorant) {
            const float before = mean(beta), u = rng.next();
            const auto control = detail::control_at(scratch, t, false);
            const float p_control = std::min(mean(beta * control.sigma_t) / (before * majorant), 1.0f);
            if (u < p_control) {
                detail::control_at(scratch, t, true);
                beta *= control.sigma_s / (majorant * p_control);
                detail::meet(flight, t, control, false, before, beta, rng);
                return false;
            }
            const auto residual = detail::residual_at(scratch, t, rng, counters);
            const float p_residual =
                std::min(mean(beta * residual.sigma_t) / (before * majorant), 1.0f - p_control);
            if (u >= p_control + p_residual) {
                beta *= max(Rgb(majorant) - control.sigma_t - residual.sigma_t, Rgb(0)) /
                        (majorant * (1 - p_control - p_residual));
                return true;
            }
            beta *= residual.sigma_s / (majorant * p_residual);
            detail::meet(flight, t, residual, false, before, beta, rng);
            return false;
        });
}

}  // namespace nephele
