// SPDX-License-Identifier: GPL-3.0-or-later
// Pearson's chi-square test of counts against expected probabilities, for cells of any kind. With the seeds
// fixed an outcome never changes; with other seeds a correct sampler falls below kFalseAlarm in that share of
// the tests.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace nephele::test {

inline constexpr double kFalseAlarm = 1e-5;

/// Upper tail of the chi-square distribution (Wilson and Hilferty 1931: its cube root is nearly normal;
/// within some percent of the tail for the 5 and more degrees of freedom used here).
inline double chi_square_tail(double x, double freedom) {
    const double v = 2 / (9 * freedom);
    const double z = (std::cbrt(x / freedom) - (1 - v)) / std::sqrt(v);
    return 0.5 * std::erfc(z / std::sqrt(2.0));
}

/// p-value of the counts of `draws` draws. What the cells leave of the probabilities is a cell of its own:
/// draws that gave nothing. Cells with an expectation below 10 are pooled. 0 where an impossible cell was
/// hit.
inline double chi_square_p(const std::vector<std::uint64_t>& counts, const std::vector<double>& probabilities,
                           std::uint64_t draws) {
    double statistic = 0, pooled_expected = 0, pooled_count = 0, total = 0;
    std::uint64_t counted = 0;
    int cells = 0;
    const auto add = [&](double expected, double count) {
        statistic += (count - expected) * (count - expected) / expected;
        ++cells;
    };
    for (std::size_t i = 0; i < counts.size(); ++i) {
        total += probabilities[i];
        counted += counts[i];
        const double expected = probabilities[i] * static_cast<double>(draws);
        if (expected == 0 && counts[i] > 0)
            return 0;
        if (expected >= 10) {
            add(expected, static_cast<double>(counts[i]));
        } else {
            pooled_expected += expected;
            pooled_count += static_cast<double>(counts[i]);
        }
    }
    pooled_expected += std::max(0.0, 1 - total) * static_cast<double>(draws);
    pooled_count += static_cast<double>(draws - counted);
    if (pooled_expected >= 10) {
        add(pooled_expected, pooled_count);
    } else if (pooled_count > 40) {
        return 0;
    }
    return chi_square_tail(statistic, cells - 1);
}

}  // namespace nephele::test
