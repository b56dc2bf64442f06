// SPDX-License-Identifier: GPL-3.0-or-later
// What the decision costs: with nested estimates free of noise, conditional control adds no variance to the
// stream's own V f_v + T f_s, and is at or below delta tracking and exact control (media after the plain
// numeric model of the design).
#include <gtest/gtest.h>

#include "guiding_fixtures.h"
#include "tracking/free_flight.h"
#include "tracking/nds.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

double variance_of(const Mean& mean, int n) {
    return mean.error() * mean.error() * n;
}

struct Scene1d {
    const char* name;
    float density, volume, surface;  ///< density: of the bumps; radiances of either branch
};
/// Thin, medium and dense bumps of different radiances behind and inside.
const Scene1d kScenes[] = {{"thin", 0.005f, 1, 0.5f},
                           {"bumps", 0.2f, 1.5f, 3},
                           {"dense", 8, 1.5f, 50},
                           {"bright", 0.05f, 20, 0.5f},
                           {"dark", 0.05f, 0.1f, 2}};

class VarianceIn : public testing::TestWithParam<Scene1d> {
  protected:
    static constexpr int kStreams = 30000;
    Scene1d scene = GetParam();
    Line line = grid_line(bumps, Rgb(0.9f * scene.density), Rgb(0.1f * scene.density));
    double unit = Profile(line, 0, 50, 0).scattered.back();
    double passing = Profile(line, 0, 50, 0).transmittance();
    float majorant_depth() const {
        TrackingScratch scratch;
        return detail::majorant_depth(line.segment, scratch, false);
    }
    VspGuide guide() const {
        const double v = double{scene.volume} * unit, s = double{scene.surface} * passing;
        return guide_of(scene.volume, scene.surface,
                        std::clamp(static_cast<float>(v / (v + s)), kLowestVsp, kHighestVsp));
    }
};
INSTANTIATE_TEST_SUITE_P(Scenes, VarianceIn, testing::ValuesIn(kScenes),
                         [](const auto& test) { return test.param.name; });

TEST_P(VarianceIn, ConditionalDecisionsAddNone) {
    Walker walker(line.segment, vsp_settings(Control::conditional), guide(), nullptr, 197);
    Mean decided, both;
    for (int n = 0; n < kStreams; ++n) {
        const Stream s = walker.walk();
        const float p = walker.probability(s);
        const double volume = double{scene.volume} * double{s.volume.x},
                     surface = double{scene.surface} * double{s.surface.x};
        const double value = walker.rng().next() < p ? volume / double{p} : surface / (1 - double{p});
        const double rounding = 1e-5 + 1e-7 / (1 - double{p});
        ASSERT_NEAR(value, volume + surface, rounding * (volume + surface)) << "p " << p;
        decided.add(value);
        both.add(volume + surface);
    }
    const double expected = double{scene.volume} * unit + double{scene.surface} * passing;
    EXPECT_LT(decided.z(expected, 1e-4), kSigmas) << decided.mean() << ", not " << expected;
    EXPECT_NEAR(variance_of(decided, kStreams), variance_of(both, kStreams),
                1e-3 * variance_of(both, kStreams));
}

TEST_P(VarianceIn, ConditionalControlIsNotAboveTheOthers) {
    const auto of_control = [&](Control control, float defensive) {
        VspGuide guided = guide();
        // As many candidates under conditional control as under exact.
        const float scale = rate_scale(vsp_settings(Control::exact), guided, majorant_depth());
        guided.majorant_depth = std::min(depth_to_reach(guided.target), kMostDepth) / scale;
        Walker walker(line.segment, vsp_settings(control, defensive), guided, nullptr, 199);
        Mean mean;
        for (int n = 0; n < kStreams; ++n) {
            const Stream s = walker.walk();
            const float p = walker.probability(s);
            mean.add(walker.rng().next() < p ? double{scene.volume} * double{s.volume.x} / double{p}
                                             : double{scene.surface} * double{s.surface.x} / (1 - double{p}));
        }
        return variance_of(mean, kStreams);
    };
    Mean delta;
    TrackingScratch scratch;
    Counters counters;
    Rng rng(211);
    for (int n = 0; n < kStreams; ++n) {
        Rgb beta(1);
        const Flight f = sample_flight(line.segment, scratch, Settings(), beta, rng, counters);
        delta.add(f.event == Flight::Event::scattered ? double{scene.volume} * double{beta.x}
                  : f.event == Flight::Event::passed  ? double{scene.surface} * double{beta.x}
                                                      : 0);
    }
    const double conditional = of_control(Control::conditional, 1);
    // Noise of variances of 30000 values, and what Russian roulette adds where there is none.
    constexpr double kNoise = 1.1, kLeast = 1e-4;
    EXPECT_LT(conditional, kNoise * variance_of(delta, kStreams) + kLeast);
    EXPECT_LT(conditional, kNoise * of_control(Control::exact, 1) + kLeast);
    EXPECT_LT(conditional, kNoise * of_control(Control::exact, 0.75f) + kLeast);
}

}  // namespace
}  // namespace nephele::test
