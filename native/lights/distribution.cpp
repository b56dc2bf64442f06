// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/distribution.h"

#include <algorithm>
#include <stdexcept>

namespace nephele {

DiscreteDistribution::DiscreteDistribution(std::span<const float> weights) : sums_(weights.size()) {
    double sum = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        if (!(weights[i] >= 0) || !std::isfinite(weights[i])) {
            throw std::invalid_argument("a weight of a distribution is negative or not finite");
        }
        sums_[i] = sum += static_cast<double>(weights[i]);
    }
}

DiscreteDistribution::Choice DiscreteDistribution::sample(double u) const {
    const double target = u * total();
    // The first sum above the target: entries of weight 0 repeat the sum before them and are stepped over.
    auto found = std::upper_bound(sums_.begin(), sums_.end(), target);
    if (found == sums_.end())
        found = std::lower_bound(sums_.begin(), sums_.end(), sums_.back());
    const auto i = static_cast<std::size_t>(found - sums_.begin());
    const double w = weight(i), below = *found - w;
    const float rest = static_cast<float>((target - below) / w);
    return {static_cast<std::uint32_t>(i), static_cast<float>(w / total()),
            std::clamp(rest, 0.0f, kOneMinusEpsilon)};
}

}  // namespace nephele
