// SPDX-License-Identifier: GPL-3.0-or-later
// The candidate stream: a Poisson process along a ray whose rate is the sum of the majorants of all media
// there (design: null-collision methods, Miller, Georgiev, Jarosz 2019). Distance and transmittance
// estimators are loops over it.
#pragma once

#include <vector>

#include "math/sampler.h"
#include "media/segment.h"

namespace nephele {

/// Counts of work, summed over threads into the statistics.
struct Counters {
    std::uint64_t density_lookups = 0;
    std::uint64_t rays = 0;
};

/// The majorant of one interval, piece by piece.
class MajorantTrack {
  public:
    /// `global`: one bound for the whole grid, for the plain integrator and comparisons.
    MajorantTrack(const Interval& interval, const Ray& ray, bool global) : interval_(interval) {
        const Medium& m = *interval.medium;
        piece_end_ = interval.t0;
        if (m.density && !global) {
            walk_.emplace(*m.density->majorants, m.density->index_from_world.point(ray.o),
                          m.density->index_from_world.vector(ray.d), interval.t0, interval.t1);
        } else {
            global_majorant_ = m.sigma_t_max() * (m.density ? m.density->majorants->global_majorant() : 1.0f);
        }
    }

    const Interval& interval() const { return interval_; }
    float piece_end() const { return piece_end_; }
    float majorant() const { return majorant_; }
    /// Whether the field is 0 on the whole piece.
    bool empty() const { return walk_ && field_majorant_ == 0; }
    /// Moves to the piece after piece_end(); false at the interval's end.
    bool advance() {
        if (piece_end_ >= interval_.t1)
            return false;
        if (!walk_) {
            piece_end_ = interval_.t1;
            majorant_ = global_majorant_;
            return true;
        }
        MajorantPiece piece;
        if (!walk_->next(piece))
            return false;
        piece_end_ = piece.t_end;
        field_majorant_ = piece.majorant;
        majorant_ = piece.majorant * interval_.medium->sigma_t_max();
        return true;
    }

    /// Density at t of the current piece. Its expectation over the random numbers is the trilinear filter's
    /// value, and it never exceeds the piece's majorant.
    float density(const Ray& ray, float t, Rng& rng, Counters& counters) const {
        const Medium& m = *interval_.medium;
        if (!m.density)
            return 1;
        ++counters.density_lookups;
        const Vec3f p = walk_ ? walk_->point(t) : m.density->index_from_world.point(ray.at(t));
        return m.density->grid->stochastic(p, rng.next3());
    }

  private:
    Interval interval_;
    std::optional<MajorantWalk> walk_;
    float piece_end_, majorant_ = 0, field_majorant_ = 0, global_majorant_ = 0;
};

/// Walks the candidates of several overlapping intervals. `piece(t0, t1)` is called for every stretch between
/// events (candidates and piece ends), `candidate(t, majorant, tracks)` for every candidate; it returns false
/// to stop. The rate at t is the sum of the majorants of the tracks that are active at t.
template <class Piece, class Candidate>
void for_each_candidate(std::vector<MajorantTrack>& tracks, float t, Rng& rng, Piece&& piece,
                        Candidate&& candidate) {
    float tau = rng.next_exponential();
    for (;;) {
        float end = kInfinity, majorant = 0;
        bool any = false;
        for (std::size_t i = 0; i < tracks.size();) {
            MajorantTrack& track = tracks[i];
            if (t >= track.piece_end() && t >= track.interval().t0 && !track.advance()) {
                tracks[i] = tracks.back();
                tracks.pop_back();
                continue;
            }
            if (t < track.interval().t0) {
                end = std::min(end, track.interval().t0);
            } else {
                end = std::min(end, track.piece_end());
                majorant += track.majorant();
            }
            any = true;
            ++i;
        }
        if (!any)
            return;
        while (majorant * (end - t) > tau) {
            const float at = std::min(t + tau / majorant, end);
            piece(t, at);
            t = at;
            tau = rng.next_exponential();
            if (!candidate(t, majorant, tracks))
                return;
        }
        piece(t, end);
        if (end == kInfinity)
            return;  // nothing is left that could end the ray
        tau -= majorant > 0 ? majorant * (end - t) : 0;
        t = end;
    }
}

}  // namespace nephele
