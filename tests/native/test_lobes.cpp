// SPDX-License-Identifier: GPL-3.0-or-later
// Every lobe by itself: sampling against density, weight against eval, reciprocity, energy. Local frames,
// normal +z.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "chi_square.h"
#include "surface_fixtures.h"
#include "surfaces/directional_albedo.h"
#include "surfaces/principled.h"

namespace nephele {
namespace {

using testing::at_angle;

struct NamedLobe {
    std::string name;
    LobeModel model;
    bool reciprocal;
};

Microfacet facets(float roughness, bool beckmann = false) {
    return {roughness * roughness, beckmann};
}

const Fresnel kGold = Fresnel::conductor({0.18f, 0.42f, 1.37f}, {3.42f, 2.35f, 1.77f});

std::vector<NamedLobe> smooth_lobes() {
    std::vector<NamedLobe> lobes = {
        {"lambert", Lambert{}, true},
        {"translucent", Translucent{}, false},
        {"rough diffuse 0.4", RoughDiffuse{{0.9f, 0.5f, 0.2f}, 0.4f}, true},
        {"rough diffuse 1", RoughDiffuse{{0.9f, 0.5f, 0.2f}, 1.0f}, true},
        {"plastic", PlasticBase({0.9f, 0.5f, 0.2f}, 1.5f, 0, false), true},
        {"nonlinear plastic", PlasticBase({0.9f, 0.5f, 0.2f}, 1.9f, 0, true), true},
        {"rough plastic", PlasticBase({0.9f, 0.5f, 0.2f}, 1.5f, 0.4f, false), true},
        {"sheen 0.4", Sheen(0.4f, 0.3f), false},
        {"sheen 0.8", Sheen(0.8f, 0.9f), false},
        {"velvet 0.3", Velvet{0.3f}, true},
        {"velvet 1", Velvet{1}, true},
        {"toon", Toon{0.6f, 0.5f, false}, false},
        {"glossy toon", Toon{0.4f, 1.3f, true}, false},
        {"reflection off a conductor", Reflection{facets(0.5f), kGold, Rgb(1)}, true},
        {"reflection brushed", Reflection{Microfacet::brushed(0.4f, false, 1.6f), kGold, Rgb(1)}, true},
        {"reflection brushed beckmann", Reflection{Microfacet::brushed(0.4f, true, 0.6f), kGold, Rgb(1)},
         true},
        {"reflection off a film", Reflection{facets(0.5f), kGold.under({300, 1.5f}), Rgb(1)}, true},
        {"glass under a film",
         Dielectric{facets(0.5f), Fresnel::dielectric(1.5f).under({400, 1.3f}), 1.5f, Rgb(1), Rgb(1), Rgb(1)},
         false},
    };
    for (const float roughness : {0.2f, 0.5f, 1.0f}) {
        for (const bool beckmann : {false, true}) {
            const std::string name = (beckmann ? "beckmann " : "ggx ") + std::to_string(roughness);
            const Microfacet m = facets(roughness, beckmann);
            lobes.push_back({"reflection " + name,
                             Reflection{m, Fresnel::metal({0.9f, 0.5f, 0.2f}, Rgb(1)), Rgb(1)}, true});
            lobes.push_back({"into glass " + name,
                             Dielectric{m, Fresnel::dielectric(1.5f), 1.5f, Rgb(1), Rgb(1), Rgb(1)}, false});
            lobes.push_back(
                {"out of glass " + name,
                 Dielectric{m, Fresnel::dielectric(1 / 1.5f), 1 / 1.5f, Rgb(1), {0.9f, 0.5f, 0.2f}, Rgb(1)},
                 false});
            lobes.push_back({"refraction " + name,
                             Dielectric{m, Fresnel::constant(Rgb(0)), 1.33f, Rgb(1), Rgb(1), Rgb(1)}, false});
        }
    }
    return lobes;
}

LobeValue eval(const LobeModel& model, Vec3f wo, Vec3f wi) {
    return std::visit([&](const auto& lobe) { return lobe.eval(wo, wi); }, model);
}
std::optional<LobeSample> sample(const LobeModel& model, Vec3f wo, Rng& rng) {
    const float choice = rng.next();
    return std::visit([&](const auto& lobe) { return lobe.sample(wo, choice, rng.next2()); }, model);
}

const std::vector<double> kAngles = {0, 30, 60, 80};

// False alarms: 1 % for the whole family (see chi_square.h).
TEST(Lobes, SamplesFollowTheirDensity) {
    const auto lobes = smooth_lobes();
    const double least = testing::significance(static_cast<int>(lobes.size() * kAngles.size()));
    std::uint64_t seed = 0;
    for (const NamedLobe& lobe : lobes) {
        for (const double angle : kAngles) {
            const Vec3f wo = at_angle(angle, 25);
            const testing::ChiSquare grid(Vec3f(0, 0, 1), 32, 24);
            const auto result = grid.run(
                [&](Rng& rng) -> std::optional<Vec3f> {
                    const auto drawn = sample(lobe.model, wo, rng);
                    return drawn ? std::optional(drawn->wi) : std::nullopt;
                },
                [&](Vec3f wi) { return static_cast<double>(eval(lobe.model, wo, wi).pdf); }, 40000, ++seed);
            EXPECT_GT(result.p_value, least)
                << lobe.name << " at " << angle << " degrees; chi-square " << result.statistic << " of "
                << result.degrees << " degrees of freedom";
            EXPECT_LE(result.integral, 1.002) << lobe.name << " at " << angle << " degrees";
        }
    }
}

// A sharp lobe needs cells that crowd around its direction.
TEST(Lobes, SharpReflectionFollowsItsDensity) {
    const std::vector<float> roughnesses = {0.05f, 0.1f};
    const double least = testing::significance(static_cast<int>(roughnesses.size() * kAngles.size()));
    for (const float roughness : roughnesses) {
        for (const double angle : kAngles) {
            const LobeModel model = Reflection{facets(roughness), Fresnel::constant(Rgb(1)), Rgb(1)};
            const Vec3f wo = at_angle(angle, 25);
            const testing::ChiSquare grid(Vec3f(-wo.x, -wo.y, wo.z), 48, 24, 2);
            const auto result = grid.run(
                [&](Rng& rng) -> std::optional<Vec3f> {
                    const auto drawn = sample(model, wo, rng);
                    return drawn ? std::optional(drawn->wi) : std::nullopt;
                },
                [&](Vec3f wi) { return static_cast<double>(eval(model, wo, wi).pdf); }, 40000, 1);
            EXPECT_GT(result.p_value, least) << roughness << " at " << angle;
        }
    }
}

TEST(Lobes, WeightIsEvalOverDensity) {
    Rng rng(7);
    for (const NamedLobe& lobe : smooth_lobes()) {
        for (const double angle : kAngles) {
            const Vec3f wo = at_angle(angle, 100);
            for (int i = 0; i < 200; ++i) {
                const auto drawn = sample(lobe.model, wo, rng);
                if (!drawn)
                    continue;
                const LobeValue value = eval(lobe.model, wo, drawn->wi);
                ASSERT_GT(drawn->pdf, 0) << lobe.name;
                ASSERT_TRUE(is_finite(drawn->weight)) << lobe.name;
                ASSERT_NEAR(length(drawn->wi), 1, 1e-5) << lobe.name;
                for (int c = 0; c < 3; ++c) {
                    EXPECT_NEAR(drawn->weight[c], value.f[c] / value.pdf, 2e-3 * (1 + drawn->weight[c]))
                        << lobe.name;
                }
                EXPECT_NEAR(drawn->pdf / value.pdf, 1, 5e-3) << lobe.name << " at " << angle;
            }
        }
    }
}

TEST(Lobes, ReflectionIsReciprocal) {
    Rng rng(3);
    for (const NamedLobe& lobe : smooth_lobes()) {
        if (!lobe.reciprocal)
            continue;
        for (int i = 0; i < 500; ++i) {
            const Vec3f a = sample_cosine_hemisphere(rng.next2()), b = sample_cosine_hemisphere(rng.next2());
            if (a.z < 0.02f || b.z < 0.02f)
                continue;
            const Rgb forward = eval(lobe.model, a, b).f / b.z, backward = eval(lobe.model, b, a).f / a.z;
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(forward[c], backward[c], 1e-3f * (1 + forward[c])) << lobe.name;
        }
    }
}

// Refraction obeys f(a, b) / eta_b^2 = f(b, a) / eta_a^2 (Walter et al. 2007): swapping the directions swaps
// the sides.
TEST(Lobes, RefractionIsReciprocalUpToTheSquaredIndex) {
    const float eta = 1.5f;
    const Microfacet m = facets(0.5f);
    const Dielectric into{m, Fresnel::dielectric(eta), eta, Rgb(1), Rgb(1), Rgb(1)};
    const Dielectric out{m, Fresnel::dielectric(1 / eta), 1 / eta, Rgb(1), Rgb(1), Rgb(1)};
    Rng rng(5);
    int compared = 0;
    for (int i = 0; i < 1000; ++i) {
        const Vec3f wo = sample_cosine_hemisphere(rng.next2());
        const auto drawn = into.sample(wo, 0.9f, rng.next2());
        if (!drawn || drawn->wi.z > -0.05f || wo.z < 0.05f)
            continue;
        const float forward = into.eval(wo, drawn->wi).f.x / -drawn->wi.z;
        const float backward =
            out.eval(-drawn->wi, -wo).f.x / wo.z;  // seen from the other side, its normal turned
        EXPECT_NEAR(forward / backward, eta * eta, 2e-3f * eta * eta);
        ++compared;
    }
    EXPECT_GT(compared, 500);
}

/// Mean weight over the lobe's own samples: its directional albedo. The standard error is below 0.25 %.
Rgb measured_albedo(const LobeModel& model, Vec3f wo) {
    Rng rng(11);
    double sum[3] = {};
    constexpr int kDraws = 100000;
    for (int i = 0; i < kDraws; ++i) {
        const auto drawn = sample(model, wo, rng);
        for (int c = 0; drawn && c < 3; ++c)
            sum[c] += static_cast<double>(drawn->weight[c]) / kDraws;
    }
    return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

TEST(Lobes, AlbedoIsWhatSamplingMeasuresAndNeverAboveOne) {
    for (const NamedLobe& lobe : smooth_lobes()) {
        // An estimate only: the tables are GGX's, and a metal's curve has no table at all.
        const bool estimated = lobe.name.find("beckmann") != std::string::npos ||
                               lobe.name.find("reflection") == 0 || lobe.name.find("refraction") == 0 ||
                               lobe.name.find("film") != std::string::npos;
        const bool unknown = lobe.name.find("velvet") == 0 || lobe.name.find("glossy toon") == 0;
        for (const double angle : kAngles) {
            const Vec3f wo = at_angle(angle);
            const Rgb measured = measured_albedo(lobe.model, wo);
            const Rgb claimed = std::visit([&](const auto& l) { return l.albedo(wo); }, lobe.model);
            EXPECT_LE(max_component(measured), 1.005f) << lobe.name << " at " << angle;
            if (!unknown) {
                EXPECT_NEAR(claimed.x, measured.x, estimated ? 0.16f : 0.015f)
                    << lobe.name << " at " << angle;
            }
        }
    }
}

TEST(Lobes, WhiteRoughDiffuseAndCompensatedReflectionLoseNothing) {
    for (const double angle : kAngles) {
        const Vec3f wo = at_angle(angle);
        for (const float roughness : {0.1f, 0.5f, 1.0f}) {
            EXPECT_NEAR(measured_albedo(RoughDiffuse{Rgb(1), roughness}, wo).x, 1, 0.01f)
                << roughness << " at " << angle;
            const Reflection mirror =
                make_reflection(Distribution::multi_ggx, roughness, Fresnel::constant(Rgb(1)), wo.z);
            EXPECT_NEAR(measured_albedo(mirror, wo).x, 1, 0.01f) << roughness << " at " << angle;
            for (const float eta : {1.5f, 1 / 1.5f, 1.1f, 2.4f}) {
                const Dielectric glass = make_dielectric(Distribution::multi_ggx, roughness, eta,
                                                         Fresnel::dielectric(eta), Rgb(1), Rgb(1), wo.z);
                EXPECT_NEAR(measured_albedo(glass, wo).x, 1, 0.025f)
                    << "eta " << eta << ", " << roughness << " at " << angle;
            }
        }
    }
}

TEST(Lobes, SmoothGlassIsLosslessExactly) {
    Rng rng(1);
    for (const float eta : {1.5f, 1 / 1.5f, 2.4f}) {
        const Dielectric glass{facets(0), Fresnel::dielectric(eta), eta, Rgb(1), Rgb(1), Rgb(1)};
        ASSERT_TRUE(glass.specular());
        for (const double angle : {0.0, 30.0, 60.0, 89.0}) {
            for (int i = 0; i < 100; ++i) {
                const auto drawn = glass.sample(at_angle(angle), rng.next(), rng.next2());
                ASSERT_TRUE(drawn) << eta << " at " << angle;
                EXPECT_NEAR(drawn->weight.x, 1, 1e-5);
            }
            EXPECT_NEAR(glass.albedo(at_angle(angle)).x, 1, 1e-5);
        }
    }
}

TEST(Lobes, SmoothGlassObeysSnellAndFresnel) {
    const Dielectric glass{facets(0), Fresnel::dielectric(1.5f), 1.5f, Rgb(1), Rgb(1), Rgb(1)};
    const Vec3f wo = at_angle(40);
    const auto through = glass.sample(wo, 0.999f, {0.5f, 0.5f});
    ASSERT_TRUE(through);
    EXPECT_NEAR(std::hypot(through->wi.x, through->wi.y), std::sin(40 * M_PI / 180) / 1.5, 1e-5);
    EXPECT_EQ(through->kind, kTransmissionRay);
    EXPECT_NEAR(fresnel_dielectric(1, 1.5f), 0.04, 1e-6);
    EXPECT_NEAR(fresnel_dielectric(std::cos(std::atan(1.5f)), 1.5f), 0.5 * sqr((2.25f - 1) / (2.25f + 1)),
                1e-5);                                 // Brewster
    EXPECT_EQ(fresnel_dielectric(0.5f, 1 / 1.5f), 1);  // beyond the critical angle of 41.8 degrees
    EXPECT_EQ(fresnel_dielectric(0, 1), 1);            // grazing, no interface: no NaN
}

TEST(Lobes, NearlySmoothAgreesWithSmooth) {
    // Just above the threshold of the specular branch, the rough branch draws the same directions.
    const Microfacet rough{2e-4f, false};
    const Dielectric glass{rough, Fresnel::dielectric(1.5f), 1.5f, Rgb(1), Rgb(1), Rgb(1)};
    Rng rng(2);
    for (const double angle : {0.0, 50.0, 80.0}) {
        const Vec3f wo = at_angle(angle);
        for (int i = 0; i < 200; ++i) {
            const auto drawn = glass.sample(wo, rng.next(), rng.next2());
            ASSERT_TRUE(drawn);
            EXPECT_NEAR(drawn->weight.x, 1, 2e-3);
            const Vec3f mirror(-wo.x, -wo.y, wo.z),
                refracted(-wo.x / 1.5f, -wo.y / 1.5f, -std::sqrt(1 - (1 - wo.z * wo.z) / 2.25f));
            EXPECT_LT(length(drawn->wi - (drawn->wi.z > 0 ? mirror : refracted)), 0.02f);
        }
    }
}

TEST(Lobes, SheenReflectsItsAlbedo) {
    for (const float roughness : {0.2f, 0.5f, 1.0f}) {
        for (const double angle : kAngles) {
            const Vec3f wo = at_angle(angle);
            const Sheen sheen(roughness, wo.z);
            // Part of the lobe lies below the horizon, and is cut off.
            const float measured = measured_albedo(sheen, wo).x;
            EXPECT_LE(measured, sheen.reflected + 1e-4f) << roughness << " at " << angle;
            EXPECT_NEAR(measured, sheen.reflected, 0.01f) << roughness << " at " << angle;
        }
    }
}

/// A brushed surface of alpha_x and alpha_y against its definition, in double.
TEST(Lobes, BrushedNormalsHaveTheirTwoRoughnesses) {
    const float along = 0.5f, across = 0.1f;
    const Microfacet m = Microfacet::brushed(std::sqrt(along * across), false, std::sqrt(along / across));
    for (const double theta : {0.0, 20.0, 60.0, 85.0}) {
        for (const double phi : {0.0, 35.0, 90.0}) {
            const Vec3f h = at_angle(theta, phi);
            const double x = double{h.x} / double{along}, y = double{h.y} / double{across}, z = double{h.z};
            const double expected =
                1 / (M_PI * double{along} * double{across} * std::pow(x * x + y * y + z * z, 2));
            EXPECT_NEAR(double{m.D(h)} / expected, 1, 1e-4) << theta << ' ' << phi;
        }
    }
    const Microfacet rough = Microfacet::brushed(0.25f, false, 100);
    EXPECT_NEAR(rough.alpha * rough.stretch, 1, 1e-5);  // neither is above 1
    EXPECT_NEAR(rough.alpha * rough.squeeze, 0.0025f, 1e-6);
}

TEST(Fresnel, FilmsThatAreNoneChangeNothing) {
    const Fresnel glass = Fresnel::dielectric(1.5f), gold = kGold;
    for (const float c : {1.0f, 0.7f, 0.2f}) {
        for (const Fresnel& bare : {glass, gold}) {
            const Rgb none = bare.under({0, 1.8f}).at(c), thin = bare.under({0.01f, 1.8f}).at(c),
                      air = bare.under({500, 1}).at(c), expected = bare.at(c);
            for (int k = 0; k < 3; ++k) {
                EXPECT_EQ(none[k], expected[k]);
                EXPECT_NEAR(thin[k], expected[k], 5e-3f) << c;
                EXPECT_NEAR(air[k], expected[k], 1e-4f) << c;
            }
        }
    }
    // So thick a film shows no colours: its two faces just reflect one after the other.
    const Rgb thick = glass.under({2e5f, 1.8f}).at(1);
    const float outer = f0_from_ior(1.8f), inner = f0_from_ior(1.5f / 1.8f);
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(thick[k], outer + (1 - outer) * (1 - outer) * inner / (1 - outer * inner), 1e-5f);
    // A quarter of a wavelength of the index between the two quenches the reflection there.
    EXPECT_LT(glass.under({550 / 4 / 1.2247f, 1.2247f}).at(1).y, 0.004f);
}

TEST(Fresnel, FilmsOnMetalsKeepTheMetal) {
    const Rgb f0(0.9f, 0.5f, 0.2f);
    const Fresnel conductor = Fresnel::metal(f0, {0.7f, 0.8f, 1}).under({1e-3f, 1.0f});
    for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(conductor.at(1)[k], f0[k], 2e-3f);
}

TEST(Fresnel, MetalHasItsColoursAtNormalAndEdgeAngles) {
    const Rgb f0(0.9f, 0.5f, 0.2f), tint(0.2f, 0.5f, 1.0f);
    const Fresnel metal = Fresnel::metal(f0, tint);
    EXPECT_NEAR(metal.at(1).y, 0.5f, 1e-6);
    const float schlick = 0.5f + 0.5f * std::pow(6.0f / 7, 5.0f);
    EXPECT_NEAR(metal.at(1.0f / 7).y, schlick * 0.5f, 1e-5);
    EXPECT_NEAR(metal.at(0).y, 1, 1e-6);
}

TEST(Fresnel, MeansAreTheIntegrals) {
    for (const Fresnel& curve :
         {Fresnel::metal({0.9f, 0.5f, 0.2f}, {0.4f, 0.7f, 1}), Fresnel::dielectric(1.5f),
          Fresnel::dielectric(2.5f), Fresnel::dielectric(1 / 1.5f)}) {
        double sum = 0;
        constexpr int kSteps = 2000;
        for (int i = 0; i < kSteps; ++i) {
            const double c = (i + 0.5) / kSteps;
            sum += 2 * c * static_cast<double>(curve.at(static_cast<float>(c)).x) / kSteps;
        }
        EXPECT_NEAR(curve.mean().x, sum, 0.01);  // the dielectrics' means are a published fit
    }
}

TEST(DirectionalAlbedo, LimitsAreRight) {
    EXPECT_NEAR(reflection_albedo(0.5f, 0), 1, 1e-6);
    EXPECT_NEAR(mean_reflection_albedo(0), 1, 1e-6);
    EXPECT_LT(reflection_albedo(1, 1), 0.7f);
    const auto [reflected, transmitted] = dielectric_albedo(1, 0.05f, 1.5f);
    EXPECT_NEAR(reflected, 0.04f, 0.002f);
    EXPECT_NEAR(transmitted, 0.96f, 0.01f);
}

}  // namespace
}  // namespace nephele
