// SPDX-License-Identifier: GPL-3.0-or-later
// Free flights against closed forms and fine quadrature, in homogeneous, heterogeneous, chromatic and
// overlapping media, with local and global majorants, weighted and analog. See kSigmas for false alarms.
#include <gtest/gtest.h>

#include <array>
#include <string>

#include "tracking/free_flight.h"
#include "tracking/transmittance.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

/// Cases without programs, whose media can be made grey.
std::vector<Case> direct_cases() {
    std::vector<Case> out;
    for (const Case& c : cases()) {
        const Line line = c.line();
        if (std::none_of(line.media.begin(), line.media.end(), [](const Medium& m) { return m.program; }))
            out.push_back(c);
    }
    return out;
}

struct Tracker {
    Settings::Tracking tracking;
    bool global;
    Settings settings() const { return settings_of(tracking, global); }
};
constexpr auto kWeighted = Settings::Tracking::weighted_delta;
constexpr auto kAnalog = Settings::Tracking::delta;
constexpr auto kDecomposition = Settings::Tracking::decomposition;

class TrackingIn : public testing::TestWithParam<std::tuple<Case, Tracker>> {
  protected:
    Line line = std::get<0>(GetParam()).line();
    Tracker tracker = std::get<1>(GetParam());
};

std::string name_of(const testing::TestParamInfo<std::tuple<Case, Tracker>>& test) {
    const Tracker t = std::get<1>(test.param);
    const char* method = t.tracking == kAnalog     ? "_analog"
                         : t.tracking == kWeighted ? "_weighted"
                                                   : "_decomposition";
    return std::get<0>(test.param).name + method + (t.global ? "_global" : "_local");
}
constexpr Tracker kTrackers[] = {{kWeighted, false},     {kWeighted, true}, {kDecomposition, false},
                                 {kDecomposition, true}, {kAnalog, false},  {kAnalog, true}};
INSTANTIATE_TEST_SUITE_P(Media, TrackingIn,
                         testing::Combine(testing::ValuesIn(cases()), testing::ValuesIn(kTrackers)), name_of);

TEST_P(TrackingIn, FlightsCarryTransmittanceInScatteringAndEmission) {
    constexpr int kBins = 8, kFlights = 60000;
    const Rgb start{1, 0.5f, 0.8f};
    line.media.front().emission = {0.5f, 2, 0.1f};
    Mean passed[3], scattered[3][kBins], emitted[3];
    TrackingScratch scratch;
    Counters counters;
    Rng rng(17);
    for (int n = 0; n < kFlights; ++n) {
        Rgb beta = start;
        const Flight f = sample_flight(line.segment, scratch, tracker.settings(), beta, rng, counters);
        const bool real = f.event == Flight::Event::scattered;
        const int bin = real ? std::min(static_cast<int>(f.t / 50 * kBins), kBins - 1) : -1;
        for (int c = 0; c < 3; ++c) {
            passed[c].add(f.event == Flight::Event::passed ? double{beta[c]} : 0);
            emitted[c].add(double{f.emitted[c]});
            for (int b = 0; b < kBins; ++b)
                scattered[c][b].add(b == bin ? double{beta[c]} : 0);
        }
    }
    for (int c = 0; c < 3; ++c) {
        const Profile truth(line, 0, 50, c);
        const double scale = double{start[c]};
        if (truth.transmittance() * kFlights > 50) {
            EXPECT_LT(passed[c].z(scale * truth.transmittance()), kSigmas)
                << "channel " << c << ": " << passed[c].mean() << ", not " << scale * truth.transmittance();
        }
        EXPECT_LT(emitted[c].z(scale * truth.emitted.back(), 1e-4), kSigmas)
            << "channel " << c << ": " << emitted[c].mean() << ", not " << scale * truth.emitted.back();
        for (int b = 0; b < kBins; ++b) {
            const double expected = scale * (truth.at(truth.scattered, 50.0 * (b + 1) / kBins) -
                                             truth.at(truth.scattered, 50.0 * b / kBins));
            if (expected * kFlights < 50)
                continue;  // too few for a normal distribution
            EXPECT_LT(scattered[c][b].z(expected, 1e-4), kSigmas)
                << "channel " << c << " bin " << b << ": " << scattered[c][b].mean() << ", not " << expected;
        }
    }
}

class DistancesIn : public TrackingIn {};
INSTANTIATE_TEST_SUITE_P(Media, DistancesIn,
                         testing::Combine(testing::ValuesIn(direct_cases()), testing::ValuesIn(kTrackers)),
                         name_of);

TEST_P(DistancesIn, HaveTheRightDistribution) {
    constexpr int kFlights = 100000, kCells = 40;
    for (Medium& m : line.media) {  // grey and white: flights are then analog, with throughput 1
        m.sigma_t = m.sigma_s = Rgb(max_component(m.sigma_t));
        m.emission = Rgb(0);
    }
    const Profile truth(line, 0, 50, 0);
    std::vector<std::uint64_t> counts(kCells);
    std::vector<double> probabilities(kCells);
    for (int b = 0; b < kCells; ++b) {
        probabilities[static_cast<std::size_t>(b)] = std::exp(-truth.at(truth.tau, 50.0 * b / kCells)) -
                                                     std::exp(-truth.at(truth.tau, 50.0 * (b + 1) / kCells));
    }
    TrackingScratch scratch;
    Counters counters;
    Rng rng(23);
    for (int n = 0; n < kFlights; ++n) {
        Rgb beta(1);
        const Flight f = sample_flight(line.segment, scratch, tracker.settings(), beta, rng, counters);
        ASSERT_NEAR(beta.x, 1, 1e-4);
        if (f.event == Flight::Event::scattered)
            ++counts[std::min(static_cast<std::size_t>(f.t / 50 * kCells), std::size_t{kCells - 1})];
    }
    EXPECT_GT(chi_square_p(counts, probabilities, kFlights), kFalseAlarm);
}

TEST_P(TrackingIn, SharesSayWhichMediumScattered) {
    constexpr int kFlights = 40000;
    float number = 0;
    for (Medium& m : line.media)
        m.phase.p0 = m.program ? kProgramG : number++;  // tells whose a share is
    const auto medium_of = [&](const ScatterShare& share) {
        const auto found = std::find_if(line.media.begin(), line.media.end(),
                                        [&](const Medium& m) { return m.phase.p0 == share.phase.p0; });
        return static_cast<std::size_t>(found - line.media.begin());
    };
    std::vector<std::array<Mean, 3>> by_medium(line.media.size());
    TrackingScratch scratch;
    Counters counters;
    Rng rng(59);
    for (int n = 0; n < kFlights; ++n) {
        Rgb beta(1);
        const Flight f = sample_flight(line.segment, scratch, tracker.settings(), beta, rng, counters);
        std::vector<Rgb> scattered(line.media.size());
        if (f.event == Flight::Event::scattered) {
            Rgb total;
            for (const ScatterShare& share : scratch.shares)
                total += share.sigma_s;
            for (const ScatterShare& share : scratch.shares)
                scattered[medium_of(share)] += beta * share.sigma_s / max(total, Rgb(1e-30f));
        }
        for (std::size_t m = 0; m < scattered.size(); ++m) {
            for (int c = 0; c < 3; ++c)
                by_medium[m][static_cast<std::size_t>(c)].add(double{scattered[m][c]});
        }
    }
    for (std::size_t m = 0; m < line.media.size(); ++m) {
        line.scatters = &line.media[m];
        for (int c = 0; c < 3; ++c) {
            const double expected = Profile(line, 0, 50, c, 20000).scattered.back();
            if (expected * kFlights < 50)
                continue;
            const Mean& mean = by_medium[m][static_cast<std::size_t>(c)];
            EXPECT_LT(mean.z(expected, 1e-4), kSigmas)
                << "medium " << m << " channel " << c << ": " << mean.mean() << ", not " << expected;
        }
    }
}

TEST(Tracking, IsRightFromOneMillionthToAMillionMeanFreePaths) {
    for (const double tau : {1e-6, 1e-4, 1e-2, 1.0, 10.0, 1e3, 1e6}) {
        Line line({{0, 0, 0}, {0, 0, 1}, 0, 2});
        line.add(Rgb(static_cast<float>(tau / 2)), Rgb(0), 0, 2);
        Counters counters;
        Rng rng(31);
        EXPECT_NEAR(estimate_transmittance(line.segment, Settings(), rng, counters).x, std::exp(-tau), 1e-7);
        TrackingScratch scratch;
        const int flights = tau < 1e-5 ? 20000000 : tau < 1e-3 ? 2000000 : 50000;
        Mean hit, depth;
        for (int n = 0; n < flights; ++n) {
            Rgb beta(1);
            const Flight f = sample_flight(line.segment, scratch, Settings(), beta, rng, counters);
            hit.add(f.event == Flight::Event::scattered ? 1 : 0);
            if (f.event == Flight::Event::scattered)
                depth.add(double{f.t} * tau / 2);
        }
        EXPECT_LT(hit.z(-std::expm1(-tau)), kSigmas) << "tau " << tau << ": " << hit.mean();
        if (tau >= 1) {  // the mean of a truncated exponential
            const double expected = 1 - tau * std::exp(-tau) / -std::expm1(-tau);
            EXPECT_LT(depth.z(expected, 1e-5), kSigmas) << "tau " << tau << ": " << depth.mean();
        }
    }
}

TEST(Tracking, FlightsLeaveAnEndlessMediumInTheChannelsItDoesNotTouch) {
    for (const float end : {kInfinity, 1e30f}) {
        for (const Rgb sigma_a : {Rgb(0.01f, 0.02f, 0), Rgb(0, 0, 0.3f), Rgb(1e-4f, 0, 5)}) {
            Line line({{0, 0, 0}, {0, 0, 1}, 0, end});
            line.add(sigma_a * 0.5f, sigma_a * 0.5f, 0, end);
            line.add(Rgb(0.1f), Rgb(0.1f), 3, 8);
            Mean passed[3];
            TrackingScratch scratch;
            Counters counters;
            Rng rng(41);
            for (int n = 0; n < 20000; ++n) {
                Rgb beta(1);
                const Flight f = sample_flight(line.segment, scratch, Settings(), beta, rng, counters);
                for (int c = 0; c < 3; ++c)
                    passed[c].add(f.event == Flight::Event::passed ? double{beta[c]} : 0);
            }
            for (int c = 0; c < 3; ++c)
                EXPECT_LT(passed[c].z(sigma_a[c] > 0 ? 0 : std::exp(-1.0)), kSigmas) << passed[c].mean();
        }
    }
}

TEST(Tracking, EmissionByAGridIsIntegratedAlongTheRay) {
    for (const bool global : {false, true}) {
        Line line = grid_line(bumps, Rgb(0.1f), Rgb(0.1f));
        Medium& fire = line.add(Rgb(0), Rgb(0), 0, 50, field_of(kVoxels, noisy));
        fire.emission = {1, 0.5f, 2};
        fire.density_scales_emission = true;
        Mean emitted[3];
        TrackingScratch scratch;
        Counters counters;
        Rng rng(43);
        for (int n = 0; n < 40000; ++n) {
            Rgb beta(1);
            const Flight f =
                sample_flight(line.segment, scratch, settings_of(kWeighted, global), beta, rng, counters);
            for (int c = 0; c < 3; ++c)
                emitted[c].add(double{f.emitted[c]});
        }
        for (int c = 0; c < 3; ++c) {
            const double expected = Profile(line, 0, 50, c).emitted.back();
            EXPECT_LT(emitted[c].z(expected, 1e-4), kSigmas) << emitted[c].mean() << ", not " << expected;
        }
    }
}

}  // namespace
}  // namespace nephele::test
