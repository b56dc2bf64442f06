// SPDX-License-Identifier: GPL-3.0-or-later
// Fresnel terms, microfacets and the lobes made of them.
#include "stability.h"
#include "surface_fixtures.h"
#include "surfaces/fresnel.h"
#include "surfaces/lobes.h"
#include "surfaces/microfacet.h"
#include "surfaces/principled.h"

namespace nephele::stability {
namespace {

Exact exact(float x) {
    return static_cast<Exact>(x);
}
Exact squared(Exact x) {
    return x * x;
}

/// Indices from 1e-5 to 1e5, most of them about 1.
std::vector<float> indices() {
    std::vector<float> out{1, 1.33f, 1.5f};
    for (const float off : logarithmic(1e-7, 0.5, 60)) {
        out.push_back(1 + off);
        out.push_back(1 - off);
    }
    return joined(out, joined(logarithmic(1e-5, 0.5, 30), logarithmic(2, 1e5, 30)));
}
Exact reflectance(Exact cosine, Exact eta) {
    const Exact sin2 = (1 - cosine) * (1 + cosine) / (eta * eta);
    if (sin2 >= 1)
        return 1;
    const Exact t = std::sqrt(1 - sin2);
    return (squared((cosine - eta * t) / (cosine + eta * t)) +
            squared((eta * cosine - t) / (eta * cosine + t))) /
           2;
}

TEST(StabilitySurfaces, Fresnel) {
    Worst worst({"surfaces", "fresnel.h", "dielectric reflectance",
                 "1 - sin^2 / n^2 cancels at grazing angles for indices near 1",
                 "(n - 1) (n + 1) + cos^2 there, n^2 - (1 - cos) (1 + cos) near the normal",
                 "cosines 1e-7 to 1, indices 1e-5 to 1e5, 1 +- 1e-7; not within 1e-6 of total reflection",
                 "1", 7e-7});
    for (const float eta : indices()) {
        for (const float c : joined({1.0f}, joined(logarithmic(1e-7, 1, 60), towards_both_ends(1e-7, 40)))) {
            const Exact sin2 = (1 - exact(c)) * (1 + exact(c)) / squared(exact(eta));
            if (std::fabs(sin2 - 1) > 1e-6L)
                worst.scaled(double{fresnel_dielectric(c, eta)}, reflectance(exact(c), exact(eta)), 1,
                             {c, eta});
        }
    }
}

TEST(StabilitySurfaces, FresnelRemapped) {
    Worst worst({"surfaces", "fresnel.h", "Fresnel curve moved to another reflectance at normal incidence",
                 "(F - F0) / (1 - F0) is 0 / 0 for a large index",
                 "1 - F0 as 4 n / (n + 1)^2; F0 where even that is 0",
                 "indices 1e-3 to 1e3, and finite from 1e-5 to 1e10", "1", 1e-5});
    const Rgb f0(0.2f, 0.5f, 0.04f);
    for (const float eta : joined({1e8f, 1e10f}, indices())) {
        for (const float c : joined({1.0f}, logarithmic(1e-3, 1, 40))) {
            const Rgb got = Fresnel::dielectric(eta, f0).at(c);
            ASSERT_TRUE(got.x >= 0.2f - 1e-6f && got.x <= 1 + 1e-6f) << eta << ' ' << c;
            if (eta > 1e3f || eta < 1e-3f)
                continue;
            const Exact n = exact(eta), real = squared((n - 1) / (n + 1));
            const Exact x = std::fmin(std::fmax((reflectance(exact(c), n) - real) / (1 - real), 0.0L), 1.0L);
            worst.error(exact(got.x) - (exact(0.2f) + (1 - exact(0.2f)) * x), {c, eta});
        }
    }
}

TEST(StabilitySurfaces, FresnelMean) {
    Worst worst({"surfaces", "fresnel.h", "mean dielectric reflectance, in closed form",
                 "the terms cancel for indices near 1", "in double; below 1.0001 the leading term",
                 "indices 1 + 1e-7 to 1e3", "1", 5e-8});
    for (const float eta : joined(logarithmic(1.5, 1e3, 20),
                                  {1 + 1e-6f, 1 + 1e-5f, 1 + 0.9e-4f, 1 + 1.1e-4f, 1.001f, 1.01f, 1.1f})) {
        // Simpson's rule in c = x^3: the reflectance is steep at grazing angles.
        constexpr int kSteps = 20000;
        Exact sum = 0;
        for (int i = 0; i <= kSteps; ++i) {
            const Exact x = static_cast<Exact>(i) / kSteps, c = x * x * x,
                        weight = i == 0 || i == kSteps ? 1
                                 : i % 2               ? 4
                                                       : 2;
            sum += weight * (i == 0 ? 0 : 2 * reflectance(c, exact(eta)) * c * 3 * x * x);
        }
        worst.scaled(double{exact_fresnel_dielectric_mean(eta)}, sum / (3 * kSteps), 1, {eta});
    }
}

TEST(StabilitySurfaces, PathThroughCoat) {
    Worst worst({"surfaces", "fresnel.h", "path through a coat, 1 / sqrt(1 - sin^2 / n^2)",
                 "cancels at grazing angles for indices near 1, down to 1 / 0",
                 "n / sqrt((n - 1) (n + 1) + cos^2)", "cosines 1e-7 to 1, indices 1 to 1e5", "the path",
                 2e-7});
    for (const float eta : indices()) {
        for (const float c : logarithmic(1e-7, 1, 100)) {
            if (eta >= 1) {
                worst.relative(
                    double{path_through_coat(c, eta)},
                    exact(eta) / std::sqrt((exact(eta) - 1) * (exact(eta) + 1) + squared(exact(c))),
                    {c, eta});
            }
        }
    }
}

std::vector<float> alphas() {
    return joined({Microfacet::kSpecularAlpha}, logarithmic(1e-4, 1, 30));
}
std::vector<float> polar_angles() {
    std::vector<float> out = logarithmic(1e-7, 1.5, 60);
    for (const float above : logarithmic(1e-7, 0.1, 20))
        out.push_back(kPi / 2 - above);
    return out;
}

TEST(StabilitySurfaces, NormalDistribution) {
    Worst ggx({"surfaces", "microfacet.h", "GGX: density of normals",
               "tan^2 at the horizon is 1 / 0; alpha^4", "without a tangent: alpha cos^2 + sin^2 / alpha",
               "alpha 1e-4 to 1, angles 1e-7 to the horizon", "the density", 5e-7});
    Worst beckmann({"surfaces", "microfacet.h", "Beckmann: density of normals", "0 / 0 at the horizon",
                    "0 where the exponential is", "the same, densities from 1e-30 of the peak",
                    "the density, per unit of its exponent", 3e-7});
    for (const float alpha : alphas()) {
        for (const float theta : polar_angles()) {
            const Vec3f h = at_angle(double{theta}, 0.7);
            const Exact a = exact(alpha), cos2 = squared(exact(h.z)),
                        sin2 = squared(exact(h.x)) + squared(exact(h.y));
            ggx.relative(double{Microfacet{alpha, false}.D(h)}, 1 / (kExactPi * squared(a * cos2 + sin2 / a)),
                         {alpha, theta});
            const Exact exponent = sin2 / (a * a * cos2);
            const float got = Microfacet{alpha, true}.D(h);
            EXPECT_TRUE(got >= 0 && std::isfinite(got));
            if (exponent < 69)
                beckmann.error(
                    (exact(got) * (kExactPi * squared(a * cos2)) / std::exp(-exponent) - 1) / (1 + exponent),
                    {alpha, theta});
        }
    }
    for (const bool kind : {false, true}) {
        for (const float alpha : alphas())
            EXPECT_GE((Microfacet{alpha, kind}.D({1, 0, 0})), 0) << alpha;
    }
}

TEST(StabilitySurfaces, Shadowing) {
    Worst worst({"surfaces", "microfacet.h", "Smith's 1 + Lambda",
                 "1 / 0 at the horizon; erfc and exp cancel",
                 "cos^2 at least 1e-36; what cancels is far below 1",
                 "alpha 1e-4 to 1, angles 1e-7 to the horizon, and cosines to 1e-30", "1 + Lambda", 5e-7});
    for (const float alpha : alphas()) {
        for (const float theta : polar_angles()) {
            const Vec3f w = at_angle(double{theta}, 0.7);
            const Exact tan2 =
                squared(exact(alpha)) * (squared(exact(w.x)) + squared(exact(w.y))) / squared(exact(w.z));
            worst.relative(1 + double{Microfacet{alpha, false}.Lambda(w)}, 0.5L + std::sqrt(1 + tan2) / 2,
                           {alpha, theta});
            const Exact a = 1 / std::sqrt(tan2);
            const Exact lambda = (std::exp(-a * a) / (a * std::sqrt(kExactPi)) - std::erfc(a)) / 2;
            worst.relative(1 + double{Microfacet{alpha, true}.Lambda(w)}, 1 + lambda, {alpha, theta});
        }
        for (const float z : logarithmic(1e-30, 1e-7, 30)) {
            for (const bool kind : {false, true})
                EXPECT_TRUE(std::isfinite(Microfacet{alpha, kind}.Lambda({1, 0, z}))) << alpha << ' ' << z;
        }
    }
}

TEST(StabilitySurfaces, SampledReflection) {
    Worst worst({"surfaces", "microfacet.cpp", "weight of a sampled reflection, G2 / G1",
                 "D, huge where alpha is small, cancels between value and density",
                 "both are made of the one D",
                 "alpha 1e-4 to 1, wo from 1e-7 above the horizon, u to both ends", "1", 5e-7});
    Rng rng(1);
    for (const float alpha : alphas()) {
        for (const float theta : polar_angles()) {
            const Vec3f wo = at_angle(double{theta}, 0.7);
            for (const float u : {0.0f, 1e-7f, 0.3f, 0.9f, 0.999f, kOneMinusEpsilon}) {
                const Microfacet facets{alpha, false};
                const Vec3f h = facets.sample_normal(wo, {rng.next(), u});
                EXPECT_TRUE(is_finite(h) && h.z > 0 && std::fabs(length(h) - 1) < 1e-6f)
                    << alpha << ' ' << theta << ' ' << u;
                const Reflection lobe{facets, Fresnel::constant(Rgb(1)), Rgb(1)};
                const auto s = lobe.sample(wo, 0, {rng.next(), u});
                if (!s)
                    continue;
                const auto lambda = [&](Vec3f w) {
                    const Exact tan2 = squared(exact(alpha)) * (squared(exact(w.x)) + squared(exact(w.y))) /
                                       squared(exact(w.z));
                    return (std::sqrt(1 + tan2) - 1) / 2;
                };
                worst.error(exact(s->weight.x) - (1 + lambda(wo)) / (1 + lambda(wo) + lambda(s->wi)),
                            {alpha, theta, u});
            }
        }
    }
}

TEST(StabilitySurfaces, RoughDiffuseReciprocity) {
    Worst worst({"surfaces", "lobes.cpp", "rough diffuse value, against the one of exchanged directions",
                 "the tangent at the horizon; lost energy over what can be lost, 0 / 0",
                 "the pole divided out; no second bounce where nothing is lost",
                 "roughness 0 and 1e-7 to 1, from 1e-6 above the horizon", "the value", 5e-7});
    Rng rng(2);
    for (const float roughness : joined({0}, logarithmic(1e-7, 1, 30))) {
        const RoughDiffuse lobe{Rgb(0.8f), roughness};
        for (int i = 0; i < 2000; ++i) {
            const Vec3f a = at_angle(1.5707953 * std::sqrt(double{rng.next()}), 6 * double{rng.next()}),
                        b = at_angle(1.5707953 * std::sqrt(double{rng.next()}), 6 * double{rng.next()});
            if (a.z <= 1e-6f || b.z <= 1e-6f)
                continue;
            const float there = lobe.eval(a, b).f.x / b.z, back = lobe.eval(b, a).f.x / a.z;
            worst.relative(double{there}, exact(back), {roughness, a.z, b.z});
        }
    }
}

/// Whether whatever the closures make of these directions is finite, and no probability is above 1.
void check_bsdf(const Program& program, Vec3f wo, const std::string& what) {
    const ShadingPoint point = testing::point_seen_from(wo);
    const Bsdf bsdf = make_bsdf(&program, point, {});
    Rng rng(3);
    ASSERT_TRUE(is_finite(bsdf.albedo(wo))) << what;
    for (int i = 0; i < 30; ++i) {
        const auto s = bsdf.sample(wo, rng.next(), rng.next2());
        if (!s)
            continue;
        EXPECT_TRUE(is_finite(s->weight) && min_component(s->weight) >= 0 && is_finite(s->wi)) << what;
        EXPECT_TRUE(std::isfinite(s->pdf) && s->pdf >= 0) << what;
        float pdf = 0;
        bool crosses = false;
        const Rgb f = bsdf.eval(wo, s->wi, pdf, crosses);
        EXPECT_TRUE(is_finite(f) && std::isfinite(pdf) && pdf >= 0) << what;
    }
}

TEST(StabilitySurfaces, AnyInputIsFinite) {
    const std::vector<float> iors{0, 1e-5f, 0.5f, 1, 1 + 1e-7f, 1 + 1e-4f, 1.5f, 1e3f, 1e8f, 1e20f, 3e38f};
    for (const float theta : {0.0f, 1e-6f, 0.7f, 1.57f, kPi / 2 - 1e-6f}) {
        const Vec3f wo = at_angle(double{theta}, 0.7);
        for (const float ior : iors) {
            for (const float roughness : {0.0f, 1e-3f, 0.01f, 0.02f, 0.5f, 1.0f}) {
                for (const auto mode : {Distribution::ggx, Distribution::multi_ggx, Distribution::beckmann}) {
                    const std::string what = "theta " + std::to_string(theta) + " ior " +
                                             std::to_string(ior) + " roughness " + std::to_string(roughness) +
                                             " mode " + std::to_string(static_cast<int>(mode));
                    for (const ClosureKind kind : {ClosureKind::glass, ClosureKind::refraction}) {
                        testing::ConstantProgram p;
                        p.add(kind, {Vec3f(0.9f), Vec3f(roughness), Vec3f(ior), testing::kNoNormal}, mode);
                        check_bsdf(p.program, wo, what);
                    }
                    for (const ClosureKind kind : {ClosureKind::sheen, ClosureKind::velvet}) {
                        testing::ConstantProgram p;
                        p.add(kind, {Vec3f(0.9f), Vec3f(roughness), testing::kNoNormal}, mode);
                        check_bsdf(p.program, wo, "sheen " + what);
                    }
                    for (const ClosureKind kind : {ClosureKind::toon_diffuse, ClosureKind::toon_glossy}) {
                        testing::ConstantProgram p;
                        p.add(kind,
                              {Vec3f(0.9f), Vec3f(roughness), Vec3f(1 - roughness), testing::kNoNormal});
                        check_bsdf(p.program, wo, "toon " + what);
                    }
                    for (const float amount : {-1.0f, 1.0f}) {
                        testing::ConstantProgram p;
                        p.add(ClosureKind::brushed,
                              {Vec3f(0.9f), Vec3f(roughness), Vec3f(amount), Vec3f(0.2f), testing::kNoNormal,
                               Vec3f(1, 0, 0)},
                              mode);
                        check_bsdf(p.program, wo, "brushed " + what);
                    }
                    testing::ConstantProgram plastic;
                    plastic.add(ClosureKind::plastic,
                                {Vec3f(0.5f), Vec3f(roughness), Vec3f(ior), Vec3f(1), testing::kNoNormal},
                                mode);
                    check_bsdf(plastic.program, wo, "plastic " + what);
                    testing::PrincipledInputs in;
                    in.ior = in.coat_ior = ior;
                    in.roughness = in.coat_roughness = roughness;
                    in.coat = 0.5f;
                    in.coat_tint = Vec3f(0.5f, 1.5f, 0);
                    in.transmission = 0.3f;
                    in.sheen = 0.2f;
                    in.specular_ior_level = 0.7f;
                    check_bsdf(in.program(mode), wo, "principled " + what);
                    in.anisotropic = in.diffuse_roughness = 1;
                    in.subsurface = 0.5f;
                    in.subsurface_ior = ior;
                    in.film_ior = ior;
                    for (const float thickness : {1e-3f, 500.0f, 1e30f}) {
                        in.film_thickness = thickness;
                        in.metallic = 0.5f;
                        check_bsdf(in.program(mode), wo, "filmed " + what);
                        in.metallic = 0;
                        check_bsdf(in.program(mode), wo, "filmed dielectric " + what);
                    }
                    for (const float k : {0.0f, 3.0f, 1e20f}) {
                        testing::ConstantProgram conductor;
                        conductor.add(ClosureKind::conductor,
                                      {Vec3f(ior), Vec3f(k), Vec3f(roughness), Vec3f(1), Vec3f(0.3f),
                                       testing::kNoNormal, Vec3f(1, 0, 0), Vec3f(k), Vec3f(1.5f)},
                                      mode);
                        check_bsdf(conductor.program, wo, "conductor " + what);
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace nephele::stability
