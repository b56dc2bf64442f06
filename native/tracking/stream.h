// SPDX-License-Identifier: GPL-3.0-or-later
// Resampling distance sampling: one walk along the whole segment finds candidates for scattering, keeps one
// in proportion to its weight, and estimates the transmittance besides; only then is it decided whether the
// path scatters there or passes (vsp.h). Reservoir of one (Chao 1982): memory does not grow with the stream.
//
// In pieces where nothing varies a candidate stands for the whole piece, in closed form. Elsewhere candidates
// are a Poisson process whose rate is the majorant times rate_scale(), near lights a virtual density besides
// (light_estimate.h). T_i is the ratio-tracking estimate up to candidate i; its weight is the mean over RGB
// of beta W_i, W_i = T_i sigma_s / rate, times the light estimate. So no channel is singled out in chromatic
// media. The sum of beta W_i Li over all candidates is an unbiased estimate of the volume's light, and W_i
// (sum of weights) / (weight i) of the one kept is in expectation that sum, whatever the weights are.
#pragma once

#include <limits>

#include "tracking/constant_piece.h"
#include "tracking/light_estimate.h"
#include "tracking/vsp.h"

namespace nephele {

/// What a walk found.
struct Stream {
    VspWeights weights;
    float t = 0;  ///< of the candidate kept; its media are in scratch.shares
    Rgb volume;   ///< throughput where the path scatters there, before division by the probability
    Rgb surface;  ///< throughput where it passes, the same
    Rgb emitted;  ///< gathered along the way, throughput included
    Rgb albedo;   ///< single-scattering albedo at t
    float majorant_depth = 0;  ///< of what varies, before rate_scale()
    float plain_lookups = 0;   ///< that delta tracking is expected to need on the segment
};

template <KernelTraits k = kEverything>
class StreamSampler {
  public:
    StreamSampler(const Segment& segment, TrackingScratch& scratch, const Settings& settings,
                  const VspGuide& guide, const LightEstimate* lights, Rng& rng, Counters& counters)
        : segment_(segment),
          scratch_(scratch),
          settings_(settings),
          guide_(guide),
          lights_(lights),
          rng_(rng),
          counters_(counters) {}

    /// beta: throughput at the segment's start.
    Stream run(Rgb beta) {
        T_ = beta;
        any_constant_ = std::any_of(segment_.intervals.begin(), segment_.intervals.end(),
                                    [](const Interval& i) { return !i.medium->bounds; });
        const bool global = settings_.majorant == Settings::Majorant::global;
        const bool exact = settings_.vsp_control == Settings::VspControl::exact;
        // Exact control has to know what is ahead; for the other what the pixel has learned will do.
        const Ahead ahead = exact ? look_ahead(global) : Ahead{guide_.majorant_depth, 0, false};
        scale_ = rate_scale(settings_, guide_, ahead.depth);
        out_.weights.empty = ahead.scatters_surely ? 0 : std::exp(-scale_ * ahead.depth - ahead.near);
        scratch_.start(segment_, true, global);
        scratch_.picked.clear();
        tau_ = rng_.next_exponential();
        tau_virtual_ = rng_.next_exponential();
        for_each_piece<k>(scratch_.tracks, segment_.ray.t_min, [&](float t0, float t1, float majorant) {
            return nothing_varies(t0) ? constant_piece(t0, t1) : varying_piece(t0, t1, majorant);
        });
        finish(beta);
        return out_;
    }

  private:
    /// What a walk without lookups finds: the optical depth of the majorants where media vary, the expected
    /// number of virtual candidates, whether a piece is sure to have a candidate.
    struct Ahead {
        float depth = 0, near = 0;
        bool scatters_surely = false;
    };
    Ahead look_ahead(bool global) {
        Ahead ahead;
        scratch_.start(segment_, true, global);
        for_each_piece<k>(scratch_.tracks, segment_.ray.t_min, [&](float t0, float t1, float majorant) {
            if (nothing_varies(t0)) {
                const auto tracks = detail::active_tracks<k>(scratch_);
                ahead.scatters_surely |=
                    std::any_of(tracks.begin(), tracks.end(), [&](const MajorantTrack& track) {
                        return track.interval().t0 <= t0 && !is_zero(track.medium().sigma_s);
                    });
            } else if (majorant > 0) {
                ahead.depth += majorant * (t1 - t0);
                ahead.near += lights_ ? lights_->expected(t0, t1) : 0;
            }
            return true;
        });
        return ahead;
    }

    bool nothing_varies(float t) const {
        if (!any_constant_)
            return false;
        const auto tracks = detail::active_tracks<k>(scratch_);
        return std::none_of(tracks.begin(), tracks.end(), [&](const MajorantTrack& track) {
            return track.interval().t0 <= t && track.medium().bounds;
        });
    }

    /// Offers a candidate at t whose throughput is `value`; scratch_.shares are its media.
    void offer(float t, Rgb value, float weight, const detail::Coefficients& c) {
        if (!(weight > 0))
            return;
        out_.weights.volume += weight;
        if (!rng_.chance(weight / out_.weights.volume))
            return;
        out_.t = t;
        out_.volume = value / weight;
        out_.albedo = c.sigma_s / max(c.sigma_t, Rgb(1e-30f));
        std::swap(scratch_.picked, scratch_.shares);
    }

    bool constant_piece(float t0, float t1);
    void offer_constant(float t0, float length, const detail::Coefficients& c);
    void offer_constant_near_lights(float t0, float t1, const detail::Coefficients& c);
    bool varying_piece(float t0, float t1, float majorant);
    void candidate(float t, float rate);
    bool survives();

    /// What the majorants of this piece are multiplied by: no more than what was walked so far asks for,
    /// where this ray meets denser media than the pixel's usual one.
    float scale_here() const {
        if (settings_.vsp_control == Settings::VspControl::exact)
            return scale_;
        return std::min(scale_, std::max(kMostDepth / out_.majorant_depth, least_scale(guide_)));
    }

    void gather(double t0, double t1) {
        const Rgb emitted = detail::emission_between<k>(scratch_, t0, t1, rng_, counters_);
        if (!is_zero(emitted))
            out_.emitted += T_ * emitted;
    }

    void finish(Rgb beta) {
        out_.surface = T_;
        out_.volume *= out_.weights.volume;
        out_.weights.surface = mean(T_);
        out_.weights.passing_share = std::min(out_.weights.surface / mean(beta), 1.0f);
        out_.plain_lookups /= mean(beta);
        std::swap(scratch_.picked, scratch_.shares);
    }

    const Segment& segment_;
    TrackingScratch& scratch_;
    const Settings& settings_;
    const VspGuide& guide_;
    const LightEstimate* lights_;  // or none: all weights as they are
    Rng& rng_;
    Counters& counters_;

    Stream out_;
    Rgb T_;                            // beta times the transmittance so far
    float scale_ = 1;                  // of the majorants
    bool any_constant_ = false;        // some medium does not vary
    float tau_ = 0, tau_virtual_ = 0;  // optical depths to the next candidates
};

template <KernelTraits k>
bool StreamSampler<k>::constant_piece(float t0, float t1) {
    detail::Coefficients c;
    Rgb emission;
    scratch_.shares.clear();
    for (const MajorantTrack& track : detail::active_tracks<k>(scratch_)) {
        if (track.interval().t0 > t0)
            continue;
        const Medium& m = track.medium();
        c.add(m.sigma_s, m.sigma_t);
        emission += m.emission;
        if (!is_zero(m.sigma_s))
            scratch_.shares.push_back({m.sigma_s, m.phase});
    }
    const float length = t1 - t0;
    for (int i = 0; i < 3; ++i) {
        if (emission[i] > 0 && (c.sigma_t[i] > 0 || length < kInfinity))
            out_.emitted[i] += T_[i] * emission[i] * transmitted_length(c.sigma_t[i], length);
    }
    if (!scratch_.shares.empty()) {
        if (lights_) {
            offer_constant_near_lights(t0, t1, c);
        } else {
            offer_constant(t0, length, c);
        }
    }
    T_ *= homogeneous_transmittance(c.sigma_t, length);
    return !is_zero(T_);
}

template <KernelTraits k>
void StreamSampler<k>::offer_constant(float t0, float length, const detail::Coefficients& c) {
    const Rgb integrals = scattered(T_, c, length);
    const float weight = mean(integrals);
    const float s = sample_constant(c.sigma_t, length, integrals, rng_.next(), rng_.next());
    const Rgb value = arriving(T_, c, s);
    const float largest = mean(value);
    if (largest > 0)
        offer(t0 + s, value * (weight / largest), weight, c);
}

template <KernelTraits k>
void StreamSampler<k>::offer_constant_near_lights(float t0, float t1, const detail::Coefficients& c) {
    constexpr int kEach = 2;  // candidates by either way; each is weighed by the densities of both
    const float length = t1 - t0;
    const Rgb integrals = scattered(T_, c, length);
    const float all = mean(integrals);
    const float virtual_part = lights_->expected(t0, t1);
    if (!(all > 0))
        return;
    if (!(virtual_part > 0))  // too far from the light for its angles to differ
        return offer_constant(t0, length, c);
    const std::vector<ScatterShare> shares = scratch_.shares;
    for (int i = 0; i < 2 * kEach; ++i) {
        float s = 0;
        const float u = (static_cast<float>(i / 2) + rng_.next()) / kEach;
        if (i % 2 == 0) {
            s = sample_constant(c.sigma_t, length, integrals, rng_.next(), u);
        } else {
            s = std::clamp(lights_->advance(t0, u * virtual_part), t0, t1) - t0;
        }
        if (!(s < kInfinity))
            continue;  // nothing arrives from there
        const Rgb value = arriving(T_, c, s);
        const float by_medium = mean(value) / all, by_light = lights_->rate(t0 + s) / virtual_part;
        const Rgb each = value / (kEach * (by_medium + by_light));
        scratch_.shares = shares;
        offer(t0 + s, each, mean(each) * lights_->at(t0 + s), c);
    }
}

template <KernelTraits k>
bool StreamSampler<k>::varying_piece(float t0, float t1, float majorant) {
    out_.majorant_depth += majorant * (t1 - t0);
    if (majorant == 0) {
        gather(t0, t1);
        return true;
    }
    const float rate = majorant * scale_here();
    const double end = double{t1}, beyond = double{kInfinity};
    CandidateSteps steps(t0, t1, rate, tau_);
    for (double t = double{t0};;) {
        const auto here = static_cast<float>(t);
        const float left_virtual = lights_ ? lights_->expected(here, t1) : 0;
        const bool real = steps.more(), near = left_virtual > tau_virtual_;
        if (!real && !near) {
            gather(t, end);
            tau_ = steps.beyond();
            tau_virtual_ -= left_virtual;
            return true;
        }
        const double at_real = real ? std::max(steps.at(), t) : beyond;
        const double at_near = near ? std::min(double{lights_->advance(here, tau_virtual_)}, end) : beyond;
        const double at = std::min(at_real, at_near);
        const auto next = static_cast<float>(at);
        gather(t, at);
        if (at_real <= at_near) {
            steps.advance(rng_.next_exponential());
            tau_virtual_ -= lights_ ? lights_->expected(here, next) : 0;
        } else {
            tau_virtual_ = rng_.next_exponential();
        }
        t = at;
        candidate(next, rate + (lights_ ? lights_->rate(next) : 0));
        if (!survives())
            return false;
    }
}

template <KernelTraits k>
void StreamSampler<k>::candidate(float t, float rate) {
    out_.plain_lookups += mean(T_) / scale_here();
    const auto c = detail::coefficients_at<k>(scratch_, t, rng_, counters_);
    const Rgb value = T_ * c.sigma_s / rate;
    offer(t, value, mean(value) * (lights_ ? lights_->at(t) : 1), c);
    T_ *= max(Rgb(1) - c.sigma_t / rate, Rgb(0));
}

/// Russian roulette where what is still to come cannot matter against what was found, by what is known:
/// unbiased, and it bounds the walk in dense media without a limit to its steps.
template <KernelTraits k>
bool StreamSampler<k>::survives() {
    // A stream that ends has to scatter: where a target is to be met, only what passes next to never may end.
    const float negligible = settings_.vsp_control == Settings::VspControl::exact ? 1e-5f : 0.1f;
    const float volume = guide_.volume_radiance * (lights_ ? lights_->largest() : 1);
    const float ahead = max_component(T_) * std::max(volume, guide_.surface_radiance);
    // Denormals shrink no further where they are multiplied by more than one half.
    if (max_component(T_) < std::numeric_limits<float>::min()) {
        T_ = Rgb(0);
        return false;
    }
    const float found = guide_.volume_radiance * out_.weights.volume;
    const float survive = ahead / (negligible * (found + ahead));
    if (survive >= 1)
        return true;
    // Like a uniform number above `survive`, but never 0: a stream that has no chance does not survive.
    if (rng_.next_exponential() <= -std::log(survive)) {
        T_ = Rgb(0);
        return false;
    }
    T_ /= survive;
    return true;
}

}  // namespace nephele
