// SPDX-License-Identifier: GPL-3.0-or-later
// Discrete distribution over 0..n-1 in proportion to given weights: running sums in double, so that a million
// small weights beside a huge one keep their share.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "math/vec.h"

namespace nephele {

class DiscreteDistribution {
  public:
    DiscreteDistribution() = default;
    /// Weights >= 0. Throws std::invalid_argument where one is negative or not finite. All zero: `empty`.
    explicit DiscreteDistribution(std::span<const float> weights);

    std::size_t size() const { return sums_.size(); }
    double total() const { return sums_.empty() ? 0 : sums_.back(); }
    bool empty() const { return !(total() > 0); }

    /// An index of nonzero weight, chosen with u in [0,1), and where u lies within that index's share, again
    /// in [0,1).
    struct Choice {
        std::uint32_t index;
        float probability;
        float u;
    };
    Choice sample(double u) const;
    /// Probability of index i; 0 for an empty distribution.
    float probability(std::size_t i) const { return empty() ? 0 : static_cast<float>(weight(i) / total()); }

  private:
    double weight(std::size_t i) const { return sums_[i] - (i > 0 ? sums_[i - 1] : 0); }

    std::vector<double> sums_;
};

}  // namespace nephele
