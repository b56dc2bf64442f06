// SPDX-License-Identifier: GPL-3.0-or-later
// What pixels learn about their scattering probability: the same moments whatever probabilities were in
// force, sound guides from any samples, and a state that survives a checkpoint.
#include "guiding/vsp_buffer.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstddef>
#include <stdexcept>

#include "media_fixtures.h"

namespace nephele::test {
namespace {

Settings buffer_settings(Settings::VspCriterion criterion) {
    Settings s;
    s.vsp_criterion = criterion;
    s.vsp_cost = false;
    return s;
}
constexpr auto kContribution = Settings::VspCriterion::contribution;
constexpr auto kVariance = Settings::VspCriterion::variance;

/// A sample of a pixel whose volume brings `volume` and whose surface brings `surface` per unit of weight,
/// each with noise of this relative size, decided with probability p for the volume.
VspRecord record_of(float p, float volume, float surface, float noise, Rng& rng, float T = 0.6f) {
    VspRecord r;
    r.known = true;
    r.scattered = rng.next() < p;
    r.probability = r.scattered ? p : 1 - p;
    r.volume_weight = 1 - T;
    r.surface_weight = T;
    const float radiance = r.scattered ? volume : surface, weight = r.scattered ? 1 - T : T;
    // Two values of equal chance, so that the second moment is (1 + noise^2) of the squared mean.
    r.light = radiance * weight * (rng.next() < 0.5f ? 1 - noise : 1 + noise) / r.probability;
    r.cost = 1;
    r.transmittance = T;
    r.majorant_depth = 2;
    r.distance = 5;
    return r;
}

/// Ratio of the radiances that a buffer of 16 x 16 pixels learned, on average.
double ratio_of(const VspBuffer& buffer) {
    double volume = 0, surface = 0;
    for (int i = 0; i < 256; ++i) {
        volume += double{buffer.guide(i % 16, i / 16).volume_radiance};
        surface += double{buffer.guide(i % 16, i / 16).surface_radiance};
    }
    return volume / surface;
}
double learned_ratio(Settings::VspCriterion criterion, float volume, float surface, float noise,
                     const std::vector<float>& probabilities, int samples) {
    VspBuffer buffer(16, 16, buffer_settings(criterion));
    Rng rng(167);
    for (int n = 0; n < samples; ++n) {
        for (int i = 0; i < 256; ++i) {
            const float p = probabilities[static_cast<std::size_t>(n) % probabilities.size()];
            buffer.add(i % 16, i / 16, record_of(p, volume, surface, noise, rng));
        }
    }
    buffer.update();
    return ratio_of(buffer);
}

TEST(VspBuffer, LearnsTheSameMomentsWhateverTheProbabilitiesWere) {
    for (const auto criterion : {kContribution, kVariance}) {
        for (const std::vector<float>& p : {std::vector<float>{0.5f}, {0.05f}, {0.95f}, {0.2f, 0.9f, 0.5f}}) {
            // Noise is the same in both branches here, and does not change the ratio of the moments' roots.
            EXPECT_NEAR(learned_ratio(criterion, 3, 0.5f, 0.5f, p, 300), 6, 0.25)
                << "p " << p[0] << ", criterion " << static_cast<int>(criterion);
        }
    }
}

TEST(VspBuffer, TheVarianceCriterionSeesNoise) {
    VspBuffer buffer(16, 16, buffer_settings(kVariance));
    Rng rng(173);
    for (int n = 0; n < 400000; ++n) {
        VspRecord r = record_of(0.4f, 1, 1, 0, rng);
        if (r.scattered)
            r.light *= rng.next() < 0.25f ? 4.0f : 0.0f;  // a second moment of 4
        buffer.add(n % 16, n / 16 % 16, r);
    }
    buffer.update();
    EXPECT_NEAR(ratio_of(buffer), 2, 0.05);
    EXPECT_NEAR(buffer.guide(8, 8).target, 2 * 0.4 / (2 * 0.4 + 0.6), 0.03);
}

TEST(VspBuffer, CostLowersTheDearerBranch) {
    Settings settings = buffer_settings(kContribution);
    settings.vsp_cost = true;
    VspBuffer buffer(8, 8, settings);
    Rng rng(179);
    for (int n = 0; n < 20000; ++n) {
        VspRecord r = record_of(0.5f, 1, 1, 0, rng);
        r.cost = r.scattered ? 9.0f : 1.0f;
        buffer.add(n % 8, n / 8 % 8, r);
    }
    buffer.update();
    EXPECT_NEAR(buffer.guide(4, 4).volume_radiance / buffer.guide(4, 4).surface_radiance, 1 / 3.0, 0.02);
}

/// volume_weight, surface_weight: of delta tracking. Each branch keeps 2 % of the other's radiance, or half
/// of the paths where that is less.
void expect_sound(const VspGuide& guide, float volume_weight, float surface_weight) {
    EXPECT_TRUE(guide.target >= kLowestVsp && guide.target <= kHighestVsp) << guide.target;
    EXPECT_TRUE(guide.volume_radiance > 0 && guide.volume_radiance < 1e6f) << guide.volume_radiance;
    EXPECT_TRUE(guide.surface_radiance > 0 && guide.surface_radiance < 1e6f) << guide.surface_radiance;
    EXPECT_TRUE(guide.transmittance >= 0 && guide.transmittance <= 1) << guide.transmittance;
    EXPECT_TRUE(guide.majorant_depth >= 0 && std::isfinite(guide.majorant_depth)) << guide.majorant_depth;
    const float ratio = guide.volume_radiance / guide.surface_radiance;
    const auto least = [](float other, float own) {
        return 0.95f * std::min(0.02f, own > 0 ? std::clamp(other / own, 1e-20f, 1.0f) : 1.0f);
    };
    EXPECT_GT(ratio, least(surface_weight, volume_weight)) << "the volume is given up";
    EXPECT_GT(1 / ratio, least(volume_weight, surface_weight)) << "the surface is given up";
}

TEST(VspBuffer, WithoutSamplesGuidesAreNeutral) {
    VspBuffer buffer(5, 3, buffer_settings(kVariance));
    for (int round = 0; round < 2; ++round) {
        EXPECT_EQ(buffer.guide(4, 2).target, 0.5f);
        EXPECT_EQ(buffer.guide(4, 2).volume_radiance, buffer.guide(4, 2).surface_radiance);
        VspRecord unknown;
        buffer.add(1, 1, unknown);
        buffer.update();
    }
}

TEST(VspBuffer, GuidesAreSoundWhateverTheSamplesWere) {
    const float lights[] = {0, 1e-30f, 1e-12f, 1, 1e9f, 1e15f, 1e20f, 1e30f};
    const float weights[] = {0, 1e-38f, 1e-12f, 1, 1e6f};
    for (const auto criterion : {kContribution, kVariance}) {
        for (const float light : lights) {
            for (const float weight : weights) {
                for (const bool scattered : {false, true}) {
                    VspBuffer buffer(6, 4, buffer_settings(criterion));
                    VspRecord r;
                    r.known = true;
                    r.scattered = scattered;
                    r.probability = 0.001f;
                    r.volume_weight = scattered ? weight : 1e-3f;
                    r.surface_weight = scattered ? 0.5f : weight;
                    r.light = light;
                    r.majorant_depth = 1e30f;
                    r.distance = kInfinity;
                    buffer.add(3, 2, r);
                    r.scattered = !scattered;
                    r.light = 1;
                    buffer.add(2, 2, r);
                    buffer.update();
                    for (int i = 0; i < 24; ++i)
                        expect_sound(buffer.guide(i % 6, i / 6), r.volume_weight, r.surface_weight);
                    if (HasFailure())
                        FAIL() << "light " << light << ", weight " << weight << ", scattered " << scattered;
                }
            }
        }
    }
}

TEST(VspBuffer, FixedTargetsAreTheSameForEverAndCoverTheRange) {
    using Target = Settings::VspTarget;
    for (const auto& [kind, least, most] : {std::tuple(Target::lowest, kLowestVsp, kLowestVsp),
                                            std::tuple(Target::highest, kHighestVsp, kHighestVsp),
                                            std::tuple(Target::random, kLowestVsp, kHighestVsp)}) {
        Settings settings;
        settings.vsp_target = kind;
        VspBuffer buffer(40, 30, settings), again(40, 30, settings);
        Rng rng(181);
        Mean mean;
        for (int i = 0; i < 1200; ++i)
            buffer.add(i % 40, i / 40, record_of(0.5f, 5, 1, 0, rng));
        buffer.update();
        for (int i = 0; i < 1200; ++i) {
            const VspGuide guide = buffer.guide(i % 40, i / 40);
            EXPECT_TRUE(guide.target >= least && guide.target <= most) << guide.target;
            EXPECT_FLOAT_EQ(guide.volume_radiance / (guide.volume_radiance + guide.surface_radiance),
                            guide.target);
            EXPECT_EQ(guide.target, again.guide(i % 40, i / 40).target);
            mean.add(double{guide.target});
        }
        if (kind == Target::random) {
            EXPECT_LT(mean.z(0.5), kSigmas);
            EXPECT_NEAR(mean.error() * std::sqrt(1199.0), 1 / std::sqrt(12.0), 0.02);
        }
    }
}

TEST(VspBuffer, LearnsOnAfterACheckpointAsWithout) {
    VspBuffer whole(9, 7, buffer_settings(kVariance)), first(9, 7, buffer_settings(kVariance)),
        second(9, 7, buffer_settings(kVariance));
    Rng rng(191);
    std::map<std::string, std::vector<double>> saved;
    for (int n = 0; n < 2000; ++n) {
        if (n == 1000) {
            first.update();
            whole.update();
            first.save(saved);
            second.restore(saved);
            EXPECT_EQ(second.guide(4, 3).target, whole.guide(4, 3).target);
        }
        const VspRecord r = record_of(0.3f, 2, 1, 0.5f, rng);
        whole.add(n % 9, n / 9 % 7, r);
        (n < 1000 ? first : second).add(n % 9, n / 9 % 7, r);
    }
    whole.update();
    second.update();
    for (int i = 0; i < 63; ++i) {
        EXPECT_EQ(second.guide(i % 9, i / 9).target, whole.guide(i % 9, i / 9).target);
        EXPECT_EQ(second.guide(i % 9, i / 9).volume_radiance, whole.guide(i % 9, i / 9).volume_radiance);
    }
}

TEST(VspBuffer, RefusesCheckpointsThatDoNotFit) {
    VspBuffer small(4, 4, buffer_settings(kVariance)), large(5, 4, buffer_settings(kVariance));
    std::map<std::string, std::vector<double>> saved;
    EXPECT_THROW(small.restore(saved), std::invalid_argument);
    small.save(saved);
    EXPECT_THROW(large.restore(saved), std::invalid_argument);
    saved.erase("vsp_sums");
    EXPECT_THROW(small.restore(saved), std::invalid_argument);
    Settings fixed;
    fixed.vsp_target = Settings::VspTarget::lowest;
    VspBuffer constant(4, 4, fixed);
    EXPECT_NO_THROW(constant.restore(saved)) << "a fixed target learns nothing and needs no sums";
}

/// A noise below -1.25 would ask for negative majorants.
TEST(VspBuffer, RefusesGuidesThatAreNone) {
    std::map<std::string, std::vector<double>> good;
    VspBuffer buffer(1, 1, buffer_settings(kVariance));
    buffer.save(good);
    const auto refused = [&](const char* name, std::size_t place, float value) {
        auto bad = good;
        bad.at(name)[place] = std::bit_cast<std::uint32_t>(value);
        EXPECT_THROW(buffer.restore(bad), std::invalid_argument) << name << ' ' << place << ' ' << value;
    };
    for (std::size_t member = 0; member < sizeof(VspGuide) / sizeof(float); ++member)
        refused("vsp_guides", member, NAN);
    refused("vsp_guides", offsetof(VspGuide, target) / sizeof(float), 1);
    refused("vsp_guides", offsetof(VspGuide, majorant_depth) / sizeof(float), -1);
    for (std::size_t member = 0; member < good.at("vsp_sums").size(); ++member)
        refused("vsp_sums", member, INFINITY);
    EXPECT_NO_THROW(buffer.restore(good));
}

}  // namespace
}  // namespace nephele::test
