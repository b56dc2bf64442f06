// SPDX-License-Identifier: GPL-3.0-or-later
// Mixtures: what shading programs become at a point. Sampling against density with specular and
// straight-through lobes among them, energy, limits of the Principled BSDF, shading normals, emission,
// transparency, traits.
#include "surfaces/bsdf.h"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

#include "chi_square.h"
#include "surface_fixtures.h"
#include "surfaces/principled.h"

namespace nephele {
namespace {

using testing::at_angle;
using testing::ConstantProgram;
using testing::kNoNormal;
using testing::point_seen_from;
using testing::PrincipledInputs;

const std::vector<double> kAngles = {0, 45, 80};
const TextureContext kNoTextures;

struct NamedProgram {
    std::string name;
    Program program;
};

Vec3f s(float v) {
    return Vec3f(v);
}

std::vector<NamedProgram> mixtures() {
    const Vec3f color(0.9f, 0.5f, 0.2f);
    return {
        {"default principled", PrincipledInputs{}.program()},
        {"metal", PrincipledInputs{.base_color = color, .metallic = 1, .roughness = 0.4f}.program()},
        {"half metal, coat, sheen", PrincipledInputs{.base_color = color,
                                                     .metallic = 0.5f,
                                                     .roughness = 0.6f,
                                                     .coat = 1,
                                                     .coat_roughness = 0.3f,
                                                     .sheen = 1}
                                        .program()},
        {"half glass",
         PrincipledInputs{.base_color = color, .roughness = 0.5f, .transmission = 0.5f}.program()},
        {"alpha and a smooth coat",
         PrincipledInputs{.base_color = color, .alpha = 0.6f, .coat = 1, .coat_roughness = 0}.program()},
        {"brushed, filmed, roughly diffuse metal", PrincipledInputs{.base_color = color,
                                                                    .metallic = 0.6f,
                                                                    .roughness = 0.6f,
                                                                    .diffuse_roughness = 0.5f,
                                                                    .anisotropic = 0.7f,
                                                                    .anisotropic_rotation = 0.1f,
                                                                    .film_thickness = 300}
                                                       .program()},
        {"half below the surface", PrincipledInputs{.base_color = color, .subsurface = 0.5f}.program()},
        {"brushed, toon, velvet, sheen",
         ConstantProgram()
             .add(ClosureKind::brushed, {color, s(0.6f), s(-0.4f), s(0.2f), kNoNormal, {1, 0, 0}},
                  Distribution::multi_ggx, 0.3f)
             .add(ClosureKind::toon_glossy, {color, s(0.3f), s(0.3f), kNoNormal}, Distribution::ggx, 0.2f)
             .add(ClosureKind::toon_diffuse, {color, s(0.6f), s(0), kNoNormal}, Distribution::ggx, 0.2f)
             .add(ClosureKind::velvet, {color, s(0.7f), kNoNormal}, Distribution::ggx, 0.2f)
             .add(ClosureKind::sheen, {color, s(0.7f), kNoNormal}, Distribution::ggx, 0.2f)
             .program},
        {"conductor, filmed glass, metal",
         ConstantProgram()
             .add(ClosureKind::conductor,
                  {Vec3f(0.2f, 0.5f, 1.4f),
                   Vec3f(3, 2, 1),
                   s(0.5f),
                   s(0.3f),
                   s(0.4f),
                   kNoNormal,
                   {1, 0, 0},
                   s(0),
                   s(1.33f)},
                  Distribution::multi_ggx, 0.3f)
             .add(ClosureKind::filmed_glass, {color, s(0.5f), s(1.5f), kNoNormal, s(400), s(1.7f)},
                  Distribution::multi_ggx, 0.4f)
             .add(ClosureKind::metal,
                  {color, s(0.8f), s(0.6f), s(0.5f), s(0), kNoNormal, kNoNormal, s(250), s(1.5f)},
                  Distribution::beckmann, 0.3f)
             .program},
        {"diffuse and mirror",
         ConstantProgram()
             .add(ClosureKind::diffuse, {color, s(0), kNoNormal}, Distribution::ggx, 0.5f)
             .add(ClosureKind::glossy, {s(0.8f), s(0), kNoNormal}, Distribution::ggx, 0.5f)
             .program},
        {"diffuse, translucent, transparent",
         ConstantProgram()
             .add(ClosureKind::diffuse, {color, s(0.7f), kNoNormal}, Distribution::ggx, 0.4f)
             .add(ClosureKind::translucent, {color, kNoNormal}, Distribution::ggx, 0.3f)
             .add(ClosureKind::transparent, {color}, Distribution::ggx, 0.3f)
             .program},
        {"plastic",
         ConstantProgram().add(ClosureKind::plastic, {color, s(0), s(1.5f), s(0), kNoNormal}).program},
        {"rough plastic",
         ConstantProgram()
             .add(ClosureKind::plastic, {color, s(0.4f), s(1.5f), s(1), kNoNormal}, Distribution::beckmann)
             .program},
        {"rough glass and glossy",
         ConstantProgram()
             .add(ClosureKind::glass, {color, s(0.5f), s(1.45f), kNoNormal}, Distribution::multi_ggx, 0.5f)
             .add(ClosureKind::glossy, {color, s(0.4f), kNoNormal}, Distribution::beckmann, 0.3f)
             .add(ClosureKind::refraction, {color, s(0.6f), s(1.2f), kNoNormal}, Distribution::ggx, 0.2f)
             .program},
    };
}

// False alarms: 1 % for the whole family (see chi_square.h). Specular and straight-through draws count as no
// direction, so that the density must hold their probability.
TEST(Bsdf, SmoothSamplesFollowTheMixtureDensity) {
    const auto programs = mixtures();
    const double least = testing::significance(static_cast<int>(2 * programs.size() * kAngles.size()));
    for (const NamedProgram& p : programs) {
        for (const bool backfacing : {false, true}) {
            for (const double angle : kAngles) {
                ShadingPoint point = point_seen_from(at_angle(angle, 25), backfacing);
                point.ns = at_angle(10, 200);  // a shading normal off the face's
                const Bsdf bsdf = make_bsdf(&p.program, point, kNoTextures);
                const testing::ChiSquare grid(Vec3f(0, 0, 1), 24, 24);
                const auto result = grid.run(
                    [&](Rng& rng) -> std::optional<Vec3f> {
                        const float lobe_u = rng.next();
                        const auto drawn = bsdf.sample(point.wo, lobe_u, rng.next2());
                        return drawn && !drawn->specular ? std::optional(drawn->wi) : std::nullopt;
                    },
                    [&](Vec3f wi) {
                        float pdf;
                        bool crosses;
                        bsdf.eval(point.wo, wi, pdf, crosses);
                        return static_cast<double>(pdf);
                    },
                    40000, 1);
                EXPECT_GT(result.p_value, least)
                    << p.name << (backfacing ? " (back)" : "") << " at " << angle;
                EXPECT_LE(result.integral, 1.002) << p.name << " at " << angle;
            }
        }
    }
}

TEST(Bsdf, WeightIsEvalOverDensity) {
    Rng rng(5);
    for (const NamedProgram& p : mixtures()) {
        for (const double angle : kAngles) {
            const ShadingPoint point = point_seen_from(at_angle(angle));
            const Bsdf bsdf = make_bsdf(&p.program, point, kNoTextures);
            for (int i = 0; i < 300; ++i) {
                const float lobe_u = rng.next();
                const auto drawn = bsdf.sample(point.wo, lobe_u, rng.next2());
                if (!drawn)
                    continue;
                ASSERT_TRUE(is_finite(drawn->weight)) << p.name;
                ASSERT_GE(min_component(drawn->weight), 0) << p.name;
                if (drawn->specular)
                    continue;
                float pdf;
                bool crosses;
                const Rgb f = bsdf.eval(point.wo, drawn->wi, pdf, crosses);
                EXPECT_EQ(crosses, drawn->crosses) << p.name;
                EXPECT_NEAR(drawn->pdf / pdf, 1, 2e-3) << p.name;
                for (int c = 0; c < 3; ++c)
                    EXPECT_NEAR(drawn->weight[c], f[c] / pdf, 2e-3 * (1 + drawn->weight[c])) << p.name;
            }
        }
    }
}

/// The ray kinds of directions that something else drew are as frequent as sample()'s: a z-test a kind,
/// false alarm 6e-7 each.
TEST(Bsdf, GivenDirectionsAreTheSamplesTheyStandFor) {
    Rng rng(6);
    constexpr int kDraws = 20000;
    for (const NamedProgram& p : mixtures()) {
        const ShadingPoint point = point_seen_from(at_angle(45));
        const Bsdf bsdf = make_bsdf(&p.program, point, kNoTextures);
        std::map<std::uint32_t, double> excess;
        int smooth = 0;
        for (int i = 0; i < kDraws; ++i) {
            const float lobe_u = rng.next();
            const auto drawn = bsdf.sample(point.wo, lobe_u, rng.next2());
            if (!drawn || drawn->specular)
                continue;
            const auto given = bsdf.at(point.wo, drawn->wi, rng.next());
            ASSERT_TRUE(given.has_value()) << p.name;
            EXPECT_EQ(given->crosses, drawn->crosses) << p.name;
            EXPECT_NEAR(given->pdf / drawn->pdf, 1, 2e-3) << p.name;
            EXPECT_FALSE(given->specular);
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(given->weight[c], drawn->weight[c], 4e-3 * (1 + drawn->weight[c])) << p.name;
            excess[drawn->kind] += 1;
            excess[given->kind] -= 1;
            ++smooth;
        }
        for (const auto& [kind, difference] : excess)
            EXPECT_LT(std::abs(difference), 5 * std::sqrt(2.0 * smooth / 4)) << p.name << ", kind " << kind;
    }
}

TEST(Bsdf, NothingIsGivenWhereNothingScatters) {
    const Bsdf mirror =
        make_bsdf(&ConstantProgram().add(ClosureKind::glossy, {s(0.8f), s(0), kNoNormal}).program,
                  point_seen_from(at_angle(30)), kNoTextures);
    EXPECT_FALSE(mirror.at(at_angle(30), at_angle(30, 180), 0.5f).has_value());
    const Bsdf diffuse = make_bsdf(nullptr, point_seen_from(at_angle(30)), kNoTextures);
    EXPECT_FALSE(diffuse.at(at_angle(30), -at_angle(30), 0.5f).has_value());
}

/// Share of light from everywhere that leaves along wo: the mean weight, straight-through samples included.
Rgb furnace(const Program& program, const ShadingPoint& point, int draws = 40000) {
    const Bsdf bsdf = make_bsdf(&program, point, kNoTextures);
    Rng rng(9);
    double sum[3] = {};
    for (int i = 0; i < draws; ++i) {
        const float lobe_u = rng.next();
        const auto drawn = bsdf.sample(point.wo, lobe_u, rng.next2());
        for (int c = 0; drawn && c < 3; ++c)
            sum[c] += static_cast<double>(drawn->weight[c]) / draws;
    }
    return {static_cast<float>(sum[0]), static_cast<float>(sum[1]), static_cast<float>(sum[2])};
}

TEST(Bsdf, NoPrincipledSurfaceGainsEnergy) {
    for (const float roughness : {0.0f, 0.2f, 0.5f, 1.0f}) {
        for (const double angle : {0.0, 45.0, 80.0, 88.0}) {
            const ShadingPoint point = point_seen_from(at_angle(angle));
            for (const PrincipledInputs& p : std::initializer_list<PrincipledInputs>{
                     {.base_color = s(1), .roughness = roughness},
                     {.base_color = s(1), .metallic = 1, .roughness = roughness},
                     {.base_color = s(1), .metallic = 1, .roughness = roughness, .anisotropic = 1},
                     {.base_color = s(1),
                     .roughness = roughness,
                     .diffuse_roughness = 1,
                     .subsurface = 0.5f,
                     .film_thickness = 500,
                     .film_ior = 2},
                     {.base_color = s(1), .roughness = roughness, .transmission = 1, .film_thickness = 300},
                     {.base_color = s(1), .roughness = roughness, .transmission = 1},
                     {.base_color = s(1),
                     .metallic = 0.3f,
                     .roughness = roughness,
                     .transmission = 0.5f,
                     .coat = 1,
                     .sheen = 1},
                     {.base_color = s(1),
                     .roughness = roughness,
                     .alpha = 0.5f,
                     .coat = 0.5f,
                     .coat_roughness = 0.5f}}) {
                // The standard error is below 0.5 %; the layers' albedos are tabulated to about 1 %.
                // What brushing loses is taken from a table of isotropic facets, what films do from their
                // curve.
                const float most = p.anisotropic > 0 ? 1.065f : p.film_thickness > 0 ? 1.03f : 1.02f;
                EXPECT_LE(max_component(furnace(p.program(), point)), most)
                    << "roughness " << roughness << ", metallic " << p.metallic << ", transmission "
                    << p.transmission << ", coat " << p.coat << " at " << angle;
            }
        }
    }
}

TEST(Bsdf, WhitePrincipledReturnsNearlyAllLight) {
    for (const float roughness : {0.1f, 0.5f, 1.0f}) {
        for (const double angle : kAngles) {
            const ShadingPoint point = point_seen_from(at_angle(angle));
            const Rgb white =
                furnace(PrincipledInputs{.base_color = s(1), .roughness = roughness}.program(), point);
            EXPECT_NEAR(white.x, 1, 0.02f) << roughness << " at " << angle;
        }
    }
}

/// Directional albedos of Cycles 5.0 (Blender's bpy 5.0.1): one plane under a sky of radiance 1, orthographic
/// camera at the angle, 65536 samples, mean of the picture. Lower: the light that comes through from below.
struct CyclesAlbedo {
    std::string name;
    Program program;
    double angle;
    Rgb upper, lower;
};

TEST(Bsdf, AlbedosAgreeWithCycles) {
    const Vec3f color(0.9f, 0.5f, 0.2f), tint(0.2f, 0.5f, 1.0f);
    const auto glass = [](float roughness, Distribution d) {
        return ConstantProgram().add(ClosureKind::glass, {s(1), s(roughness), s(1.5f), kNoNormal}, d).program;
    };
    const auto glossy = [&](float roughness, Distribution d) {
        return ConstantProgram().add(ClosureKind::glossy, {color, s(roughness), kNoNormal}, d).program;
    };
    const auto diffuse = [&](float roughness) {
        return ConstantProgram().add(ClosureKind::diffuse, {color, s(roughness), kNoNormal}).program;
    };
    const CyclesAlbedo table[] = {
#include "cycles_albedos.inc"
    };
    for (const CyclesAlbedo& row : table) {
        const ShadingPoint point = point_seen_from(at_angle(row.angle));
        const Bsdf bsdf = make_bsdf(&row.program, point, kNoTextures);
        Rng rng(4);
        Rgb upper, lower;
        constexpr int kDraws = 1 << 17;
        for (int i = 0; i < kDraws; ++i) {
            const float lobe_u = rng.next();
            const auto drawn = bsdf.sample(point.wo, lobe_u, rng.next2());
            if (drawn)
                (drawn->wi.z > 0 ? upper : lower) += drawn->weight * (1.0f / kDraws);
        }
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(upper[c], row.upper[c], 0.012f)
                << row.name << " at " << row.angle << ", channel " << c;
            EXPECT_NEAR(lower[c], row.lower[c], 0.012f)
                << row.name << " at " << row.angle << ", channel " << c;
        }
    }
}

TEST(Bsdf, PrincipledLimits) {
    const ShadingPoint point = point_seen_from(at_angle(30));
    const Vec3f mirror = at_angle(30, 180), color(0.9f, 0.5f, 0.2f);

    const Program metal = PrincipledInputs{.base_color = color, .metallic = 1, .roughness = 0}.program();
    const Bsdf metal_bsdf = make_bsdf(&metal, point, kNoTextures);
    EXPECT_FALSE(metal_bsdf.has_smooth());
    const auto reflected = metal_bsdf.sample(point.wo, 0.3f, {0.2f, 0.7f});
    ASSERT_TRUE(reflected && reflected->specular);
    EXPECT_LT(length(reflected->wi - mirror), 1e-5f);
    EXPECT_NEAR(reflected->weight.y, 0.5f, 0.01f);
    EXPECT_EQ(reflected->kind, kGlossyRay);

    const Program plain =
        PrincipledInputs{.base_color = color, .roughness = 0.5f, .specular_ior_level = 0}.program();
    const Bsdf lambert = make_bsdf(&plain, point, kNoTextures);
    float pdf;
    bool crosses;
    const Vec3f wi = at_angle(50, 70);
    const Rgb f = lambert.eval(point.wo, wi, pdf, crosses);
    EXPECT_FALSE(crosses);
    EXPECT_NEAR(f.x, 0.9f * kInvPi * wi.z, 1e-6);
    EXPECT_NEAR(pdf, kInvPi * wi.z, 1e-6);

    const Program clear = PrincipledInputs{.base_color = color, .alpha = 0}.program();
    const Bsdf nothing = make_bsdf(&clear, point, kNoTextures);
    const auto through = nothing.sample(point.wo, 0.99f, {0.5f, 0.5f});
    ASSERT_TRUE(through && through->specular);
    EXPECT_EQ(through->kind, 0u);
    EXPECT_EQ(through->wi, -point.wo);
    EXPECT_EQ(through->weight, Rgb(1));

    const Program glass = PrincipledInputs{.base_color = s(1), .roughness = 0, .transmission = 1}.program();
    const Program closure =
        ConstantProgram().add(ClosureKind::glass, {s(1), s(0), s(1.5f), kNoNormal}).program;
    const Bsdf a = make_bsdf(&glass, point, kNoTextures), b = make_bsdf(&closure, point, kNoTextures);
    for (const float u : {0.01f, 0.5f}) {
        const auto x = a.sample(point.wo, u, {0.5f, 0.5f}), y = b.sample(point.wo, u, {0.5f, 0.5f});
        ASSERT_TRUE(x && y);
        EXPECT_LT(length(x->wi - y->wi), 1e-6f);
        EXPECT_NEAR(x->weight.x, y->weight.x, 1e-5f);
    }
}

/// Draws under shading normals anywhere on the viewer's side of the face.
template <class Visit>
void draw_under_any_normal(const Program& program, Visit&& visit) {
    Rng rng(8);
    for (int i = 0; i < 2000; ++i) {
        ShadingPoint point = point_seen_from(sample_cosine_hemisphere(rng.next2()));
        point.ns = sample_cosine_hemisphere(rng.next2());
        if (point.wo.z < 1e-3f || std::fabs(dot(point.ns, point.wo)) < 1e-3f)
            continue;
        const Bsdf bsdf = make_bsdf(&program, point, kNoTextures);
        const float lobe_u = rng.next();
        visit(point, bsdf.sample(point.wo, lobe_u, rng.next2()));
    }
}

TEST(Bsdf, ReflectionNeverLeavesBeyondTheSurface) {
    for (const NamedProgram& p : mixtures()) {
        const bool dielectric = p.name.find("glass") != std::string::npos;
        draw_under_any_normal(p.program, [&](const ShadingPoint&, const std::optional<BsdfSample>& drawn) {
            if (!drawn || drawn->kind == 0 || drawn->below)
                return;
            ASSERT_TRUE(is_finite(drawn->weight)) << p.name;
            if (!dielectric) {
                EXPECT_EQ(drawn->crosses, drawn->kind == kTransmissionRay) << p.name;
            }
        });
    }
}

TEST(Bsdf, ShadingNormalsLoseNoLight) {
    const NamedProgram white[] = {
        {"diffuse", ConstantProgram().add(ClosureKind::diffuse, {s(1), s(0), kNoNormal}).program},
        {"translucent", ConstantProgram().add(ClosureKind::translucent, {s(1), kNoNormal}).program},
        {"mirror", ConstantProgram().add(ClosureKind::glossy, {s(1), s(0), kNoNormal}).program},
        {"glass", ConstantProgram().add(ClosureKind::glass, {s(1), s(0), s(1.5f), kNoNormal}).program},
        {"clear", PrincipledInputs{.base_color = s(1), .roughness = 0, .transmission = 1}.program()},
    };
    for (const NamedProgram& p : white) {
        draw_under_any_normal(p.program,
                              [&](const ShadingPoint& point, const std::optional<BsdfSample>& drawn) {
                                  ASSERT_TRUE(drawn) << p.name;
                                  EXPECT_NEAR(drawn->weight.x, 1, 1e-4f) << p.name;
                                  if (p.name == "glass" || p.name == "clear") {
                                      EXPECT_EQ(drawn->crosses, dot(drawn->wi, point.ng) < 0) << p.name;
                                  }
                              });
    }
}

TEST(Bsdf, BentNormalsMirrorAboveTheSurface) {
    Rng rng(6);
    const Vec3f ng(0, 0, 1);
    for (int i = 0; i < 5000; ++i) {
        const Vec3f wo = sample_cosine_hemisphere(rng.next2()), n = sample_sphere(rng.next2());
        if (wo.z < 1e-3f)
            continue;
        const Vec3f bent = bent_normal(n, ng, wo), mirror = 2 * dot(wo, bent) * bent - wo;
        EXPECT_NEAR(length(bent), 1, 1e-4);
        EXPECT_GT(mirror.z, 0);
        EXPECT_GT(dot(bent, wo), 0);
        if (dot(n, wo) > 0 && (2 * dot(wo, n) * n - wo).z > 0.01f) {
            EXPECT_EQ(bent, n);
        }
    }
}

TEST(Bsdf, DefaultIsGreyDiffuse) {
    const ShadingPoint point = point_seen_from(at_angle(20));
    const Bsdf bsdf = make_bsdf(nullptr, point, kNoTextures);
    EXPECT_TRUE(bsdf.has_smooth());
    EXPECT_EQ(bsdf.albedo(point.wo), Rgb(0.8f));
    EXPECT_EQ(bsdf.transparency, Rgb(0));
    EXPECT_TRUE(default_traits().has_surface_lobes && !default_traits().emissive);
}

TEST(Bsdf, EmissionAndTransparencyNeedNoLobes) {
    const ShadingPoint point = point_seen_from(at_angle(40));
    for (const PrincipledInputs& p :
         std::initializer_list<PrincipledInputs>{{.emission_color = {1, 0.5f, 0.25f}, .emission_strength = 4},
                                                 {.alpha = 0.25f,
                                                 .coat = 1,
                                                 .coat_tint = {0.9f, 0.5f, 0.2f},
                                                 .sheen = 0.5f,
                                                 .emission_strength = 3}}) {
        const Program program = p.program();
        const Bsdf bsdf = make_bsdf(&program, point, kNoTextures);
        const Rgb emission = evaluate_emission(program, point, kNoTextures);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(emission[c], bsdf.emission[c], 1e-5f);
        EXPECT_EQ(evaluate_transparency(program, point, kNoTextures), bsdf.transparency);
    }
    const Program bare =
        PrincipledInputs{.emission_color = {1, 0.5f, 0.25f}, .emission_strength = 4}.program();
    EXPECT_EQ(evaluate_emission(bare, point, kNoTextures), Rgb(4, 2, 1));
    // Cycles: 84.29, 43.30, 15.35 of 100 leave through a tinted coat of roughness 0.1 at 45 degrees.
    const Program coated = PrincipledInputs{.base_color = s(0),
                                            .roughness = 0.1f,
                                            .specular_ior_level = 0,
                                            .coat = 1,
                                            .coat_roughness = 0.1f,
                                            .coat_tint = {0.9f, 0.5f, 0.2f},
                                            .emission_strength = 100}
                               .program();
    const Rgb seen = evaluate_emission(coated, point_seen_from(at_angle(45)), kNoTextures);
    EXPECT_NEAR(seen.x, 84.29f, 0.5f);
    EXPECT_NEAR(seen.y, 43.30f, 0.5f);
    EXPECT_NEAR(seen.z, 15.35f, 0.5f);
}

TEST(Bsdf, InfinitiesAndNanFromNodesAreNotPassedOn) {
    const ShadingPoint point = point_seen_from(at_angle(40));
    const Program program = ConstantProgram()
                                .add(ClosureKind::diffuse, {{INFINITY, -1, 0.5f}, s(0), kNoNormal})
                                .add(ClosureKind::emission, {{1, INFINITY, 1}, s(2)})
                                .program;
    const Bsdf bsdf = make_bsdf(&program, point, kNoTextures);
    EXPECT_EQ(bsdf.emission, Rgb(2, 0, 2));
    EXPECT_EQ(bsdf.albedo(point.wo), Rgb(0, 0, 0.5f));
}

TEST(Traits, SayWhatAProgramCanDo) {
    const ProgramTraits plain = traits_of(PrincipledInputs{}.program());
    EXPECT_TRUE(plain.constant && plain.has_surface_lobes && !plain.emissive && !plain.may_transmit_straight);
    EXPECT_EQ(plain.constant_emission, Rgb(0));

    const ProgramTraits lamp =
        traits_of(ConstantProgram().add(ClosureKind::emission, {{1, 2, 3}, s(2)}).program);
    EXPECT_TRUE(lamp.emissive && !lamp.has_surface_lobes);
    EXPECT_EQ(lamp.constant_emission, Rgb(2, 4, 6));

    const ProgramTraits coated =
        traits_of(PrincipledInputs{.alpha = 0.5f, .coat = 1, .emission_strength = 2}.program());
    EXPECT_TRUE(coated.emissive && coated.may_transmit_straight && !coated.constant_emission);

    Program driven = ConstantProgram().add(ClosureKind::transparent, {s(0)}).program;
    EXPECT_FALSE(traits_of(driven).may_transmit_straight);
    Instruction step;
    step.op = static_cast<std::int32_t>(Op::backfacing);
    step.dst = driven.closures[0].inputs[0];
    driven.code.push_back(step);
    EXPECT_TRUE(traits_of(driven).may_transmit_straight);
    EXPECT_FALSE(traits_of(driven).constant);
}

}  // namespace
}  // namespace nephele
