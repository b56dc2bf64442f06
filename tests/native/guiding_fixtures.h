// SPDX-License-Identifier: GPL-3.0-or-later
// Streams for tests: settings, guides, lamps beside the ray, and the walk that a camera ray takes.
#pragma once

#include "light_fixtures.h"
#include "media_fixtures.h"
#include "tracking/stream.h"

namespace nephele::test {

using Control = Settings::VspControl;

inline Settings vsp_settings(Control control, float defensive = 1, bool global = false) {
    Settings s;
    s.distance_sampling = Settings::DistanceSampling::vspg;
    s.vsp_control = control;
    s.vsp_defensive = defensive;
    s.majorant = global ? Settings::Majorant::global : Settings::Majorant::grid;
    return s;
}

/// A guide of these radiances and this target.
inline VspGuide guide_of(float volume_radiance, float surface_radiance, float target,
                         float majorant_depth = 0) {
    VspGuide guide;
    guide.volume_radiance = volume_radiance;
    guide.surface_radiance = surface_radiance;
    guide.target = target;
    guide.majorant_depth = majorant_depth;
    return guide;
}
/// What a pixel whose target is fixed is given.
inline VspGuide guide_to(float target, float majorant_depth = 0) {
    return guide_of(target, 1 - target, target, majorant_depth);
}

/// A point lamp without size.
inline Lamp point_lamp(Vec3f p, float power) {
    LampDescription d = lamp_of(Kind::point, power);
    place(d, p);
    return prepare_lamp(d);
}

/// Lamps at these distances along the ray and beside it.
struct LampPlace {
    float t, beside, power = 100;
};
inline LightSet lamps_along(const Ray& ray, const std::vector<LampPlace>& places) {
    const Vec3f side = normalize(cross(ray.d, Vec3f(0.3f, -0.2f, 0.9f)));
    std::vector<Lamp> lamps;
    lamps.reserve(places.size());
    for (const LampPlace& at : places)
        lamps.push_back(point_lamp(ray.at(at.t) + side * at.beside, at.power));
    return LightSet(std::move(lamps), {}, nullptr);
}

/// Walks streams through one segment, as camera rays do.
class Walker {
  public:
    /// lights: or null, for weights as they are.
    Walker(const Segment& segment, const Settings& settings, const VspGuide& guide, const LightSet* lights,
           std::uint64_t seed)
        : segment_(segment), settings_(settings), guide_(guide), lights_(lights), rng_(seed) {
        for (const Interval& i : segment.intervals) {
            t0_ = std::min(t0_, i.t0);
            t1_ = std::max(t1_, i.t1);
        }
    }

    Stream walk(Rgb beta = Rgb(1)) {
        std::optional<LightEstimate> estimate;
        if (lights_)
            estimate.emplace(*lights_, segment_.ray, t0_, t1_, rng_);
        StreamSampler stream(segment_, scratch, settings_, guide_, estimate ? &*estimate : nullptr, rng_,
                             counters);
        return stream.run(beta);
    }
    float probability(const Stream& stream) const {
        return volume_probability(settings_, guide_, stream.weights);
    }
    Rng& rng() { return rng_; }

    TrackingScratch scratch;
    Counters counters;

  private:
    const Segment& segment_;
    Settings settings_;
    VspGuide guide_;
    const LightSet* lights_;
    Rng rng_;
    float t0_ = kInfinity, t1_ = 0;
};

/// Integrals along the segment of a line in all channels, in equal bins of t.
struct LineTruth {
    double transmittance[3], emitted[3];
    std::vector<double> scattered[3];

    LineTruth(const Line& line, double from, double to, int bins, int steps = 20000) {
        for (int c = 0; c < 3; ++c) {
            const Profile profile(line, from, to, c, steps);
            transmittance[c] = profile.transmittance();
            emitted[c] = profile.emitted.back();
            const auto until = [&](int b) {
                return profile.at(profile.scattered, from + (to - from) * b / bins);
            };
            for (int b = 0; b < bins; ++b)
                scattered[c].push_back(until(b + 1) - until(b));
        }
    }
    double scattered_in_all(int c) const {
        double sum = 0;
        for (const double x : scattered[c])
            sum += x;
        return sum;
    }
};

}  // namespace nephele::test
