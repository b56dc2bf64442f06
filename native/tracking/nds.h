// SPDX-License-Identifier: GPL-3.0-or-later
// The baselines of volume scattering probability guiding, both delta tracking made more likely to scatter;
// neither can make it less likely, and where the majorants are loose neither reaches the target.
//
// NDS, normalized distance sampling (Villemin, Wrenninge, Fong, JCGT 7(3), 2018): distances to candidates are
// truncated exponentials in the majorants' optical depth, as if the ray ended at the depth d that makes the
// first candidate as likely as the target: (1 - exp(-depth)) / (1 - exp(-d)) = target.
//
// NDS+ (after Xu et al., SIGGRAPH Asia 2024): a learned transmittance T of the pixel says by how much a
// candidate's probability p of being a collision has to rise: 1 - (1 - p)^k, T^k = 1 - target; and the
// majorants are raised where candidates are few.
#pragma once

#include "tracking/candidate_flight.h"
#include "tracking/ratio.h"
#include "tracking/vsp.h"

namespace nephele {

namespace detail {

/// Optical depth of the majorants along the segment.
inline float majorant_depth(const Segment& segment, TrackingScratch& scratch, bool global_majorant) {
    float depth = 0;
    scratch.start(segment, true, global_majorant);
    for_each_piece(scratch.tracks, segment.ray.t_min, [&](float t0, float t1, float majorant) {
        depth += majorant > 0 ? majorant * (t1 - t0) : 0;
        return true;
    });
    return depth;
}

/// Depths to candidates, truncated at what is left of `end`. Their weights: of a step to a candidate, and of
/// one that leaves the volume, whose depth is `depth` < end.
class TruncatedDepths {
  public:
    TruncatedDepths(float end, float depth, Rng& rng) : left_(end), beyond_(end - depth), rng_(rng) {}

    float operator()() {
        if (left_ == kInfinity)
            return rng_.next_exponential();
        before_ = share_;
        share_ = -std::expm1(-left_);
        const float tau = -std::log1p(-rng_.next() * share_);
        left_ = std::max(left_ - tau, beyond_);
        return tau;
    }
    /// Of the candidate just reached, after the next depth was drawn.
    float weight() const { return before_; }
    float passing_weight() const { return share_ / -std::expm1(-beyond_); }

  private:
    float left_, beyond_;
    Rng& rng_;
    float share_ = 1, before_ = 1;
};

/// Emission that arrives from along the segment, by ratio tracking: the steps of truncated depths say nothing
/// about how much of it gets through.
inline Rgb emission_along(const Segment& segment, TrackingScratch& scratch, bool global_majorant, Rgb beta,
                          Rng& rng, Counters& counters) {
    Rgb sum;
    scratch.start(segment, true, global_majorant);
    const auto gather = [&](double t0, double t1) {
        sum += beta * emission_between(scratch, t0, t1, rng, counters);
    };
    for_each_candidate(
        scratch.tracks, segment.ray.t_min, 1, [&] { return rng.next_exponential(); }, gather,
        [&](double t, float rate, const auto&) {
            const auto at = static_cast<float>(t);
            beta *= max(Rgb(1) - coefficients_at(scratch, at, rng, counters).sigma_t / rate, Rgb(0));
            if (!survives_roulette(beta, rng))
                return false;
            const auto end = deep_end(scratch, t, beta);
            if (end)
                sum += deep_emission(scratch, t, *end, beta, rng);
            return !end;
        });
    return sum;
}

/// Delta tracking's event at t with its collision's probability p turned into raised(p). False where the
/// path ends.
template <class Raise>
bool raised_event(Flight& flight, TrackingScratch& scratch, float t, float rate, Rgb& beta, Rng& rng,
                  Counters& counters, Raise&& raised) {
    const auto c = coefficients_at(scratch, t, rng, counters);
    const Rgb sigma_n = max(Rgb(rate) - c.sigma_t, Rgb(0));
    const float before = mean(beta), null = mean(beta * sigma_n), real = mean(beta * c.sigma_t_scattering);
    if (real + null == 0)
        return absorb(flight, t);
    // An event that has weight keeps a chance.
    constexpr float kMost = 0.9999f;
    float p = real / (real + null);
    p = null > 0 ? std::min(std::max(raised(p), p), std::max(p, kMost)) : 1;
    if (!rng.chance(p)) {
        beta *= sigma_n / (rate * (1 - p));
        return true;
    }
    beta *= c.sigma_s / (rate * p);
    meet(flight, t, c, false, before, beta, rng);
    return false;
}

}  // namespace detail

/// Samples a flight and updates beta, like sample_flight().
inline Flight nds_flight(const Segment& segment, TrackingScratch& scratch, const Settings& settings,
                         const VspGuide& guide, Rgb& beta, Rng& rng, Counters& counters) {
    const bool global = settings.majorant == Settings::Majorant::global;
    const float depth = detail::majorant_depth(segment, scratch, global), target = guide.target;
    const bool plus = settings.distance_sampling == Settings::DistanceSampling::nds_plus;
    const float likely = -std::expm1(-depth);
    constexpr float kLeastDepth = 1e-30f;  // of less, as of denormal densities, no more can be made
    Flight flight;
    const bool emits = std::any_of(segment.intervals.begin(), segment.intervals.end(),
                                   [](const Interval& i) { return i.medium->emits(); });
    if (emits && !plus)
        flight.emitted = detail::emission_along(segment, scratch, global, beta, rng, counters);
    scratch.start(segment, true, global);
    const auto gather = [&](double t0, double t1) {
        const Rgb emitted = detail::emission_between(scratch, t0, t1, rng, counters);
        if (!is_zero(emitted))
            flight.emitted += beta * emitted;
    };
    const float start = segment.ray.t_min;
    if (plus) {
        const float k =
            std::max(std::log1p(-target) / std::log(std::clamp(guide.transmittance, 1e-6f, 0.9999f)), 1.0f);
        const float scale = depth > kLeastDepth ? std::max(-std::log1p(-target) / depth, 1.0f) : 1;
        const auto raised = [&](float p) { return -std::expm1(k * std::log1p(-p)); };
        for_each_candidate(
            scratch.tracks, start, scale, [&] { return rng.next_exponential(); }, gather,
            [&](double t, float rate, const auto&) {
                return detail::raised_event(flight, scratch, static_cast<float>(t), rate, beta, rng, counters,
                                            raised) &&
                       !detail::flies_on_deep(flight, scratch, t, false, beta, rng, counters);
            });
    } else {
        const bool raises = target > likely && depth > kLeastDepth;
        const float end = raises ? -std::log1p(-likely / target) : kInfinity;
        detail::TruncatedDepths depths(end, depth, rng);
        for_each_candidate(
            scratch.tracks, start, 1, depths, [](double, double) {},
            [&](double t, float rate, const auto&) {
                beta *= depths.weight();
                if (!detail::raised_event(flight, scratch, static_cast<float>(t), rate, beta, rng, counters,
                                          [](float p) { return p; }))
                    return false;
                const Rgb emitted = flight.emitted;  // which was found already
                const bool ends = detail::flies_on_deep(flight, scratch, t, false, beta, rng, counters);
                flight.emitted = emitted;
                return !ends;  // so deep that nothing was truncated
            });
        if (flight.event == Flight::Event::passed && raises)
            beta *= depths.passing_weight();
    }
    if (is_zero(beta))
        flight.event = Flight::Event::absorbed;
    return flight;
}

}  // namespace nephele
