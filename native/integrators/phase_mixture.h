// SPDX-License-Identifier: GPL-3.0-or-later
// The phase function at a point where several media overlap: each medium's own, in proportion to its sigma_s
// per channel. Directions are drawn from one medium, chosen by the mean share of what the path carries.
#pragma once

#include <span>

#include "phase/phase_function.h"
#include "tracking/flight.h"

namespace nephele {

class PhaseMixture {
  public:
    /// beta: the path's throughput, which already holds the sum of sigma_s. shares: not empty.
    PhaseMixture(std::span<const ScatterShare> shares, Rgb beta) : shares_(shares), beta_(beta) {
        for (const ScatterShare& s : shares)
            total_ += s.sigma_s;
        for (const ScatterShare& s : shares)
            weight_sum_ += weight(s);
    }

    /// Phase function value, RGB in 1/sr; pdf: of sample() to return wi.
    Rgb eval(Vec3f wo, Vec3f wi, float& pdf) const {
        if (shares_.size() == 1) {
            pdf = shares_[0].phase.eval(wo, wi);
            return Rgb(pdf);
        }
        Rgb value;
        pdf = 0;
        for (const ScatterShare& s : shares_) {
            const float f = s.phase.eval(wo, wi);
            value += fraction(s) * f;
            pdf += weight(s) / weight_sum_ * f;
        }
        return value;
    }

    bool several() const { return shares_.size() > 1; }
    /// choice: which of several, unused for one.
    Vec3f sample(Vec3f wo, float choice, Vec2f u) const {
        std::size_t i = 0;
        if (shares_.size() > 1) {
            for (float left = choice * weight_sum_; i + 1 < shares_.size(); ++i) {
                left -= weight(shares_[i]);
                if (left < 0)
                    break;
            }
        }
        return shares_[i].phase.sample(wo, u);
    }

  private:
    Rgb fraction(const ScatterShare& s) const {
        const auto one = [](float a, float b) { return b > 0 ? a / b : 0; };
        return {one(s.sigma_s.x, total_.x), one(s.sigma_s.y, total_.y), one(s.sigma_s.z, total_.z)};
    }
    float weight(const ScatterShare& s) const { return mean(beta_ * fraction(s)); }

    std::span<const ScatterShare> shares_;
    Rgb beta_, total_;
    float weight_sum_ = 0;
};

}  // namespace nephele
