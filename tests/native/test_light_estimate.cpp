// SPDX-License-Identifier: GPL-3.0-or-later
// The virtual density of candidates near lights: its integral, its inverse and its samples agree, near a
// lamp, far behind one, on a ray right through one and on endless rays.
#include "tracking/light_estimate.h"

#include <gtest/gtest.h>

#include "cell_counts.h"
#include "guiding_fixtures.h"

namespace nephele::test {
namespace {

const Ray kRay{{1, 2, 3}, {0, 0, 1}, 0, kInfinity};

struct LampAt {
    float lamp_t, beside, t0, t1;
};
const LampAt kSetups[] = {{10, 1, 0, 20},           {10, 0.01f, 0, 50},  {10, 0, 0, 30},
                          {10, 1, 0, kInfinity},    {10, 0, 2, 1000},    {-5, 0.5f, 0, 40},
                          {60, 0.5f, 0, 40},        {0, 0, 0, 10},       {10, 0, 0, 1e6f},
                          {10, 0.1f, 0, kInfinity}, {500, 3, 400, 1e30f}};

class LightEstimateOf : public testing::TestWithParam<LampAt> {
  protected:
    LampAt setup = GetParam();
    LightSet lamps = lamps_along(kRay, {{setup.lamp_t, setup.beside}});
    Rng rng{139};
    LightEstimate estimate{lamps, kRay, setup.t0, setup.t1, rng};
    /// Points along the part, dense around the lamp.
    std::vector<float> points() const {
        std::vector<float> out;
        // A lamp at the ray's start is so near that nearly all of its angle is close to it.
        for (int i = setup.lamp_t == 0 ? -72 : 0; i <= 24; ++i) {
            for (const float side : {-1.0f, 1.0f}) {
                const float t = setup.lamp_t + side * std::pow(10.0f, 0.25f * static_cast<float>(i) - 3);
                if (t > setup.t0 && t < setup.t1)
                    out.push_back(t);
            }
        }
        std::sort(out.begin(), out.end());
        return out;
    }
};
INSTANTIATE_TEST_SUITE_P(Lamps, LightEstimateOf, testing::ValuesIn(kSetups));

/// Integral of rate() by the midpoint rule in steps that grow with the distance to the lamp.
double integral(const LightEstimate& estimate, double a, double b) {
    constexpr int kSteps = 4000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i) {
        const double t = a + (b - a) * (i + 0.5) / kSteps;
        sum += double{estimate.rate(static_cast<float>(t))} * (b - a) / kSteps;
    }
    return sum;
}

// Between neighbouring points, however far from the lamp: the densities there weigh candidates against what
// is expected of pieces as short.
TEST_P(LightEstimateOf, RateIntegratesToWhatIsExpected) {
    const std::vector<float> t = points();
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
        if (t[i + 1] - t[i] < 1e-4f * std::fabs(t[i]))
            continue;  // floats are too coarse there
        const double expected = integral(estimate, double{t[i]}, double{t[i + 1]});
        EXPECT_NEAR(estimate.expected(t[i], t[i + 1]), expected, 2e-3 * expected + 1e-37)
            << "from " << t[i] << " to " << t[i + 1];
    }
}

TEST_P(LightEstimateOf, ExpectsTheSameOfTheWholePart) {
    EXPECT_NEAR(estimate.expected(setup.t0, setup.t1), 2, 2e-5);
}

TEST_P(LightEstimateOf, AdvanceInvertsExpected) {
    const std::vector<float> t = points();
    for (std::size_t i = 0; i + 1 < t.size(); ++i) {
        const float count = estimate.expected(t[i], t[i + 1]);
        const float there = estimate.advance(t[i], count);
        const float step = t[i + 1] - t[i];
        EXPECT_NEAR(there, t[i + 1], 1e-3f * step + 4e-7f * std::fabs(t[i + 1]))
            << "from " << t[i] << " by " << count;
    }
    EXPECT_GE(estimate.advance(setup.t0, 0), setup.t0);
    if (setup.t1 == kInfinity) {
        EXPECT_EQ(estimate.advance(setup.t0, 2.001f), kInfinity);
    }
}

TEST_P(LightEstimateOf, PlacesFollowTheDensity) {
    const std::vector<float> t = points();
    std::vector<double> probabilities;
    std::vector<std::uint64_t> counts(t.size() - 1);
    for (std::size_t i = 0; i + 1 < t.size(); ++i)
        probabilities.push_back(integral(estimate, double{t[i]}, double{t[i + 1]}) / 2);
    constexpr int kDraws = 100000;
    int outside = 0;
    for (int n = 0; n < kDraws; ++n) {
        const float x = estimate.advance(setup.t0, 2 * rng.next());
        const auto found = std::upper_bound(t.begin(), t.end(), x) - t.begin();
        if (found > 0 && found < static_cast<std::ptrdiff_t>(t.size()))
            ++counts[static_cast<std::size_t>(found) - 1];
        outside += x < setup.t0 - 1e-3f || !(x <= setup.t1 * 1.001f);
    }
    EXPECT_EQ(outside, 0);
    EXPECT_GT(chi_square_p(counts, probabilities, kDraws), kFalseAlarm);
}

TEST_P(LightEstimateOf, EstimatesArePositiveAndFinite) {
    std::vector<float> t = points();
    t.push_back(setup.t0);
    t.push_back(setup.lamp_t);
    t.push_back(1e30f);
    for (const float x : t) {
        EXPECT_GT(estimate.at(x), 0);
        EXPECT_TRUE(std::isfinite(estimate.at(x))) << x;
        EXPECT_TRUE(std::isfinite(estimate.rate(x))) << x;
    }
    EXPECT_GE(estimate.largest(), 1);
    EXPECT_TRUE(std::isfinite(estimate.largest()));
}

// A bright lamp where the ray starts: a headlamp at a pinhole camera.
TEST(LightEstimate, OfALampInTheCameraIsFinite) {
    const LightSet lamps = lamps_along(kRay, {{0, 0, 1e12f}, {30, 1, 100}});
    for (const float t0 : {0.0f, 1e-3f, 5.0f}) {
        Rng rng(149);
        for (int n = 0; n < 50; ++n) {
            const LightEstimate estimate(lamps, kRay, t0, 100, rng);
            EXPECT_TRUE(std::isfinite(estimate.largest()));
            for (const float t : {t0, 1.0f, 30.0f}) {
                EXPECT_TRUE(std::isfinite(estimate.at(t)) && estimate.at(t) > 0) << t;
                EXPECT_TRUE(std::isfinite(estimate.rate(t)) || t == 0) << t;
            }
        }
    }
}

// A thin slab far behind a lamp: the virtual density there is small and nearly constant, and what it says has
// to fit what it does.
TEST(LightEstimate, LeavesSlabsFarBehindALampUnbiased) {
    for (const float beside : {0.1f, 0.0f}) {
        const LightSet lamps = lamps_along(kRay, {{10, beside}});
        for (const float far : {100.0f, 1000.0f, 1e4f}) {
            Line line({kRay.o, kRay.d, 0, 2 * far});
            line.add(Rgb(0.01f / far), Rgb(0), 1, 2);
            line.add(Rgb(0.02f), Rgb(0), far, far + 1);
            Walker walker(line.segment, vsp_settings(Control::conditional), VspGuide(), &lamps, 151);
            Mean near, behind;
            for (int n = 0; n < 20000; ++n) {
                const Stream s = walker.walk();
                near.add(s.t < 3 ? double{s.volume.x} : 0);
                behind.add(s.t > 3 ? double{s.volume.x} : 0);
            }
            const double passes = std::exp(-0.01 / double{far});
            EXPECT_LT(behind.z(-passes * std::expm1(-0.02), 1e-3), kSigmas)
                << "far " << far << ", beside " << beside << ": " << behind.mean();
            EXPECT_LT(near.z(1 - passes, 1e-2), kSigmas) << near.mean();
        }
    }
}

}  // namespace
}  // namespace nephele::test
