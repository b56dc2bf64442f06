// SPDX-License-Identifier: GPL-3.0-or-later
// Streams at the ends of the number range: picks among candidates follow their weights, walks end in bounded
// time, and nothing becomes infinite or NaN.
#include <gtest/gtest.h>

#include "cell_counts.h"
#include "guiding_fixtures.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

bool is_sound(const Stream& s) {
    const VspWeights& w = s.weights;
    return is_finite(s.volume) && is_finite(s.surface) && is_finite(s.emitted) && is_finite(s.albedo) &&
           std::isfinite(w.volume) && std::isfinite(w.surface) && w.passing_share >= 0 &&
           w.passing_share <= 1 && w.empty >= 0 && w.empty <= 1 && std::isfinite(s.t) &&
           min_component(s.volume) >= 0 && min_component(s.surface) >= 0;
}

// A stack of slabs, each one candidate in closed form: the weights are known, and the picks follow them.
TEST(StreamPicks, FollowTheWeights) {
    Line line({{0, 0, 0}, {0, 0, 1}, 0, 20});
    Rng rng(113);
    for (int i = 0; i < 20; ++i) {
        const auto t = static_cast<float>(i);
        const float s = i % 7 == 3 ? 0 : 0.3f * rng.next();
        line.add({s, s * rng.next(), s * 0.5f}, {0.05f, 0.1f * rng.next(), 0}, t, t + 0.8f);
    }
    std::vector<double> probabilities(20);
    double sum = 0;
    for (int c = 0; c < 3; ++c) {
        const Profile truth(line, 0, 20, c);
        for (int i = 0; i < 20; ++i) {
            const double part = truth.at(truth.scattered, i + 1) - truth.at(truth.scattered, i);
            probabilities[static_cast<std::size_t>(i)] += part;
            sum += part;
        }
    }
    for (double& p : probabilities)
        p /= sum;
    Walker walker(line.segment, vsp_settings(Control::conditional), VspGuide(), nullptr, 127);
    std::vector<std::uint64_t> counts(20);
    constexpr int kStreams = 100000;
    for (int n = 0; n < kStreams; ++n) {
        const Stream s = walker.walk();
        ASSERT_NEAR(s.weights.volume, sum / 3, 2e-4 * sum);
        ++counts[static_cast<std::size_t>(s.t)];
    }
    for (std::size_t i = 0; i < 20; ++i) {
        if (i % 7 == 3) {
            EXPECT_EQ(counts[i], 0u) << "a slab that does not scatter was picked";
        }
    }
    EXPECT_GT(chi_square_p(counts, probabilities, kStreams), kFalseAlarm);
}

TEST(StreamExtremes, WithoutCandidatesPass) {
    Line empty(slanted()), absorbing(slanted());
    empty.add(Rgb(1), Rgb(0), 0, 50, field_of(8, [](int, int, int) { return 0.0f; }));
    absorbing.add(Rgb(0), {0.1f, 0.01f, 0}, 0, 50, field_of(kVoxels, bumps));
    absorbing.add(Rgb(0), Rgb(0.01f), 0, 50);
    const LightSet lamps = lamps_along(slanted(), {{20, 0.5f}, {10, 0}});
    for (const Line* line : {&empty, &absorbing}) {
        for (const Control control : {Control::exact, Control::conditional}) {
            for (const LightSet* lights : {static_cast<const LightSet*>(nullptr), &lamps}) {
                Walker walker(line->segment, vsp_settings(control, 0.75f), guide_to(0.999f), lights, 131);
                for (int n = 0; n < 500; ++n) {
                    const Stream s = walker.walk();
                    ASSERT_TRUE(is_sound(s));
                    ASSERT_EQ(s.weights.volume, 0);
                    ASSERT_EQ(walker.probability(s), 0);
                    ASSERT_TRUE(walker.scratch.shares.empty());
                }
            }
        }
    }
}

/// Walks streams whose beta is dim and checks them; returns lookups per stream.
double checked_lookups(const Line& line, const Settings& settings, const VspGuide& guide,
                       const LightSet* lights, int n, Rgb beta = Rgb(1)) {
    Walker walker(line.segment, settings, guide, lights, 137);
    for (int i = 0; i < n; ++i) {
        const Stream s = walker.walk(beta);
        EXPECT_TRUE(is_sound(s)) << s.volume.x << " " << s.surface.x << " " << s.weights.volume;
        const float p = walker.probability(s);
        EXPECT_TRUE(p >= 0 && p <= 1) << p;
        if (testing::Test::HasFailure())
            break;
    }
    return static_cast<double>(walker.counters.density_lookups) / n;
}

std::vector<VspGuide> extreme_guides() {
    return {VspGuide(), guide_to(kLowestVsp, 1e-6f), guide_to(kHighestVsp, 1e6f), guide_to(0.5f, 1e-30f),
            guide_of(1, 0.02f, 0.9f, 1e-3f)};
}

class Extreme : public testing::TestWithParam<std::tuple<Control, bool>> {
  protected:
    Settings settings = vsp_settings(std::get<0>(GetParam()), 0.75f);
    LightSet lamps = lamps_along(slanted(), {{21, 0.3f}, {33, 0}, {0, 0}, {1e6f, 10}});
    const LightSet* lights = std::get<1>(GetParam()) ? &lamps : nullptr;
};
INSTANTIATE_TEST_SUITE_P(
    Ways, Extreme, testing::Combine(testing::Values(Control::exact, Control::conditional), testing::Bool()),
    [](const auto& test) {
        return std::string(std::get<0>(test.param) == Control::exact ? "exact" : "conditional") +
               (std::get<1>(test.param) ? "_lamps" : "");
    });

TEST_P(Extreme, CoefficientsOfConstantMediaStaySound) {
    for (const float length : {1e-20f, 1e-3f, 50.0f, 1e20f, kInfinity}) {
        for (const float sigma : {1e-40f, 1e-30f, 1e-6f, 1.0f, 1e6f, 1e30f}) {
            for (const Rgb colour : {Rgb(1), Rgb(1, 0, 1e-6f), Rgb(1e-30f, 1, 0)}) {
                for (const Rgb absorption : {Rgb(0), Rgb(1), Rgb(0, 1, 1e6f)}) {
                    Ray ray = slanted();
                    ray.t_max = length;
                    Line line(ray);
                    line.add(colour * sigma, absorption * std::min(sigma, 1e24f), 0, length);
                    line.add(Rgb(0), {0, 0, 3}, 0, std::min(length, 1.0f));
                    SCOPED_TRACE("length " + std::to_string(length) + ", sigma " + std::to_string(sigma));
                    for (const Rgb beta : {Rgb(1), Rgb(1e-38f), Rgb(0, 0, 1)})
                        checked_lookups(line, settings, VspGuide(), lights, 20, beta);
                    if (HasFailure())
                        return;
                }
            }
        }
    }
}

// Down to denormals, which the rims of simulated smoke hold: the majorants cannot be raised enough there.
TEST_P(Extreme, DensitiesOfGridsStaySound) {
    const Field field = field_of(kVoxels, noisy);
    for (const float sigma : {1e-44f, 1e-40f, 1e-38f, 1e-30f, 1e-12f, 1.0f, 1e6f}) {
        for (const Rgb colour : {Rgb(1), Rgb(1, 1e-6f, 0.5f)}) {
            Line line(slanted());
            line.add(colour * sigma, Rgb(0.5f * std::min(sigma, 1e24f)), 0, 50, field);
            line.media[0].emission = {1, 2, 3};
            SCOPED_TRACE("sigma " + std::to_string(std::log10(double{sigma})));
            for (const VspGuide& guide : extreme_guides()) {
                if (guide.majorant_depth > 0 && guide.majorant_depth < 1e-3f && sigma > 1e-3f)
                    continue;  // see LookupsAreBounded
                for (const Rgb beta : {Rgb(1), Rgb(1e-37f)})
                    checked_lookups(line, settings, guide, lights, 20, beta);
            }
            if (HasFailure())
                return;
        }
    }
}

TEST_P(Extreme, LookupsAreBoundedInDenseMedia) {
    const Field field =
        field_of(64, [](int i, int, int) { return 0.7f + 0.3f * std::sin(0.5f * static_cast<float>(i)); });
    const auto lookups = [&](float sigma, const VspGuide& guide) {
        Line line(slanted());
        line.add(Rgb(sigma), Rgb(0.1f * sigma), 5, 40, field);
        return checked_lookups(line, settings, guide, lights, 300);
    };
    for (const VspGuide& guide : {VspGuide(), guide_to(kLowestVsp), guide_to(kHighestVsp)})
        EXPECT_LT(lookups(3e4f, guide), 2 * lookups(3, guide) + 5) << "target " << guide.target;
}

// Where a pixel's mean says that media are thin, but this ray meets a dense one.
TEST_P(Extreme, LookupsAreBoundedWhereTheLearnedDepthIsFarOff) {
    for (const float learned : {1e-6f, 1e-3f, 0.1f}) {
        Line line(slanted());
        line.add(Rgb(1), Rgb(0.1f), 0, 50, field_of(kVoxels, noisy));
        EXPECT_LT(checked_lookups(line, settings, guide_to(0.9f, learned), lights, 5), 3000)
            << "learned " << learned;
    }
}

}  // namespace
}  // namespace nephele::test
