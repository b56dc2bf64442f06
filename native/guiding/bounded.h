// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds on single samples of heavy-tailed sums, so that a firefly does not decide what a region learns.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

namespace nephele {

/// Lowers the largest values so that none is more than a fiftieth of their sum, or two mean ones where they
/// are few. Values that are negative or not finite become 0. Returns the sum.
inline double bound_shares(std::vector<float>& values) {
    double sum = 0;
    for (float& v : values) {
        v = v > 0 && std::isfinite(v) ? v : 0;
        sum += double{v};
    }
    const double share = values.empty() ? 0 : std::max(0.02, 2.0 / static_cast<double>(values.size()));
    constexpr int kMostRounds = 500;  // each takes at least a hundredth off
    for (int i = 0; i < kMostRounds && sum > 0; ++i) {
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
