// SPDX-License-Identifier: GPL-3.0-or-later
// Unbiasedness of resampled distances: the volume's throughput along the ray, the surface's and the emission
// of two-branch estimates against fine quadrature, in all media, under both controls, whatever the guides say
// and wherever lamps draw the candidates. See kSigmas for false alarms.
#include "tracking/stream.h"

#include <gtest/gtest.h>

#include "guiding_fixtures.h"
#include "tracking_cases.h"

namespace nephele::test {
namespace {

constexpr int kBins = 8;
constexpr double kEnd = 50;

/// Means of what streams bring, by the branch that is decided for (`decided`) and before any decision.
struct Brought {
    Mean passed[3], scattered[3][kBins], emitted[3], decided_passed[3], decided_scattered[3];
    int volumes = 0;

    void add(const Stream& s, float p, Rng& rng) {
        const bool volume = p > 0 && rng.next() < p;
        volumes += volume;
        const int bin = std::min(static_cast<int>(s.t / static_cast<float>(kEnd) * kBins), kBins - 1);
        for (int c = 0; c < 3; ++c) {
            passed[c].add(double{s.surface[c]});
            emitted[c].add(double{s.emitted[c]});
            for (int b = 0; b < kBins; ++b)
                scattered[c][b].add(b == bin ? double{s.volume[c]} : 0);
            decided_passed[c].add(volume ? 0 : double{s.surface[c]} / (1 - double{p}));
            decided_scattered[c].add(volume ? double{s.volume[c]} / double{p} : 0);
        }
    }
    /// n: streams so far; rare: one branch is decided for too rarely to test. Sums too small for a normal
    /// distribution are left out.
    void expect(const LineTruth& truth, Rgb start, int n, bool rare) const {
        const auto expect_mean = [n](const Mean& mean, double expected, double least, const char* what, int c,
                                     int bin = -1) {
            if (expected * n >= least) {
                EXPECT_LT(mean.z(expected, 1e-4), kSigmas)
                    << what << " of channel " << c << " bin " << bin << ": " << mean.mean() << ", not "
                    << expected << ", error " << mean.error();
            }
        };
        for (int c = 0; c < 3; ++c) {
            const double scale = double{start[c]}, through = scale * truth.transmittance[c];
            expect_mean(passed[c], through, 50, "transmittance", c);
            expect_mean(emitted[c], scale * truth.emitted[c], 0, "emission", c);
            if (!rare && n - volumes > 300)
                expect_mean(decided_passed[c], through, 300, "passing", c);
            if (!rare && volumes > 300)
                expect_mean(decided_scattered[c], scale * truth.scattered_in_all(c), 300, "scattering", c);
            for (int b = 0; b < kBins; ++b)
                expect_mean(scattered[c][b], scale * truth.scattered[c][static_cast<std::size_t>(b)], 50,
                            "candidates", c, b);
        }
    }
};

struct Way {
    Control control;
    bool lights;
    bool global = false;
};
class StreamIn : public testing::TestWithParam<std::tuple<Case, Way>> {};

std::string name_of(const testing::TestParamInfo<std::tuple<Case, Way>>& test) {
    const auto& [medium, way] = test.param;
    return medium.name + (way.control == Control::exact ? "_exact" : "_conditional") +
           (way.lights ? "_lamps" : "") + (way.global ? "_global" : "");
}
/// All but those that differ in the majorants' data structure alone.
std::vector<Case> stream_cases() {
    std::vector<Case> out = cases();
    std::erase_if(out, [](const Case& c) { return c.name.ends_with("_kdtree"); });
    return out;
}
INSTANTIATE_TEST_SUITE_P(Media, StreamIn,
                         testing::Combine(testing::ValuesIn(stream_cases()),
                                          testing::Values(Way{Control::exact, false},
                                                          Way{Control::exact, true, true},
                                                          Way{Control::conditional, false, true},
                                                          Way{Control::conditional, true})),
                         name_of);

/// Targets at the ends and between, and radiances that are far off, with and without a known depth.
std::vector<VspGuide> guides_for(Control control) {
    if (control == Control::exact)
        return {guide_to(kLowestVsp), guide_to(0.5f), guide_to(kHighestVsp), guide_of(30, 0.5f, 0.8f)};
    return {guide_of(1, 1, 0.5f), guide_of(1, 20, 0.5f, 0.6f), guide_of(20, 1, 0.9f, 2)};
}

TEST_P(StreamIn, BothBranchesAndEmissionAreUnbiased) {
    const auto& [medium, way] = GetParam();
    const int streams = way.lights ? 32000 : 8000;  // where lamps draw the candidates, others are rare
    Line line = medium.line();
    line.media.front().emission = {0.5f, 2, 0.1f};
    const LineTruth truth(line, 0, kEnd, kBins);
    // One close, one that the ray goes right through, one off the segment's end.
    const LightSet lamps = lamps_along(line.segment.ray, {{21, 0.3f}, {33, 0, 1}, {55, 4, 300}});
    const Rgb start{1, 0.5f, 0.8f};
    std::uint64_t seed = 71;
    for (const VspGuide& guide : guides_for(way.control)) {
        for (const float defensive : {1.0f, 0.75f}) {
            if (way.control == Control::conditional && defensive < 1)
                continue;
            SCOPED_TRACE("target " + std::to_string(guide.target) + ", radiances " +
                         std::to_string(guide.volume_radiance) + " and " +
                         std::to_string(guide.surface_radiance) + ", defensive " + std::to_string(defensive));
            Walker walker(line.segment, vsp_settings(way.control, defensive, way.global), guide,
                          way.lights ? &lamps : nullptr, ++seed);
            Brought brought;
            for (int n = 0; n < streams; ++n) {
                const Stream s = walker.walk(start);
                brought.add(s, walker.probability(s), walker.rng());
            }
            brought.expect(truth, start, streams, guide.target < 0.01f || guide.target > 0.99f);
            EXPECT_EQ(walker.counters.bound_violations, 0u);
        }
    }
}

TEST_P(StreamIn, SharesSayWhichMediumScatters) {
    constexpr int kStreams = 8000;
    const auto& [medium, way] = GetParam();
    Line line = medium.line();
    if (line.media.size() < 2)
        GTEST_SKIP() << "one medium";
    float number = 0;
    for (Medium& m : line.media)
        m.phase.p0 = m.program ? kProgramG : number++;  // tells whose a share is
    const LightSet lamps = lamps_along(line.segment.ray, {{21, 0.3f}});
    Walker walker(line.segment, vsp_settings(way.control, 1, way.global), guide_of(1, 1, 0.5f),
                  way.lights ? &lamps : nullptr, 89);
    std::vector<std::array<Mean, 3>> by_medium(line.media.size());
    for (int n = 0; n < kStreams; ++n) {
        const Stream s = walker.walk();
        Rgb total;
        for (const ScatterShare& share : walker.scratch.shares)
            total += share.sigma_s;
        ASSERT_EQ(s.weights.volume > 0, !is_zero(total));
        for (std::size_t m = 0; m < line.media.size(); ++m) {
            Rgb scattered;
            for (const ScatterShare& share : walker.scratch.shares) {
                if (share.phase.p0 == line.media[m].phase.p0 && s.weights.volume > 0)
                    scattered += s.volume * share.sigma_s / max(total, Rgb(1e-30f));
            }
            for (int c = 0; c < 3; ++c)
                by_medium[m][static_cast<std::size_t>(c)].add(double{scattered[c]});
        }
    }
    for (std::size_t m = 0; m < line.media.size(); ++m) {
        line.scatters = &line.media[m];
        for (int c = 0; c < 3; ++c) {
            const double expected = Profile(line, 0, kEnd, c, 20000).scattered.back();
            const Mean& mean = by_medium[m][static_cast<std::size_t>(c)];
            if (expected * kStreams >= 50) {
                EXPECT_LT(mean.z(expected, 1e-4), kSigmas)
                    << "medium " << m << " channel " << c << ": " << mean.mean() << ", not " << expected;
            }
        }
    }
}

}  // namespace
}  // namespace nephele::test
