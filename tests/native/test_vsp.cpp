// SPDX-License-Identifier: GPL-3.0-or-later
// The volume scattering probability that a segment gets is the one asked for, from thin to dense, for every
// target; and where a stream cannot reach it, by how much it falls short. Binomial tests; false alarms as
// with kSigmas.
#include "tracking/vsp.h"

#include <gtest/gtest.h>

#include "guiding_fixtures.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

constexpr float kTargets[] = {0.001f, 0.01f, 0.1f, 0.5f, 0.9f, 0.99f, 0.999f};

/// What streams of one medium decided.
struct Achieved {
    int streams = 0, empty = 0, opaque = 0;  ///< opaque: nothing passes, so that the volume has to be taken
    int scattered = 0, scattered_where_open = 0;

    static Achieved of(Walker& walker, int n) {
        Achieved out;
        for (out.streams = 0; out.streams < n; ++out.streams) {
            const Stream s = walker.walk();
            const bool scatters = walker.rng().next() < walker.probability(s);
            const bool opaque = is_zero(s.surface);
            out.empty += s.weights.volume == 0;
            out.opaque += opaque;
            out.scattered += scatters;
            out.scattered_where_open += scatters && !opaque;
        }
        return out;
    }
    /// Deviation of `count` from a binomial with probability p, in standard deviations.
    double z(int count, double p) const {
        const double n = streams;
        return std::fabs(count - n * p) / std::sqrt(std::max(n * p * (1 - p), 1.0));
    }
};

/// Smooth and nowhere empty, so that every candidate has weight.
float ripples(int i, int j, int k) {
    return static_cast<float>(0.6 + 0.35 * std::sin(0.7 * i + 0.2 * j) * std::cos(0.3 * k));
}
/// A wall of 400 times the density around it.
float wall(int i, int, int) {
    return i == 20 ? 1.0f : 0.0025f;
}

Line inner_line(const Voxels& voxels, Rgb albedo, Rgb tint) {
    Line line(slanted());
    // Inside the grid, where its density does not fade out.
    line.add(albedo * tint, (Rgb(1) - albedo) * tint, 5, 40, field_of(64, voxels));
    return line;
}
std::vector<Case> full_cases() {
    return {
        {"homogeneous",
         [] {
             Line line(slanted());
             line.add(Rgb(0.7f), Rgb(0.3f), 5, 40);
             return line;
         }},
        {"homogeneous_chromatic",
         [] {
             Line line(slanted());
             line.add({0.1f, 0.5f, 1}, {0.2f, 0, 0.1f}, 5, 40);
             return line;
         }},
        {"grid", [] { return inner_line(ripples, Rgb(0.9f), Rgb(1)); }},
        {"chromatic",
         [] {
             return inner_line(ripples, {0.9f, 0.5f, 0.2f}, {1, 0.5f, 0.3f});
         }},
        {"spiky", [] { return inner_line(wall, Rgb(1), Rgb(1)); }},
        {"overlapping",
         [] {
             Line line = inner_line(ripples, Rgb(0.9f), Rgb(1));
             line.add(Rgb(0.2f), Rgb(0.1f), 0, 20);
             line.add({0.2f, 0.4f, 0.8f}, Rgb(0), 10, 30, field_of(64, ripples));
             return line;
         }},
    };
}

/// Makes the mean optical depth of channel 0 this.
void set_depth(Line& line, double depth) {
    const double now = Profile(line, 0, 50, 0, 4000).tau.back();
    for (Medium& m : line.media) {
        m.sigma_s *= static_cast<float>(depth / now);
        m.sigma_t *= static_cast<float>(depth / now);
    }
}

class VspIn : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Media, VspIn, testing::ValuesIn(full_cases()),
                         [](const auto& test) { return test.param.name; });

// Beyond some ten mean free paths streams end by Russian roulette, with nothing that passes: these have to
// scatter, and the target is what the others keep to. In a closed form this starts where exp(-depth) is 0 in
// floats, at 104.
TEST_P(VspIn, ExactControlAchievesItsTargetFromOneMillionthToAMillionMeanFreePaths) {
    for (const double depth : {1e-6, 1e-4, 1e-2, 0.3, 1.0, 3.0, 30.0, 1e3, 1e6}) {
        Line line = GetParam().line();
        set_depth(line, depth);
        for (const float target : kTargets) {
            SCOPED_TRACE("depth " + std::to_string(depth) + ", target " + std::to_string(target));
            Walker walker(line.segment, vsp_settings(Control::exact), guide_to(target), nullptr, 97);
            const int streams = depth > 3 ? 500 : 3000;
            const Achieved a = Achieved::of(walker, streams);
            const double open = 1 - static_cast<double>(a.opaque) / streams;
            if (depth < 5) {
                EXPECT_LT(a.z(a.scattered, double{target}), kSigmas) << a.opaque << " streams ended";
            }
            EXPECT_LT(a.z(a.scattered_where_open, double{target} * open), kSigmas)
                << a.scattered_where_open << " of " << streams << ", open " << open;
            EXPECT_EQ(a.scattered, a.scattered_where_open + a.opaque);
        }
    }
}

// The same with P' = target: what empty streams lose is missing, and the test above would see it.
TEST(Vsp, TargetsWithoutCompensationForEmptyStreamsAreMissed) {
    Line line = full_cases()[2].line();
    set_depth(line, 0.01);
    const VspGuide guide = guide_to(0.9f);
    const Settings settings = vsp_settings(Control::exact);
    Walker walker(line.segment, settings, guide, nullptr, 101);
    Achieved right, wrong;
    for (; right.streams < 20000; ++right.streams) {
        Stream s = walker.walk();
        const float u = walker.rng().next();
        right.scattered += u < walker.probability(s);
        s.weights.empty = 0;
        wrong.scattered += u < walker.probability(s);
    }
    EXPECT_LT(right.z(right.scattered, 0.9), kSigmas);
    EXPECT_GT(right.z(wrong.scattered, 0.9), 3 * kSigmas);
}

// Candidates in empty space have no weight, and a stream of these has to pass: the target then is an upper
// bound, reached in the share of the streams that meet something.
TEST(Vsp, LooseMajorantsFallShortByTheShareOfStreamsThatMeetNothing) {
    for (const float target : {0.1f, 0.9f}) {
        Line line(slanted());
        line.add(Rgb(0.02f), Rgb(0), 5, 40, field_of(64, spiky));
        Walker walker(line.segment, vsp_settings(Control::exact, 1, true), guide_to(target), nullptr, 103);
        line.media[0].sigma_s = Rgb(0.0005f);
        line.media[0].sigma_t = Rgb(0.0005f);
        Line holes(slanted());
        holes.add(Rgb(0.001f), Rgb(0), 5, 40,
                  field_of(64, [](int i, int, int) { return i == 20 ? 1.0f : 0; }));
        Walker through(holes.segment, vsp_settings(Control::exact, 1, true), guide_to(target), nullptr, 103);
        const Achieved full = Achieved::of(walker, 20000), holed = Achieved::of(through, 20000);
        EXPECT_LT(full.z(full.scattered, double{target}), kSigmas) << full.scattered;
        EXPECT_LT(holed.scattered, 20000 * double{target} * 0.5);
        EXPECT_GT(holed.scattered, 0);
    }
}

TEST(Vsp, DefensiveMixtureIsBetweenTargetAndDeltaTracking) {
    Line line(slanted());
    line.add(Rgb(0.02f), Rgb(0), 0, 50);
    const double delta = -std::expm1(-1.0);
    for (const float defensive : {0.0f, 0.25f, 0.75f, 1.0f}) {
        Walker walker(line.segment, vsp_settings(Control::exact, defensive), guide_to(0.1f), nullptr, 107);
        const Achieved a = Achieved::of(walker, 20000);
        EXPECT_LT(a.z(a.scattered, double{defensive} * 0.1 + (1 - double{defensive}) * delta), kSigmas);
    }
}

TEST(Vsp, ProbabilitiesAreWithinBoundsWhateverIsLearned) {
    const float values[] = {0, 1e-38f, 1e-20f, 1e-6f, 0.5f, 1, 1e6f, 1e30f};
    for (const Control control : {Control::exact, Control::conditional}) {
        for (const float defensive : {0.0f, 0.75f, 1.0f}) {
            for (const float volume : values) {
                for (const float surface : values) {
                    for (const float radiance : {1e-30f, 0.02f, 1.0f}) {
                        for (const float empty : {0.0f, 0.5f, 0.9999f}) {
                            for (const float target : kTargets) {
                                const VspWeights w{volume, surface, std::min(surface, 1.0f), empty};
                                const float p = volume_probability(vsp_settings(control, defensive),
                                                                   guide_of(radiance, 1, target), w);
                                ASSERT_TRUE(p >= 0 && p <= 1) << p;
                                if (volume == 0) {
                                    ASSERT_EQ(p, 0);
                                } else if (surface == 0) {
                                    ASSERT_EQ(p, 1);
                                }
                            }
                        }
                    }
                }
            }
        }
    }
}

// P = 1 with something that passes would lose it.
TEST(Vsp, StreamsThatLetSomethingPassKeepAChanceToPass) {
    for (const double depth : {1e-6, 1e-2, 1.0, 5.0}) {
        Line line = full_cases()[3].line();
        set_depth(line, depth);
        for (const float defensive : {0.75f, 1.0f}) {
            Walker walker(line.segment, vsp_settings(Control::exact, defensive), guide_to(kHighestVsp),
                          nullptr, 109);
            for (int n = 0; n < 2000; ++n) {
                const Stream s = walker.walk();
                if (!is_zero(s.surface)) {
                    ASSERT_LT(walker.probability(s), 1) << "depth " << depth;
                }
            }
        }
    }
}

}  // namespace
}  // namespace nephele::test
