// SPDX-License-Identifier: GPL-3.0-or-later
// Where along a ray light is: a cheap estimate of in-scattered radiance that candidates are weighted by
// (product resampling; Wrenninge and Villemin 2020), and a virtual density of candidates near one light,
// since where the medium is thin there might be none. The virtual density is equiangular (Kulla and Fajardo,
// EGSR 2012). Nothing here has to be right: weights undo whatever it says.
#pragma once

#include "lights/light_set.h"
#include "math/sampler.h"

namespace nephele {

class LightEstimate {
  public:
    /// For the part [t0, t1] of the ray; t1 may be infinite. One light is drawn for the virtual density.
    LightEstimate(const LightSet& lights, const Ray& ray, float t0, float t1, Rng& rng)
        : lights_(&lights), ray_(ray) {
        float reach = 0, total = 0;
        for (const LightBounds& light : lights.near_lights()) {
            const View view = view_of(light);
            reach = std::max(reach, std::max(view.t - t0, 0.0f) + 2 * view.distance);
        }
        const float end = std::min(t1, t0 + reach);
        for (const LightBounds& light : lights.near_lights()) {
            const View view = view_of(light);
            const float peak = light.intensity / (view.distance * view.distance);
            const float angle = view.angle(end) - view.angle(t0);
            const float share = light.intensity / view.distance * angle;  // integral of intensity / d^2
            if (!(share > 0) || !(share < kInfinity))
                continue;
            total += share;
            peak_ = std::max(peak_, peak);
            if (rng.next() * total < share) {
                view_ = view;
                angle0_ = view.angle(t0);
                angle_ = view.angle(t1) - angle0_;
            }
        }
        mean_ = end > t0 ? total / (end - t0) + lights.distant_fluence() : 0;
        peak_ += lights.distant_fluence();
    }

    /// Whether light changes enough along the ray to be worth the trouble.
    bool pays() const { return mean_ > 0 && peak_ > kWorth * mean_; }

    /// Estimate at t, about 1 in the mean; > 0.
    float at(float t) const {
        constexpr float kLargest = 1e6f;  // at a lamp without size there is no bound
        return (std::min(lights_->fluence(ray_.at(t)) / mean_, kLargest) + kAmbient) / (1 + kAmbient);
    }
    /// About the largest estimate along the ray, at least 1.
    float largest() const { return std::max((peak_ / mean_ + kAmbient) / (1 + kAmbient), 1.0f); }
    /// Virtual density at t, 1/m.
    float rate(float t) const { return kExpected * pdf(t); }
    /// Expected number of virtual candidates in [a, b].
    float expected(float a, float b) const { return kExpected * (view_.angle(b) - view_.angle(a)) / angle_; }
    /// Where, from t on, `count` virtual candidates are expected.
    float advance(float t, float count) const {
        const float angle = view_.angle(t) + count / kExpected * angle_;
        return angle < kPi / 2 ? std::max(view_.t + view_.distance * std::tan(angle), t) : kInfinity;
    }
    /// A point of the whole part, by the virtual density.
    float sample(float u) const {
        const float angle = angle0_ + u * angle_;
        return view_.t + view_.distance * std::tan(std::min(angle, 1.570796f));
    }
    float pdf(float t) const {
        const float along = t - view_.t;
        return view_.distance / (angle_ * (view_.distance * view_.distance + along * along));
    }

  private:
    /// A light as seen from the ray: where it is nearest, and how near, its size included.
    struct View {
        float t = 0, distance = 1;
        float angle(float at) const { return std::atan((at - t) / distance); }
    };
    View view_of(const LightBounds& light) const {
        const Vec3f to_centre = (light.lower + light.upper) * 0.5f - ray_.o;
        const float t = dot(to_centre, ray_.d) / dot(ray_.d, ray_.d);
        const float radius = length(light.upper - light.lower) / 4;
        const float d2 = dot(to_centre - ray_.d * t, to_centre - ray_.d * t) + radius * radius;
        return {t, std::sqrt(std::max(d2, 1e-8f * dot(to_centre, to_centre)) + 1e-30f)};
    }

    static constexpr float kExpected = 2;    // virtual candidates along the whole part
    static constexpr float kAmbient = 0.5f;  // light that comes from elsewhere, share of the lights' mean
    static constexpr float kWorth = 4;

    const LightSet* lights_;
    Ray ray_;
    View view_;
    float angle0_ = 0, angle_ = 1, mean_ = 0, peak_ = 0;
};

}  // namespace nephele
