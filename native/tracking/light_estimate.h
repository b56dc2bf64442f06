// SPDX-License-Identifier: GPL-3.0-or-later
// Where along a ray light is: a cheap estimate of in-scattered radiance that candidates are weighted by
// (product resampling; Wrenninge and Villemin 2020), and a virtual density of candidates near one light,
// since where the medium is thin there might be none. The virtual density is equiangular (Kulla and Fajardo,
// EGSR 2012). Nothing here has to be right: weights undo whatever it says.
#pragma once

#include "lights/light_set.h"
#include "math/sampler.h"

namespace nephele {

/// A light as seen from the ray: where it is nearest, and how near, its size included.
struct LightView {
    float t = 0, distance = 1;

    /// Angle between the directions to a and b >= a. Not a difference of angles, of which nothing is left
    /// far from the light.
    float between(float a, float b) const {
        if (a == b)
            return 0;
        const double x = (double{a} - double{t}) / double{distance};
        if (b == kInfinity)
            return x > 0 ? std::atan(static_cast<float>(1 / x)) : kPi / 2 + std::atan(static_cast<float>(-x));
        const double y = (double{b} - double{t}) / double{distance}, ahead = 1 + x * y;
        const double across = (double{b} - double{a}) / double{distance};
        const float angle = std::atan(static_cast<float>(across / ahead));
        return ahead >= 0 ? angle : angle + kPi;
    }
    /// The point whose direction is that to a turned by `angle` >= 0.
    float turned(float a, float angle) const {
        const double x = (double{a} - double{t}) / double{distance};
        const double sine = std::sin(double{angle}),
                     ahead = std::cos(double{angle}) - x * sine;  // <= 0: behind, once around
        if (!(ahead > 0) || angle >= kPi)
            return kInfinity;
        return static_cast<float>(double{a} + double{distance} * sine * (1 + x * x) / ahead);
    }
};

class LightEstimate {
  public:
    /// For the part [t0, t1] of the ray; t1 may be infinite. One light is drawn for the virtual density.
    LightEstimate(const LightSet& lights, const Ray& ray, float t0, float t1, Rng& rng)
        : lights_(&lights), ray_(ray) {
        float reach = 0, total = 0;
        for (const LightBounds& light : lights.near_lights()) {
            const LightView view = view_of(light);
            reach = std::max(reach, std::max(view.t - t0, 0.0f) + 2 * view.distance);
        }
        const float end = std::min(t1, t0 + reach);
        for (const LightBounds& light : lights.near_lights()) {
            const LightView view = view_of(light);
            const float peak = light.intensity / (view.distance * view.distance);
            const float angle = view.between(t0, end);
            const float share = light.intensity / view.distance * angle;  // integral of intensity / d^2
            if (!(share > 0) || !(share < kInfinity))
                continue;
            total += share;
            peak_ = std::max(peak_, peak);
            if (rng.next() * total < share) {
                view_ = view;
                angle_ = view.between(t0, t1);
            }
        }
        mean_ = end > t0 ? total / (end - t0) + lights.distant_fluence() : 0;
        peak_ += lights.distant_fluence();
    }

    /// Whether light changes enough along the ray to be worth the trouble.
    bool pays() const { return mean_ > 0 && peak_ > kWorth * mean_; }

    /// Estimate at t, about 1 in the mean; > 0.
    float at(float t) const { return smoothed(lights_->fluence(ray_.at(t))); }
    /// About the largest estimate along the ray, at least 1.
    float largest() const { return std::max(smoothed(peak_), 1.0f); }
    /// Virtual density at t, 1/m.
    float rate(float t) const { return kExpected * pdf(t); }
    /// Expected number of virtual candidates in [a, b].
    float expected(float a, float b) const { return kExpected * view_.between(a, b) / angle_; }
    /// Where, from t on, `count` virtual candidates are expected.
    float advance(float t, float count) const {
        return std::max(view_.turned(t, count / kExpected * angle_), t);
    }
    float pdf(float t) const {
        const float along = t - view_.t;
        return view_.distance / (angle_ * (view_.distance * view_.distance + along * along));
    }

  private:
    LightView view_of(const LightBounds& light) const {
        const Vec3f to_centre = (light.lower + light.upper) * 0.5f - ray_.o;
        const float t = dot(to_centre, ray_.d) / dot(ray_.d, ray_.d);
        const float radius = length(light.upper - light.lower) / 4;
        const float d2 = dot(to_centre - ray_.d * t, to_centre - ray_.d * t) + radius * radius;
        return {t, std::sqrt(std::max(d2, 1e-8f * dot(to_centre, to_centre)) + 1e-30f)};
    }

    float smoothed(float fluence) const {
        constexpr float kLargest = 1e6f;  // at a lamp without size there is no bound
        return (std::min(fluence / mean_, kLargest) + kAmbient) / (1 + kAmbient);
    }

    static constexpr float kExpected = 2;    // virtual candidates along the whole part
    static constexpr float kAmbient = 2.0f;  // light that comes from elsewhere, share of the lights' mean
    static constexpr float kWorth = 4;

    const LightSet* lights_;
    Ray ray_;
    LightView view_;
    float angle_ = 1, mean_ = 0, peak_ = 0;
};

}  // namespace nephele
