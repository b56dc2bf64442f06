// SPDX-License-Identifier: GPL-3.0-or-later
// Guiding of one segment of a path, between two of its vertices: samples it by what was learned about such
// segments, by the pixel for camera rays, by the guiding field for others, and notes what it teaches.
#pragma once

#include "integrators/integrator.h"
#include "tracking/nds.h"
#include "tracking/stream.h"

namespace nephele {

class SegmentGuiding {
  public:
    /// beta: mean throughput at the segment's start.
    SegmentGuiding(const Settings& settings, std::optional<VspGuide> guide, float beta)
        : settings_(&settings), guide_(guide), beta_(beta) {}

    /// The segment's work begins.
    void start(const Counters& counters) { start_ = work(counters); }

    float beta() const { return beta_; }
    /// Whether the segment is guided at all.
    bool active() const { return compiled::vsp && guide_.has_value(); }
    bool resamples() const { return settings_->distance_sampling == Settings::DistanceSampling::vspg; }
    /// Whether to walk this segment to its end and resample, where that is a matter of what pays.
    bool walks(Rng& rng) const {
        return settings_->vsp_control == Settings::VspControl::exact || guide_->walk_share >= 1 ||
               rng.next() < guide_->walk_share;
    }

    /// Walks ws.segment. beta: throughput at its start.
    template <KernelTraits k>
    Stream walk(const Scene& scene, Rgb beta, bool weigh_lights, PathSampler& sampler, Workspace& ws) {
        const std::uint64_t lookups = ws.counters.density_lookups;
        std::optional<LightEstimate> lights;
        if (settings_->vsp_product && weigh_lights)
            lights = light_estimate(scene.lights(), ws.segment, sampler.rng());
        StreamSampler<k> sample(ws.segment, ws.tracking, *settings_, *guide_, lights ? &*lights : nullptr,
                                sampler.rng(), ws.counters);
        const Stream stream = sample.run(beta);
        record_.walked = true;
        record_.weighed = lights.has_value();
        const float per_beta = 1 / mean(beta);
        const float v = stream.weights.volume * per_beta, s = stream.weights.surface * per_beta;
        record_.volume_square = v * v;
        record_.surface_square = s * s;
        record_.both = v * s;
        record_.extra_work = static_cast<float>(ws.counters.density_lookups - lookups) - stream.plain_lookups;
        return stream;
    }

    /// Probability of scattering at the stream's candidate.
    float probability(const Stream& stream) const {
        return volume_probability(*settings_, *guide_, stream.weights);
    }
    /// Whether to take direct light there in any case: where the path itself rarely goes, though not so
    /// rarely that its light could not matter.
    bool gathers(float p) const { return settings_->vsp_gather && p > kLeastGather && p < kMostGather; }

    /// Decides with probability p between the stream's candidate and passing; updates beta. Emission is in
    /// the flight.
    Flight decide(const Stream& stream, float p, Rgb& beta, float distance, Rng& rng) {
        Flight flight{Flight::Event::absorbed, stream.t, stream.emitted, stream.albedo};
        const VspWeights& w = stream.weights;
        const float before = record_.probability;  // of having passed so far
        const bool scatters = rng.chance(p);
        note(w.volume * before, w.surface * before, distance);
        record_.transmittance *= w.passing_share;
        record_.majorant_depth += stream.majorant_depth;
        record_.scattered = scatters;
        record_.probability = before * (scatters ? p : 1 - p);
        passing_ *= 1 - p;
        beta = scatters ? stream.volume / p : stream.surface / (1 - p);
        if (!is_zero(beta))
            flight.event = scatters ? Flight::Event::scattered : Flight::Event::passed;
        return flight;
    }

    /// Samples the segment by NDS or NDS+; updates beta.
    Flight normalized_flight(Rgb& beta, float distance, PathSampler& sampler, Workspace& ws) {
        const float before = mean(beta);
        return noted(
            nds_flight(ws.segment, ws.tracking, *settings_, *guide_, beta, sampler.rng(), ws.counters),
            before, beta, distance);
    }

    /// Samples the segment as paths do without guiding; updates beta.
    template <KernelTraits k>
    Flight plain_flight(Rgb& beta, float distance, PathSampler& sampler, Workspace& ws) {
        const float before = mean(beta);
        return noted(sample_flight<k>(ws.segment, ws.tracking, *settings_, beta, sampler.rng(), ws.counters),
                     before, beta, distance);
    }

    /// What the segment taught, once all that comes of it is known. light: what the decision had a part in.
    /// gathered: direct light at the candidate, in any case; it counts as the volume's, or the volume would
    /// be visited as rarely as if that light were not there, and what else there is with it.
    const VspRecord& finish(Rgb light, Rgb gathered, const Counters& counters) {
        if (record_.scattered)
            light += gathered / record_.probability;
        record_.light = mean(light) / beta_;
        record_.volume_weight /= beta_;
        record_.surface_weight /= beta_;
        record_.cost = work(counters) - start_;
        return record_;
    }
    /// Probability with which the segment was to scatter; 0 where nothing asked for one.
    float target() const {
        if (!record_.known || !guide_)
            return 0;
        if (resamples() && !record_.walked)
            return 1 - guide_->transmittance;
        const bool conditional = settings_->vsp_control == Settings::VspControl::conditional && resamples();
        return conditional ? 1 - passing_ : guide_->target;
    }

  private:
    Flight noted(const Flight& flight, float before, Rgb beta, float distance) {
        const bool scattered = flight.event == Flight::Event::scattered;
        const float weight = flight.event == Flight::Event::absorbed ? 0 : mean(beta);
        // Weights and light of one sample alone have the right expectations; probabilities play no part.
        note(scattered ? weight : 0, scattered ? 0 : weight, distance);
        record_.transmittance *= scattered ? 0 : std::min(weight / before, 1e3f);
        record_.scattered = scattered;
        return flight;
    }

    static constexpr float kLeastGather = 0.02f, kMostGather = 0.5f;

    static std::optional<LightEstimate> light_estimate(const LightSet& lights, const Segment& segment,
                                                       Rng& rng) {
        constexpr std::size_t kMostLights = 64;  // more are not worth a look at each for every ray
        if (lights.near_lights().empty() || lights.near_lights().size() > kMostLights)
            return std::nullopt;
        float t0 = kInfinity, t1 = 0;
        for (const Interval& i : segment.intervals) {
            t0 = std::min(t0, i.t0);
            t1 = std::max(t1, i.t1);
        }
        std::optional<LightEstimate> out(std::in_place, lights, segment.ray, t0, t1, rng);
        if (!out->pays())
            out.reset();
        return out;
    }

    void note(float volume_weight, float surface_weight, float distance) {
        record_.known = true;
        record_.volume_weight += volume_weight;
        record_.surface_weight = surface_weight;
        record_.distance = distance;
    }

    /// Work so far, in density lookups; a ray costs about as much as kRay of them, a guided vertex as kQuery.
    static float work(const Counters& counters) {
        constexpr double kRay = 10, kQuery = 4;
        return static_cast<float>(static_cast<double>(counters.density_lookups) +
                                  kRay * static_cast<double>(counters.rays) +
                                  kQuery * static_cast<double>(counters.field_queries));
    }

    const Settings* settings_;
    std::optional<VspGuide> guide_;
    VspRecord record_;
    float beta_;
    float passing_ = 1;  // probability of having passed so far
    float start_ = 0;    // work before the path
};

}  // namespace nephele
