// SPDX-License-Identifier: GPL-3.0-or-later
// The baselines NDS and NDS+: unbiased like delta tracking, emission included; NDS reaches its target in
// homogeneous grey media and falls short where majorants are loose. See kSigmas for false alarms.
#include "tracking/nds.h"

#include <gtest/gtest.h>

#include "guiding_fixtures.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

constexpr int kBins = 4;

Settings nds_settings(bool plus, bool global) {
    Settings s = vsp_settings(Control::conditional, 1, global);
    s.distance_sampling = plus ? Settings::DistanceSampling::nds_plus : Settings::DistanceSampling::nds;
    return s;
}

/// How often flights scatter, and what they carry.
struct Flights {
    Mean scatters, passed[3], emitted[3], scattered[3][kBins];

    Flights(const Line& line, const Settings& settings, const VspGuide& guide, int n, Rgb start = Rgb(1)) {
        TrackingScratch scratch;
        Counters counters;
        Rng rng(157);
        for (int i = 0; i < n; ++i) {
            Rgb beta = start;
            const Flight f = nds_flight(line.segment, scratch, settings, guide, beta, rng, counters);
            const bool real = f.event == Flight::Event::scattered;
            scatters.add(real);
            const int bin = real ? std::min(static_cast<int>(f.t / 50 * kBins), kBins - 1) : -1;
            for (int c = 0; c < 3; ++c) {
                passed[c].add(f.event == Flight::Event::passed ? double{beta[c]} : 0);
                emitted[c].add(double{f.emitted[c]});
                for (int b = 0; b < kBins; ++b)
                    scattered[c][b].add(b == bin ? double{beta[c]} : 0);
            }
        }
    }
};

class NdsIn : public testing::TestWithParam<std::tuple<Case, bool>> {};
std::vector<Case> nds_cases() {
    std::vector<Case> out = cases();
    std::erase_if(out, [](const Case& c) { return c.name.ends_with("_kdtree"); });
    return out;
}
INSTANTIATE_TEST_SUITE_P(Media, NdsIn, testing::Combine(testing::ValuesIn(nds_cases()), testing::Bool()),
                         [](const auto& test) {
                             return std::get<0>(test.param).name +
                                    (std::get<1>(test.param) ? "_nds_plus" : "_nds");
                         });

TEST_P(NdsIn, FlightsAreUnbiased) {
    constexpr int kFlights = 20000;
    const auto& [medium, plus] = GetParam();
    Line line = medium.line();
    line.media.front().emission = {0.5f, 2, 0.1f};
    const LineTruth truth(line, 0, 50, kBins, 16000);
    const Rgb start{1, 0.5f, 0.8f};
    for (const float target : {0.1f, 0.8f}) {
        VspGuide guide = guide_to(target);
        guide.transmittance = 0.5f;
        const Flights flights(line, nds_settings(plus, target < 0.5f), guide, kFlights, start);
        for (int c = 0; c < 3; ++c) {
            const double scale = double{start[c]};
            SCOPED_TRACE("target " + std::to_string(target) + ", channel " + std::to_string(c));
            const auto expect_mean = [&](const Mean& mean, double expected, const char* what) {
                if (expected * kFlights >= 100) {
                    EXPECT_LT(mean.z(expected, 2e-4), kSigmas)
                        << what << ": " << mean.mean() << ", not " << expected << ", error " << mean.error();
                }
            };
            expect_mean(flights.passed[c], scale * truth.transmittance[c], "passed");
            expect_mean(flights.emitted[c], scale * truth.emitted[c], "emitted");
            for (int b = 0; b < kBins; ++b)
                expect_mean(flights.scattered[c][b], scale * truth.scattered[c][static_cast<std::size_t>(b)],
                            "scattered");
        }
    }
}

TEST(Nds, ReachesItsTargetInHomogeneousMedia) {
    for (const double depth : {1e-6, 1e-3, 0.1, 1.0, 4.0}) {
        for (const float target : {0.01f, 0.5f, 0.9f, 0.999f}) {
            Line line({{0, 0, 0}, {0, 0, 1}, 0, 2});
            line.add(Rgb(static_cast<float>(depth) / 2), Rgb(0), 0, 2);
            const Flights flights(line, nds_settings(false, false), guide_to(target), 20000);
            // Less than delta tracking's probability is out of its reach.
            const double expected = std::max(double{target}, -std::expm1(-depth));
            if (expected * 20000 >= 50) {
                EXPECT_LT(flights.scatters.z(expected), kSigmas)
                    << "depth " << depth << ", target " << target << ": " << flights.scatters.mean();
            }
            // Rounding of the depth beyond the segment, which is less than the depth by (1 - target).
            EXPECT_LT(flights.passed[0].z(std::exp(-depth), 1e-3), kSigmas)
                << "depth " << depth << ", target " << target << ": " << flights.passed[0].mean();
        }
    }
}

TEST(Nds, FallsShortWhereMajorantsAreLoose) {
    Line line = grid_line(spiky, Rgb(0.02f), Rgb(0));
    const VspGuide guide = guide_to(0.9f);
    const Flights loose(line, nds_settings(false, true), guide, 20000);
    EXPECT_LT(loose.scatters.mean(), 0.3) << "of a target of 0.9";
    EXPECT_GT(loose.scatters.mean(), -std::expm1(-Profile(line, 0, 50, 0).tau.back()));
}

// A guide that knows the transmittance gives NDS+ more than NDS, and less than asked for.
TEST(Nds, PlusRaisesTheProbabilityFurther) {
    Line line = grid_line(noisy, Rgb(0.01f), Rgb(0));
    VspGuide guide = guide_to(0.8f);
    guide.transmittance = static_cast<float>(Profile(line, 0, 50, 0).transmittance());
    const Flights nds(line, nds_settings(false, true), guide, 20000);
    const Flights plus(line, nds_settings(true, true), guide, 20000);
    EXPECT_GT(plus.scatters.mean(), nds.scatters.mean() + 0.05);
    EXPECT_GT(plus.scatters.mean(), 0.5);
}

TEST(Nds, EndsWithFiniteThroughputAtTheEndsOfTheNumberRange) {
    const Field field = field_of(kVoxels, noisy);
    for (const bool plus : {false, true}) {
        for (const float sigma : {1e-44f, 1e-40f, 1e-38f, 1e-30f, 1e-12f, 1.0f, 1e6f}) {
            for (const float target : {kLowestVsp, 0.5f, kHighestVsp}) {
                Line line(slanted());
                line.add(Rgb(sigma), Rgb(0), 0, 50, field);
                line.add(Rgb(sigma), Rgb(0), 0, 50);
                VspGuide guide = guide_to(target);
                guide.transmittance = target;
                TrackingScratch scratch;
                Counters counters;
                Rng rng(163);
                for (int n = 0; n < 200; ++n) {
                    Rgb beta(1);
                    const Flight f = nds_flight(line.segment, scratch, nds_settings(plus, false), guide, beta,
                                                rng, counters);
                    ASSERT_TRUE(is_finite(beta) && is_finite(f.emitted))
                        << "sigma 1e" << std::log10(sigma) << ", target " << target << ": " << beta.x;
                }
            }
        }
    }
}

TEST(Nds, LeavesAnEndlessMediumInTheChannelsItDoesNotTouch) {
    for (const bool plus : {false, true}) {
        for (const Rgb sigma : {Rgb(0.01f, 0.02f, 0), Rgb(0, 0, 0.3f)}) {
            Line line({{0, 0, 0}, {0, 0, 1}, 0, kInfinity});
            line.add(sigma * 0.5f, sigma * 0.5f, 0, kInfinity);
            line.media[0].emission = sigma;
            line.add(Rgb(0.1f), Rgb(0.1f), 3, 8);
            const Flights flights(line, nds_settings(plus, false), guide_to(0.7f), 20000);
            for (int c = 0; c < 3; ++c) {
                EXPECT_LT(flights.passed[c].z(sigma[c] > 0 ? 0 : std::exp(-1.0)), kSigmas)
                    << flights.passed[c].mean();
            }
        }
    }
}

}  // namespace
}  // namespace nephele::test
