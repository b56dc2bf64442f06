// SPDX-License-Identifier: GPL-3.0-or-later
// The candidate stream: a Poisson process along a ray whose rate is the sum of the majorants of all media
// there (design: null-collision methods, Miller, Georgiev, Jarosz 2019). Distance and transmittance
// estimators are loops over it.
#pragma once

#include <vector>

#include "base/kernel_traits.h"
#include "math/sampler.h"
#include "media/segment.h"

namespace nephele {

/// Counts of work, summed over threads into the statistics.
struct Counters {
    std::uint64_t density_lookups = 0;
    std::uint64_t rays = 0;
    std::uint64_t segments = 0;          ///< of paths: the rays that are not shadow rays
    std::uint64_t field_queries = 0;     ///< of the guiding field
    std::uint64_t bound_violations = 0;  ///< lookups above the majorant or below the minorant: 0, or a bug
};

/// exp(-sigma_t length), also for infinite lengths.
inline Rgb homogeneous_transmittance(Rgb sigma_t, float length) {
    const auto one = [&](float s) { return s > 0 ? std::exp(-s * length) : 1.0f; };
    const float x = one(sigma_t.x);
    if (!compiled::chromatic || (sigma_t.y == sigma_t.x && sigma_t.z == sigma_t.x))  // an exp costs more
        return Rgb(x);
    return {x, one(sigma_t.y), one(sigma_t.z)};
}

/// The bounds of one interval, piece by piece. Bounds are of a scale that multiplies `unit()`: the density of
/// a grid, whose unit is the medium's sigma_t, or the extinction itself of a medium that a program computes.
class MajorantTrack {
  public:
    /// `global`: one bound for the whole medium, for the plain integrator and comparisons.
    MajorantTrack(const Interval& interval, const Segment& segment, bool global)
        : interval_(interval), segment_(&segment), piece_end_(interval.t0) {
        const Medium& m = *interval.medium;
        unit_ = m.program ? 1 : m.sigma_t_max();
        if (!m.bounds) {
            majorant_ = minorant_ = 1;
        } else if (global) {
            majorant_ = m.bounds->majorants.global_majorant();
            minorant_ = m.bounds->majorants.global_minorant();
        } else {
            const Transform& to_index = m.bounds->index_from_world;
            const Ray& ray = segment.ray_of(interval);
            walk_.emplace(m.bounds->majorants, to_index.point(ray.o), to_index.vector(ray.d), interval.t0,
                          interval.t1);
        }
    }

    const Medium& medium() const { return *interval_.medium; }
    const Interval& interval() const { return interval_; }
    float piece_end() const { return piece_end_; }
    /// Largest extinction of any channel on the piece, 1/m.
    float majorant() const { return majorant_ * unit_; }
    /// Lower bound of the scale on the piece: the part of the medium that is known without a lookup.
    float minorant() const { return minorant_; }
    /// Upper bound of the scale on the piece.
    float scale_majorant() const { return majorant_; }
    /// What a scale of 1 stands for.
    template <KernelTraits k = kEverything>
    Rgb unit() const {
        return k.programs && medium().program ? Rgb(1) : medium().sigma_t;
    }
    /// Whether there is nothing on the whole piece.
    bool empty() const { return majorant_ == 0; }
    bool covers(float t) const { return interval_.t0 <= t && t <= interval_.t1; }

    /// Moves to the piece after piece_end(); false at the interval's end.
    bool advance() {
        if (piece_end_ >= interval_.t1)
            return false;
        if (!walk_) {
            piece_end_ = interval_.t1;
            return true;
        }
        MajorantPiece piece;
        if (!walk_->next(piece))
            return false;
        piece_end_ = piece.t_end;
        majorant_ = piece.majorant;
        minorant_ = walk_->minorant();
        return true;
    }

    /// Extinction at t of the current piece as a multiple of unit(): never above the piece's majorant, and in
    /// expectation over the random numbers what the grid's filter gives. For media with a program, RGB.
    template <KernelTraits k = kEverything>
    Rgb scale(float t, Rng& rng, Counters& counters) const {
        const Medium& m = medium();
        if (!m.bounds)
            return Rgb(1);
        ++counters.density_lookups;
        if (k.programs && m.program)
            return within_bounds(m.program->coefficients(segment_->volume_point(interval_, t)).sigma_t,
                                 counters);
        return within_bounds(Rgb(m.grid->stochastic(m.filter, index_point(t), rng.next3())), counters);
    }
    /// Coefficients and phase function at t of the current piece, like scale().
    template <KernelTraits k = kEverything>
    MediumPoint point(float t, Rng& rng, Counters& counters) const {
        const Medium& m = medium();
        if (k.programs && m.program) {
            ++counters.density_lookups;
            const MediumPoint point = m.program->coefficients(segment_->volume_point(interval_, t));
            within_bounds(point.sigma_t, counters);
            return point;
        }
        const float density = scale<k>(t, rng, counters).x;
        return {m.sigma_s * density, m.sigma_t * density, m.phase};
    }
    /// Emission at t of the current piece, W/(m^3 sr).
    template <KernelTraits k = kEverything>
    Rgb emission(float t, Rng& rng, Counters& counters) const {
        const Medium& m = medium();
        if (k.programs && m.program) {
            ++counters.density_lookups;
            return m.program->emission(segment_->volume_point(interval_, t));
        }
        return m.density_scales_emission ? m.emission * scale<k>(t, rng, counters).x : m.emission;
    }

  private:
    /// Returns `scale`, which is counted where it is outside of the piece's bounds.
    Rgb within_bounds(Rgb scale, Counters& counters) const {
        constexpr float kRounding = 1e-5f;
        counters.bound_violations += max_component(scale) > majorant_ * (1 + kRounding) ||
                                     min_component(scale) < minorant_ * (1 - kRounding);
        return scale;
    }
    Vec3f index_point(float t) const {
        return walk_ ? walk_->point(t)
                     : medium().bounds->index_from_world.point(segment_->ray_of(interval_).at(t));
    }

    Interval interval_;
    const Segment* segment_;
    std::optional<AnyMajorantWalk> walk_;
    float piece_end_, unit_, majorant_ = 0, minorant_ = 0;
};

/// Walks the pieces of several overlapping intervals from t on. `piece(t0, t1, majorant)` is called for every
/// stretch on which the tracks and their bounds stay the same, with the sum of the majorants of the tracks
/// that are active there; it returns false to stop. The last t1 may be infinite. Where nothing overlaps, the
/// tracks come in order, the current one is the first, and what lies between two is left out.
template <KernelTraits k = kEverything, class Piece>
void for_each_piece(std::vector<MajorantTrack>& tracks, float t, Piece&& piece) {
    if constexpr (!k.overlap) {
        for (std::size_t i = 0; i < tracks.size(); ++i) {
            MajorantTrack& track = tracks.front();
            if (i > 0)
                track = tracks[i];
            for (t = track.interval().t0; track.advance(); t = track.piece_end()) {
                if (!piece(t, track.piece_end(), track.majorant()) || track.piece_end() == kInfinity)
                    return;
            }
        }
        return;
    }
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
        if (!any || !piece(t, end, majorant) || end == kInfinity)
            return;  // beyond infinity nothing is left that could end the ray
        t = end;
    }
}

/// Where the candidates of one piece of a ray are. Their optical depth counts from the piece's start: steps
/// added to t itself would be lost where they are shorter than its last place.
class CandidateSteps {
  public:
    /// tau: optical depth to the first candidate.
    CandidateSteps(float t0, float end, float rate, float tau)
        : t0_(double{t0}),
          end_(double{end}),
          length_per_depth_(1 / double{rate}),
          depth_(rate > 0 ? double{rate} * (double{end} - double{t0}) : 0),
          next_(double{tau}) {}

    /// Whether another candidate lies on the piece, and where.
    bool more() const { return next_ < depth_; }
    double at() const { return std::min(t0_ + next_ * length_per_depth_, end_); }
    /// Goes on to the candidate that is `tau` of optical depth away.
    void advance(float tau) { next_ += double{tau}; }
    /// Optical depth from the piece's end to the next candidate.
    float beyond() const { return static_cast<float>(next_ - depth_); }

  private:
    double t0_, end_, length_per_depth_, depth_, next_;
};

/// Walks the candidates of several overlapping intervals. `piece(t0, t1)` is called for every stretch between
/// events (candidates and piece ends), `candidate(t, rate, tracks)` for every candidate; it returns false to
/// stop. The rate at t is `scale` times the sum of the majorants of the tracks that are active at t. In dense
/// media candidates are closer to each other than floats can tell apart, so t is a double.
/// `next_depth()` draws the optical depth to the next candidate: exponential of rate 1 for a Poisson process.
template <KernelTraits k = kEverything, class NextDepth, class Piece, class Candidate>
void for_each_candidate(std::vector<MajorantTrack>& tracks, float start, float scale, NextDepth&& next_depth,
                        Piece&& piece, Candidate&& candidate) {
    float tau = next_depth();
    for_each_piece<k>(tracks, start, [&](float begin, float end, float majorant) {
        const float rate = majorant * scale;
        CandidateSteps steps(begin, end, rate, tau);
        double t = double{begin};
        while (steps.more()) {
            const double at = steps.at();
            piece(t, at);
            t = at;
            steps.advance(next_depth());
            if (!candidate(t, rate, tracks))
                return false;
        }
        piece(t, double{end});
        tau = steps.beyond();
        return true;
    });
}

}  // namespace nephele
