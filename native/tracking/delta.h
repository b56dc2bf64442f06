// SPDX-License-Identifier: GPL-3.0-or-later
// Free flights: where, along a ray through any number of overlapping media, does a path scatter?
//
// Weighted delta tracking (Kutz, Habel, Li, Novak, SIGGRAPH 2017, section 4, with path-aware probabilities):
// at a candidate the path meets the medium with probability P = <beta sigma_t> / (<beta> majorant), < > the
// mean over RGB, and its throughput is multiplied by sigma_s / (majorant P) there, or by (majorant - sigma_t)
// / (majorant (1 - P)) where it goes on. In grey media these weights are the albedo and 1. Analog delta
// tracking (Woodcock 1965) lets absorption end the path.
#pragma once

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

    void start(const Segment& segment, bool global_majorant) {
        tracks.clear();
        for (const Interval& interval : segment.intervals) {
            tracks.emplace_back(interval, segment.ray, global_majorant);
        }
    }
};

namespace detail {

/// Sum of the coefficients of the tracks active at t; fills scratch.shares.
inline Coefficients coefficients_at(TrackingScratch& scratch, const Ray& ray, float t, Rng& rng,
                                    Counters& counters) {
    Coefficients sum;
    scratch.shares.clear();
    for (const MajorantTrack& track : scratch.tracks) {
        if (t < track.interval().t0 || t > track.interval().t1)
            continue;
        const Medium& m = *track.interval().medium;
        if (!m.interacts())
            continue;
        const float density = track.density(ray, t, rng, counters);
        if (density == 0)
            continue;
        sum.sigma_s += m.sigma_s * density;
        sum.sigma_t += m.sigma_t * density;
        scratch.shares.push_back({m.sigma_s * density, m.phase});
    }
    return sum;
}

}  // namespace detail

namespace detail {

/// Through homogeneous media of great depth, the world's above all, channels that they do not touch are sure
/// to get away, and the others are sure not to: decides between the two and leaves beta with the channels
/// decided for. Returns where the path gets to, or nothing where it does not get away so. Without this, a
/// path of an untouched channel would meet null collisions for ever.
inline std::optional<float> escape_deep_media(const TrackingScratch& scratch, float t, Rgb& beta, Rng& rng) {
    constexpr float kOpaque = 104;  // exp(-kOpaque) is 0 in single precision
    const float end = scratch.tracks.front().piece_end();
    Rgb sigma_t;
    for (const MajorantTrack& track : scratch.tracks) {
        if (track.interval().medium->density || track.piece_end() != end || t < track.interval().t0)
            return std::nullopt;
        sigma_t += track.interval().medium->sigma_t;
    }
    Rgb free = beta, bound = beta;
    for (int c = 0; c < 3; ++c) {
        if (sigma_t[c] > 0 && sigma_t[c] * (end - t) < kOpaque)
            return std::nullopt;
        (sigma_t[c] > 0 ? free : bound)[c] = 0;
    }
    if (is_zero(free))
        return std::nullopt;
    const float p = mean(free) / mean(beta);
    const bool escapes = rng.next() < p;
    beta = escapes ? free / p : bound / (1 - p);
    return escapes ? std::optional(end) : std::nullopt;
}

}  // namespace detail

/// Samples a flight through the segment and updates beta. `analog`: absorption ends paths instead of weighing
/// them.
inline Flight sample_flight(const Segment& segment, TrackingScratch& scratch, bool analog,
                            bool global_majorant, Rgb& beta, Rng& rng, Counters& counters) {
    Flight flight;
    scratch.start(segment, global_majorant);
    const auto gather = [&](float t0, float t1) {
        for (const MajorantTrack& track : scratch.tracks) {
            const Medium& m = *track.interval().medium;
            if (is_zero(m.emission) || track.interval().t0 > t0 || !(t1 < kInfinity))
                continue;
            Rgb emission = m.emission;
            if (m.density_scales_emission && m.density) {  // one point stands for the stretch
                if (track.empty())
                    continue;
                emission *= track.density(segment.ray, lerp(t0, t1, rng.next()), rng, counters);
            }
            flight.emitted += beta * emission * (t1 - t0);
        }
    };
    const auto decide = [&](float t, float majorant, const auto&) {
        if (const auto end = detail::escape_deep_media(scratch, t, beta, rng)) {
            gather(t, *end);
            return false;
        }
        const Coefficients c = detail::coefficients_at(scratch, segment.ray, t, rng, counters);
        const float real = mean(beta * c.sigma_t), all = mean(beta) * majorant;
        const float p = std::min(real / all, 1.0f);
        if (rng.next() >= p) {
            beta *= (Rgb(majorant) - min(c.sigma_t, Rgb(majorant))) / (majorant * (1 - p));
            return true;
        }
        const float before = mean(beta);
        beta *= c.sigma_s / (majorant * p);
        flight.t = t;
        flight.event = Flight::Event::scattered;
        flight.albedo = c.sigma_s / max(c.sigma_t, Rgb(1e-30f));
        if (analog) {
            const float survive = mean(beta) / before;
            if (rng.next() >= survive)
                flight.event = Flight::Event::absorbed;
            if (survive > 0)
                beta /= survive;
        }
        if (is_zero(beta))
            flight.event = Flight::Event::absorbed;
        return false;
    };
    for_each_candidate(scratch.tracks, segment.ray.t_min, rng, gather, decide);
    return flight;
}

}  // namespace nephele
