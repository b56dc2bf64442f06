// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds on single samples of heavy-tailed sums, so that a firefly does not decide what a region learns.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace nephele {

/// Lowers the largest values so that none is more than a fiftieth of their sum, or two mean ones where they
/// are few. Values that are negative or not finite become 0. Where too few are left for that, they end up
/// equal and small, but not 0: they tell where light is, and little of how much. Returns the sum.
inline double bound_shares(std::vector<float>& values) {
    double sum = 0, positive = 0;
    for (float& v : values) {
        v = v > 0 && std::isfinite(v) ? v : 0;
        sum += double{v};
        positive += v > 0 ? 1 : 0;
    }
    const double share = values.empty() ? 0 : std::max(0.02, 2.0 / static_cast<double>(values.size()));
    const int rounds = share * positive > 1 ? 500 : 12;  // each of the 500 takes at least a hundredth off
    for (int i = 0; i < rounds && sum > 0; ++i) {
        const auto most = static_cast<float>(share * sum);
        double bounded = 0;
        for (float& v : values) {
            v = std::min(v, most);
            bounded += double{v};
        }
        const bool settled = bounded > 0.99 * sum;
        sum = bounded;
        if (settled)
            break;
    }
    return sum;
}

}  // namespace nephele
