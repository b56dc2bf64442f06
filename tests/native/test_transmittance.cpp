// SPDX-License-Identifier: GPL-3.0-or-later
// Estimates of transmittance against fine quadrature, in homogeneous, heterogeneous, chromatic and
// overlapping media, with local and global majorants. See kSigmas for false alarms.
#include <gtest/gtest.h>

#include <string>

#include "tracking/transmittance.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

using Estimator = Settings::Transmittance;
class TransmittanceIn : public testing::TestWithParam<std::tuple<Case, Estimator, bool>> {};
std::string estimator_name(const testing::TestParamInfo<std::tuple<Case, Estimator, bool>>& test) {
    constexpr const char* kNames[] = {"_ratio", "_residual_ratio", "_ray_marching"};
    const auto& [medium, estimator, global] = test.param;
    return medium.name + kNames[static_cast<int>(estimator)] + (global ? "_global" : "_local");
}
INSTANTIATE_TEST_SUITE_P(Media, TransmittanceIn,
                         testing::Combine(testing::ValuesIn(cases()),
                                          testing::Values(Estimator::ratio, Estimator::residual_ratio,
                                                          Estimator::ray_marching),
                                          testing::Bool()),
                         estimator_name);

TEST_P(TransmittanceIn, IsUnbiased) {
    Line line = std::get<0>(GetParam()).line();
    Settings settings = settings_of(Settings::Tracking::weighted_delta, std::get<2>(GetParam()));
    settings.transmittance = std::get<1>(GetParam());
    for (const float thickness : {1e-3f, 0.1f, 1.0f, 4.0f}) {  // times the case's own
        for (Medium& m : line.media)
            m.sigma_t *= thickness;
        Counters counters;
        Rng rng(29);
        Mean T[3];
        for (int n = 0; n < 40000; ++n) {
            const Rgb t = estimate_transmittance(line.segment, settings, rng, counters);
            for (int c = 0; c < 3; ++c)
                T[c].add(double{t[c]});
        }
        for (int c = 0; c < 3; ++c) {
            const double expected = Profile(line, 0, 50, c, 20000).transmittance();
            if (expected < 1e-3)
                continue;
            EXPECT_LT(T[c].z(expected), kSigmas) << "channel " << c << ", thickness " << thickness << ": "
                                                 << T[c].mean() << ", not " << expected;
        }
        for (Medium& m : line.media)
            m.sigma_t /= thickness;
    }
}

// The power series is unbiased whatever its estimates are: here of exp(-2), from numbers that are off by
// half.
TEST(Transmittance, PowerSeriesOfNoisyDepthsIsUnbiased) {
    Mean mean;
    Rng rng(53);
    for (int n = 0; n < 2000000; ++n) {
        const int terms = detail::series_length(rng);
        double x[detail::kMaxTerms + 1];
        for (int i = 0; i <= terms; ++i)
            x[i] = rng.next() < 0.5f ? -1 : -3;
        mean.add(detail::power_series(x, terms));
    }
    EXPECT_LT(mean.z(std::exp(-2.0)), kSigmas) << mean.mean();
}

TEST(Transmittance, ThroughAMillionMeanFreePathsOfAGridIsShortWork) {
    const Line line = grid_line(noisy, Rgb(1e5f), Rgb(0));
    for (const auto estimator : {Estimator::ratio, Estimator::residual_ratio, Estimator::ray_marching}) {
        Settings settings;
        settings.transmittance = estimator;
        Counters counters;
        Rng rng(37);
        for (int n = 0; n < 1000; ++n)
            EXPECT_LT(estimate_transmittance(line.segment, settings, rng, counters).x, 1e-6f);
        // Where the grid's edge fades in, candidates are dense before the density is: some thousand lookups a
        // ray, where a whole walk would take a million.
        EXPECT_LT(counters.density_lookups, 3000000u);
    }
}

}  // namespace
}  // namespace nephele::test
