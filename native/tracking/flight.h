// SPDX-License-Identifier: GPL-3.0-or-later
// Free flights: where, along a ray through any number of overlapping media, does a path scatter? What the
// methods (delta.h, decomposition.h) share: the result, the media at a candidate, emission on the way.
#pragma once

#include <span>

#include "tracking/candidates.h"

namespace nephele {

/// The part of sigma_s at a scattering point that one medium contributes.
struct ScatterShare {
    Rgb sigma_s;
    PhaseFunction phase;
};

struct Flight {
    enum class Event { passed, scattered, absorbed } event = Event::passed;
    float t = 0;
    Rgb emitted;  ///< gathered along the way, throughput included
    Rgb albedo;   ///< single-scattering albedo where the path met the medium
};

/// Memory that a path reuses from segment to segment.
struct TrackingScratch {
    std::vector<MajorantTrack> tracks;
    std::vector<ScatterShare> shares;  ///< filled where a flight scatters
    std::vector<ScatterShare> picked;  ///< those of a stream's pick so far
    std::vector<Interval> absorbers;   ///< constant media that only absorb: these have a closed form

    /// `analog`: absorbers are tracked like the others.
    void start(const Segment& segment, bool analog, bool global_majorant) {
        tracks.clear();
        absorbers.clear();
        for (const Interval& interval : segment.intervals) {
            const Medium& m = *interval.medium;
            if (!analog && !m.bounds && is_zero(m.sigma_s) && is_zero(m.emission)) {
                absorbers.push_back(interval);
            } else {
                tracks.emplace_back(interval, segment, global_majorant);
            }
        }
    }
    /// What the absorbers let through up to t.
    Rgb absorbed_to(float t) const {
        Rgb T(1);
        for (const Interval& a : absorbers) {
            if (t > a.t0)
                T *= homogeneous_transmittance(a.medium->sigma_t, std::min(t, a.t1) - a.t0);
        }
        return T;
    }
};

namespace detail {

/// The tracks of which some may be active.
template <KernelTraits k>
std::span<const MajorantTrack> active_tracks(const TrackingScratch& scratch) {
    if constexpr (k.overlap)
        return scratch.tracks;
    else
        return {scratch.tracks.data(), 1};
}

/// Of all media at a point; sigma_t_scattering: of those that scatter there.
struct Coefficients {
    Rgb sigma_s, sigma_t, sigma_t_scattering;

    void add(Rgb s, Rgb t) {
        sigma_s += s;
        sigma_t += t;
        if (!is_zero(s))
            sigma_t_scattering += t;
    }
};

/// Sum of the coefficients of the tracks active at t; fills scratch.shares.
template <KernelTraits k = kEverything>
Coefficients coefficients_at(TrackingScratch& scratch, float t, Rng& rng, Counters& counters) {
    Coefficients sum;
    scratch.shares.clear();
    for (const MajorantTrack& track : active_tracks<k>(scratch)) {
        if (!track.covers(t) || track.empty() || !track.medium().interacts())
            continue;
        const MediumPoint m = track.point<k>(t, rng, counters);
        if (is_zero(m.sigma_t))
            continue;
        sum.add(m.sigma_s, m.sigma_t);
        scratch.shares.push_back({m.sigma_s, m.phase});
    }
    return sum;
}

/// Emission of the stretch [t0, t1], on which no event happened: one point stands for it. Stretches of dense
/// media are shorter than what floats at their distance can tell apart.
template <KernelTraits k = kEverything>
Rgb emission_between(const TrackingScratch& scratch, double t0, double t1, Rng& rng, Counters& counters) {
    Rgb sum;
    if (!k.emission || !(t1 < double{kInfinity}))
        return sum;
    const auto length = static_cast<float>(t1 - t0);
    float t = -1;
    for (const MajorantTrack& track : active_tracks<k>(scratch)) {
        const Medium& m = track.medium();
        const bool dark = track.empty() && (m.density_scales_emission || m.program);
        if (double{track.interval().t0} > t0 || !m.emits() || dark)
            continue;
        if (t < 0)
            t = static_cast<float>(t0 + (t1 - t0) * double{rng.next()});
        sum += track.emission<k>(t, rng, counters) * length;
    }
    return scratch.absorbers.empty() || t < 0 ? sum : sum * scratch.absorbed_to(t);
}

/// Where a path met media of these coefficients. beta: its throughput after, `before` its mean there.
/// `analog`: absorption ends paths instead of weighing them.
inline void meet(Flight& flight, float t, const Coefficients& c, bool analog, float before, Rgb& beta,
                 Rng& rng) {
    flight.t = t;
    flight.event = Flight::Event::scattered;
    flight.albedo = c.sigma_s / max(c.sigma_t, Rgb(1e-30f));
    if (analog) {
        const float survive = mean(beta) / before;
        if (!rng.chance(survive))
            flight.event = Flight::Event::absorbed;
        if (survive > 0)
            beta /= survive;
    }
    if (is_zero(beta))
        flight.event = Flight::Event::absorbed;
}

/// The path ends at t; for the loop: it does not go on.
inline bool absorb(Flight& flight, float t) {
    flight.t = t;
    flight.event = Flight::Event::absorbed;
    return false;
}

}  // namespace detail

}  // namespace nephele
