// SPDX-License-Identifier: GPL-3.0-or-later
// What a region learns: how segments part between volume and surface, how many directions to guide, what
// branches are worth.
#include "guiding/field_region.h"

#include <gtest/gtest.h>

#include "field_fixtures.h"
#include "guiding_fixtures.h"

namespace nephele::test {
namespace {

const Settings kSettings = vsp_settings(Control::conditional);
const Vec3f kA(0, 0, 1), kB = normalize(Vec3f(1, 0.2f, -0.7f));
/// Light from two narrow sides and a little from all around.
const VmfMixture kLight = [] {
    VmfMixture m;
    m.set(0, 0.45f, {kA, 30}, 0);
    m.set(1, 0.45f, {kB, 30}, 0);
    m.set(2, 0.1f, {{0, 1, 0}, 0}, 0);
    return m;
}();

/// Lets a region learn from batches of samples of kLight, drawn uniformly. edit: what else there is to a
/// sample.
template <class Edit>
FieldRegion taught(Edit&& edit, int batches = 8, int n = 2000) {
    Rng rng(947);
    FieldRegion region;
    for (int i = 0; i < batches; ++i) {
        std::vector<FieldSample> samples;
        for (int j = 0; j < n; ++j) {
            const Vec3f wi = sample_sphere(rng.next2());
            samples.push_back(isotropic_sample({}, wi, kLight.pdf(wi)));
            edit(samples.back(), rng);
        }
        region.update(kSettings, samples);
    }
    return region;
}
/// What share of equal branches goes to the volume.
double volume_share(const FieldRegion& region, Vec3f wi) {
    return double{volume_probability(kSettings, region.vsp(wi), {1, 1, 0.5f, 0.1f})};
}

TEST(FieldRegion, PartsSegmentsByWhatTheyBring) {
    const FieldRegion region = taught([](FieldSample& s, Rng& rng) {
        const bool towards_a = dot(s.wi, kA) > dot(s.wi, kB);
        s.vsp = record_of(towards_a ? 1 : 0, towards_a ? 0 : 1, rng);
    });
    EXPECT_GT(volume_share(region, kA), 0.9);
    EXPECT_LT(volume_share(region, kB), 0.1);
    EXPECT_GT(region.vsp(kA).target, 0.9f);
    EXPECT_LT(region.vsp(kB).target, 0.1f);
    EXPECT_NEAR(region.vsp(kA).transmittance, 0.5f, 1e-3f);
    EXPECT_NEAR(region.vsp(kB).majorant_depth, 1, 1e-3f);
}

TEST(FieldRegion, PartsEqualBranchesEqually) {
    const FieldRegion region = taught([](FieldSample& s, Rng& rng) { s.vsp = record_of(1, 1, rng); });
    for (const Vec3f wi : {kA, kB, -kA, -kB})
        EXPECT_NEAR(volume_share(region, wi), 0.5, 0.05);
}

TEST(FieldRegion, UnknownSegmentsAreAsInDeltaTracking) {
    // No segment met a medium, or only those towards A did.
    const FieldRegion none = taught([](FieldSample&, Rng&) {});
    const FieldRegion some = taught([](FieldSample& s, Rng& rng) {
        if (dot(s.wi, kA) > 0.5f)
            s.vsp = record_of(1, 0, rng);
    });
    for (const Vec3f wi : {kA, kB, -kA})
        EXPECT_NEAR(volume_share(none, wi), 0.5, 1e-5);
    EXPECT_NEAR(volume_share(some, kB), 0.5, 0.05);
    EXPECT_GT(volume_share(some, kA), 0.9);
}

TEST(FieldRegion, WithoutLightGuidesNothing) {
    // A mixture without lobes has no directions to give, and no guide of any lobe.
    Rng rng(953);
    for (const bool fresh : {true, false}) {
        FieldRegion region;
        for (int i = 0; i < (fresh ? 0 : 3); ++i) {
            std::vector<FieldSample> samples(100, isotropic_sample({}, kA, 0));
            for (FieldSample& s : samples)
                s.vsp = record_of(0, 0, rng);
            region.update(kSettings, samples);
        }
        EXPECT_EQ(region.guided_share, 0);
        EXPECT_EQ(region.worth, 0);
        EXPECT_NEAR(volume_share(region, kA), 0.5, 1e-6);
        EXPECT_GT(region.vsp(kA).volume_radiance, 0);
        EXPECT_TRUE(region.sound());
    }
}

TEST(FieldRegion, GuidesNothingThatIsWellSampledAlready) {
    const VmfLobe lobe{kA, 20};
    // By the light, and by the phase function under light from everywhere.
    for (const bool by_light : {true, false}) {
        Rng rng(967);
        FieldRegion region;
        for (int i = 0; i < 8; ++i) {
            std::vector<FieldSample> samples;
            for (int j = 0; j < 2000; ++j) {
                FieldSample s = isotropic_sample({}, vmf_sample(lobe, rng.next2()), 1);
                s.pdf = s.scatter_pdf = vmf_pdf(lobe, s.wi);
                (by_light ? s.light : s.scattering) = s.pdf;
                samples.push_back(s);
            }
            region.update(kSettings, samples);
        }
        EXPECT_EQ(region.guided_share, 0) << by_light;
    }
}

TEST(FieldRegion, GuidesWhatIsHardToFind) {
    EXPECT_GE(taught([](FieldSample&, Rng&) {}).guided_share, 0.5f);
    EXPECT_GE(taught([](FieldSample&, Rng&) {}, 2).guided_share, 0.5f);
    // A guide that is known not to draw what matters is not used.
    const FieldRegion misled = taught([](FieldSample& s, Rng&) { s.guide_pdf = 0.01f * kInv4Pi; });
    EXPECT_EQ(misled.guided_share, 0);
}

TEST(FieldRegion, LooksElsewhereWhereFewSamplesBringAll) {
    // One in so many samples of a narrow lobe, all that brings light.
    const auto share_at = [](float seldom) {
        return taught([&](FieldSample& s, Rng& rng) {
                   const bool found = rng.next() < seldom;
                   s.wi = found ? vmf_sample({kA, 400}, rng.next2()) : sample_sphere(rng.next2());
                   s.light = found ? 1 : 0;
               })
            .guided_share;
    };
    EXPECT_GT(share_at(0.02f), 0.5f);   // about 320 of 16000
    EXPECT_EQ(share_at(0.002f), 0.5f);  // about 32
}

TEST(FieldRegion, WorthIsTheRootOfSecondMomentPerWork) {
    const auto constant = [](FieldSample& s, Rng&) {
        s.light = 2;  // times scattering, divided by pdf
        s.cost = 5;
    };
    EXPECT_NEAR(taught(constant).worth, std::sqrt(4 / 5.0), 1e-3);
    EXPECT_NEAR(taught(constant, 1, 65).worth, std::sqrt(4 / 5.0), 1e-3);
    EXPECT_EQ(taught(constant, 1, 63).worth, 0) << "too few to tell";
    EXPECT_NEAR(taught(constant, 100).worth, std::sqrt(4 / 5.0), 1e-3);
    EXPECT_EQ(taught([](FieldSample& s, Rng&) { s.cost = 0; }).worth, 0);
    // Costs and contributions that vary: E[C^2] = 10 and E[cost] = 5.
    const FieldRegion mixed = taught([](FieldSample& s, Rng& rng) {
        s.light = rng.next() < 0.5f ? 2 : 4;
        s.cost = rng.next() < 0.5f ? 1 : 9;
    });
    EXPECT_NEAR(mixed.worth, std::sqrt(10 / 5.0), 0.03);  // standard deviation 0.006
}

TEST(FieldRegion, FirefliesDoNotDecideWhatBranchesAreWorth) {
    const FieldRegion region = taught([](FieldSample& s, Rng&) {
        s.light = s.wi.z > 0.999f ? 1e12f : 1;  // 1 in 2000
        s.cost = 1;
    });
    EXPECT_LT(region.worth, 1.1f);
}

TEST(FieldRegion, SaysNothingOfBranchesOfWhichFewBringAll) {
    const FieldRegion region = taught(
        [](FieldSample& s, Rng& rng) {
            s.light = rng.next() < 0.01f ? 100 : 0.01f;  // about 20 of 2000
            s.cost = 1;
        },
        1);
    EXPECT_EQ(region.worth, 0);
    EXPECT_EQ(region.split_worth, 0);
}

TEST(FieldRegion, HalvesStandForHalfAndSeeTheSameLight) {
    const Vec3f source(0, 0, 2), elsewhere(1.5f, 0, 0);
    FieldRegion region = taught([&](FieldSample& s, Rng& rng) {
        if (rng.next() < 0.5f) {
            s.wi = normalize(source + vmf_sample({kA, 0}, rng.next2()) * 0.1f);
            s.distance = length(source);
            s.light = 1;
        } else {
            s.light = 0;
        }
    });
    const float samples = region.samples(), share = region.guided_share, worth = region.worth;
    const auto around = [](const FieldRegion& r, Vec3f towards) { return r.mixture.pdf(normalize(towards)); };
    EXPECT_GT(around(region, source), 10 * around(region, source - elsewhere));
    region.become_half(elsewhere);
    EXPECT_EQ(region.samples(), samples / 2);
    EXPECT_EQ(region.pivot, elsewhere);
    EXPECT_EQ(region.guided_share, share);
    EXPECT_EQ(region.worth, worth);
    EXPECT_GT(around(region, source - elsewhere), 10 * around(region, source));
    EXPECT_TRUE(region.sound());
}

TEST(FieldRegion, AVertexOnThePivotOfItsLightIsLeftOut) {
    FieldRegion region;
    region.pivot = {1, 2, 3};
    FieldSample s = isotropic_sample({1, 2, 1}, kA, 1);
    s.distance = 2;  // right at the pivot
    std::vector<FieldSample> samples(50, s);
    region.update(kSettings, samples);
    EXPECT_TRUE(region.sound());
    EXPECT_EQ(region.samples(), 0);
}

TEST(FieldRegion, ExtremeSamplesLeaveItSound) {
    constexpr float kTiny = 1e-38f, kHuge = 1e38f;
    FieldRegion region = taught([](FieldSample&, Rng&) {});
    Rng rng(971);
    for (const auto& [light, pdf, scatter_pdf, scattering] : {std::array{kHuge, 1.0f, 1.0f, 1.0f},
                                                              {1.0f, kTiny, 1.0f, 1.0f},
                                                              {1.0f, 1.0f, kTiny, 1.0f},
                                                              {1.0f, 1.0f, 1.0f, kHuge},
                                                              {kHuge, kTiny, kTiny, kHuge},
                                                              {kHuge, kHuge, kTiny, kHuge},
                                                              {kTiny, kHuge, kTiny, kTiny}}) {
        for (const float distance : {kTiny, 1.0f, kHuge, kInfinity}) {
            FieldSample s = isotropic_sample({}, kB, light);
            s.pdf = pdf;
            s.scatter_pdf = scatter_pdf;
            s.scattering = scattering;
            s.distance = distance;
            s.vsp = record_of(kHuge, kTiny, rng);
            std::vector<FieldSample> samples(40, s);
            region.update(kSettings, samples);
            ASSERT_TRUE(region.sound())
                << light << ' ' << pdf << ' ' << scatter_pdf << ' ' << scattering << ' ' << distance;
        }
    }
}

}  // namespace
}  // namespace nephele::test
