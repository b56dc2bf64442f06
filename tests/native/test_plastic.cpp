// SPDX-License-Identifier: GPL-3.0-or-later
// Plastics against closed forms: the coat's mean reflectance, light between base and coat, the whole's
// albedo.
#include <gtest/gtest.h>

#include "math/sampler.h"
#include "surface_fixtures.h"

namespace nephele {
namespace {

using testing::at_angle;

TEST(Fresnel, ExactMeanIsTheIntegral) {
    for (const float eta : {1.00005f, 1.001f, 1.1f, 1.5f, 2.4f, 1 / 1.1f, 1 / 1.5f, 1 / 2.4f}) {
        double sum = 0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double c = (i + 0.5) / kSteps;
            sum += 2 * c * static_cast<double>(fresnel_dielectric(static_cast<float>(c), eta)) / kSteps;
        }
        EXPECT_NEAR(exact_fresnel_dielectric_mean(eta), sum, 2e-6 + 2e-5 * sum) << eta;
    }
}

// Light from below is thrown back and forth: the series of it, summed by hand.
TEST(Plastic, BaseGathersWhatTheCoatThrowsBack) {
    const float eta = 1.5f, mu_o = 0.8f, mu_i = 0.3f, color = 0.6f;
    const float into = 1 - fresnel_dielectric(mu_i, eta),
                out = (1 - fresnel_dielectric(mu_o, eta)) / (eta * eta);
    const float back = exact_fresnel_dielectric_mean(1 / eta);
    for (const bool nonlinear : {false, true}) {
        float sum = 0, term = color;
        for (int bounce = 0; bounce < 200; ++bounce, term *= back * (nonlinear ? color : 1))
            sum += term;
        const Vec3f wo(std::sqrt(1 - mu_o * mu_o), 0, mu_o), wi(0, std::sqrt(1 - mu_i * mu_i), mu_i);
        const LobeValue value = PlasticBase(Rgb(color), eta, 0, nonlinear).eval(wo, wi);
        EXPECT_NEAR(value.f.x, into * out * sum * mu_i / kPi, 1e-6);
    }
}

// A coat of the same index as what is outside is none, however rough.
TEST(Plastic, WithoutInterfaceIsItsBase) {
    for (const float eta : {1.0f, 1.00005f, 1 / 1.00005f}) {
        const PlasticBase base(Rgb(0.6f), eta, 0.7f, true);
        const Vec3f wo = at_angle(40), wi = at_angle(-70);
        EXPECT_NEAR(base.eval(wo, wi).f.x, 0.6f * wi.z / kPi, 1e-4f) << eta;
        EXPECT_NEAR(base.albedo(wo).x, 0.6f, 1e-3f) << eta;
    }
}

// What the coat reflects, and of the rest what the base returns through it: 1 where it is white. Draws take a
// lobe each, so that the standard error of their mean is below 0.25 %.
TEST(Plastic, LosesWhatItsClosedFormSays) {
    const TextureContext no_textures;
    Rng rng(9);
    for (const float eta : {1.2f, 1.5f, 2.0f}) {
        const float back = exact_fresnel_dielectric_mean(1 / eta);
        for (const float color : {1.0f, 0.5f}) {
            for (const bool nonlinear : {false, true}) {
                const Program program = testing::ConstantProgram()
                                            .add(ClosureKind::plastic, {Vec3f(color), Vec3f(0), Vec3f(eta),
                                                                        Vec3f(nonlinear), testing::kNoNormal})
                                            .program;
                for (const double angle : {0.0, 45.0, 80.0, 88.0}) {
                    const ShadingPoint point = testing::point_seen_from(at_angle(angle), angle == 45);
                    const float F = fresnel_dielectric(point.wo.z, eta);
                    const float again = nonlinear ? color : 1;
                    const float expected = F + (1 - F) * color * (1 - back) / (1 - again * back);
                    const Bsdf bsdf = make_bsdf(&program, point, no_textures);
                    EXPECT_NEAR(bsdf.albedo(point.wo).x, expected, 2e-5f) << eta << " at " << angle;
                    double sum = 0;
                    constexpr int kDraws = 40000;
                    for (int i = 0; i < kDraws; ++i) {
                        const float lobe_u = rng.next();
                        const auto drawn = bsdf.sample(point.wo, lobe_u, rng.next2());
                        sum += drawn ? static_cast<double>(drawn->weight.x) / kDraws : 0;
                    }
                    EXPECT_NEAR(sum, expected, 0.01) << eta << " at " << angle;
                }
            }
        }
    }
}

// From smooth to rough there is no jump. Rough coats scatter once: they lose light and never gain any.
TEST(Plastic, RoughCoatsBeginAtTheSmoothOne) {
    for (const double angle : {0.0, 45.0, 80.0}) {
        const Vec3f wo = at_angle(angle);
        const PlasticBase smooth(Rgb(1), 1.5f, 0, false), nearly(Rgb(1), 1.5f, 1e-3f, false);
        EXPECT_NEAR(nearly.albedo(wo).x, smooth.albedo(wo).x, 2e-3f);
        for (const float roughness : {0.2f, 0.5f, 1.0f}) {
            const Program program = testing::ConstantProgram()
                                        .add(ClosureKind::plastic, {Vec3f(1), Vec3f(roughness), Vec3f(1.5f),
                                                                    Vec3f(1), testing::kNoNormal})
                                        .program;
            const ShadingPoint point = testing::point_seen_from(wo);
            const float albedo = make_bsdf(&program, point, {}).albedo(wo).x;
            EXPECT_LE(albedo, 1.015f) << roughness << " at " << angle;  // tables are good to 1 %
            EXPECT_GE(albedo, roughness < 0.3f ? 0.9f : 0) << roughness << " at " << angle;
        }
    }
}

}  // namespace
}  // namespace nephele
