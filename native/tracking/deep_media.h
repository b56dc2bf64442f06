// SPDX-License-Identifier: GPL-3.0-or-later
// Flights through homogeneous media of great depth whose channels differ, in closed form. Null collisions
// would take as many steps there as the densest channel is deep, for channels that hardly meet anything, and
// in the endless medium of a world steps without end. One channel's exponential says how far the path gets,
// chosen by its throughput; the densities of all of them weigh it (balance heuristic over the channels).
#pragma once

#include <optional>

#include "tracking/constant_piece.h"

namespace nephele::detail {

/// Where the media end, if the rest of the flight from t on is such a one.
template <KernelTraits k = kEverything>
std::optional<float> deep_end(const TrackingScratch& scratch, double t, Rgb beta) {
    constexpr float kDeep = 104;  // exp(-kDeep) is 0 in single precision
    constexpr float kUnlike = 0.1f;
    if (!k.chromatic)
        return std::nullopt;
    const float end = scratch.tracks.front().piece_end();
    Rgb sigma_t;
    for (const MajorantTrack& track : active_tracks<k>(scratch)) {
        if (track.medium().bounds || track.piece_end() != end || t < double{track.interval().t0})
            return std::nullopt;
        sigma_t += track.medium().sigma_t;
    }
    const float most = max_component(sigma_t);
    for (int c = 0; c < 3; ++c) {
        if (beta[c] > 0 && sigma_t[c] < kUnlike * most && most * (double{end} - t) > double{kDeep})
            return end;
    }
    return std::nullopt;
}

/// Light that the media's own emission from t to their end adds to a path of throughput beta at t.
template <KernelTraits k = kEverything>
Rgb deep_emission(const TrackingScratch& scratch, double t, float end, Rgb beta, Rng& rng) {
    Rgb emission, sigma_t, sum;
    for (const MajorantTrack& track : active_tracks<k>(scratch)) {
        emission += track.medium().emission;
        sigma_t += track.medium().sigma_t;
    }
    if (is_zero(emission))
        return sum;
    const auto length = static_cast<float>(double{end} - t);
    const bool absorbs = !scratch.absorbers.empty() && length < kInfinity;
    const float at = absorbs ? rng.next() * length : 0;  // one point stands for all: absorbers come and go
    const Rgb absorbed = absorbs ? scratch.absorbed_to(static_cast<float>(t) + at) : Rgb(1);
    for (int c = 0; c < 3; ++c) {
        if (!(emission[c] > 0) || !(sigma_t[c] > 0 || length < kInfinity))
            continue;
        sum[c] = beta[c] * emission[c] * absorbed[c] *
                 (absorbs ? length * std::exp(-sigma_t[c] * at) : transmitted_length(sigma_t[c], length));
    }
    return sum;
}

/// The rest of a flight from t to the media's end; updates beta.
template <KernelTraits k = kEverything>
void deep_flight(Flight& flight, TrackingScratch& scratch, double t, float end, bool analog, Rgb& beta,
                 Rng& rng, Counters& counters) {
    const Coefficients c = coefficients_at<k>(scratch, static_cast<float>(t), rng, counters);
    const auto length = static_cast<float>(double{end} - t);
    const Rgb share = beta / (beta.x + beta.y + beta.z);
    const float u = rng.next();
    int channel = u < share.x ? 0 : u < share.x + share.y ? 1 : 2;
    while (share[channel] == 0)
        channel = (channel + 2) % 3;
    const float s = rng.next_exponential() / c.sigma_t[channel];  // infinite where it meets nothing
    if (!(s < length)) {
        const Rgb T = homogeneous_transmittance(c.sigma_t, length);
        beta *= T / (3 * mean(share * T));
        return;
    }
    float least = kInfinity;
    for (int i = 0; i < 3; ++i)
        least = share[i] > 0 ? std::min(least, c.sigma_t[i]) : least;
    // All over what gets through best, which cannot vanish.
    const Rgb T = exp((c.sigma_t - Rgb(least)) * -s);
    const float before = mean(beta), density = 3 * mean(share * c.sigma_t * T);
    for (int i = 0; i < 3; ++i)
        beta[i] *= beta[i] > 0 ? c.sigma_s[i] * T[i] / density : 0;
    meet(flight, static_cast<float>(t + double{s}), c, analog, before, beta, rng);
}

/// Flies on from a null collision at t where that leads through deep media: false where it does not.
template <KernelTraits k = kEverything>
bool flies_on_deep(Flight& flight, TrackingScratch& scratch, double t, bool analog, Rgb& beta, Rng& rng,
                   Counters& counters) {
    const auto end = deep_end<k>(scratch, t, beta);
    if (!end)
        return false;
    flight.emitted += deep_emission<k>(scratch, t, *end, beta, rng);
    deep_flight<k>(flight, scratch, t, *end, analog, beta, rng, counters);
    return true;
}

}  // namespace nephele::detail
