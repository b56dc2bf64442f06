// SPDX-License-Identifier: GPL-3.0-or-later
// Subsurface scattering: the albedo inversion, by walks in a half-space.
#include <gtest/gtest.h>

#include "integrators/subsurface.h"
#include "phase/henyey_greenstein.h"
#include "surface_fixtures.h"

namespace nephele {
namespace {

/// Share of one channel's light that a half-space returns to light that is uniform over the hemisphere.
double returned(const Subsurface& lobe, int channel, int paths) {
    const SubsurfaceMedium medium(lobe);
    const HenyeyGreenstein phase{medium.g};
    const float sigma_t = medium.sigma_t[channel];
    Rng rng(17);
    double sum = 0;
    for (int i = 0; i < paths; ++i) {
        const Vec3f wo = sample_cosine_hemisphere(rng.next2());
        const auto entry = lobe.sample(wo, 0, rng.next2());
        if (!entry)
            continue;
        Vec3f d = entry->wi;
        double depth = 0, weight = 1;
        while (true) {
            depth += double{d.z} * double{rng.next_exponential() / sigma_t};
            if (depth > 0) {
                sum += weight / paths;
                break;
            }
            weight *= double{medium.albedo[channel]};
            if (weight < 0.1) {
                if (!rng.chance(0.5f))
                    break;
                weight *= 2;
            }
            d = phase.sample(-d, rng.next2());
        }
    }
    return sum;
}

/// Within 0.012 of the colour: the inversion's own error, beside a standard error of 0.002.
TEST(Subsurface, AHalfSpaceReturnsTheColour) {
    for (const float g : {0.0f, 0.6f}) {
        for (const bool diffuse_entry : {false, true}) {
            Subsurface lobe;
            lobe.color = {0.85f, 0.5f, 0.15f};
            lobe.mean_free_path = {0.1f, 0.5f, 2};
            lobe.anisotropy = g;
            lobe.diffuse_entry = diffuse_entry;
            lobe.alpha = 0;
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(returned(lobe, c, 60000), double{lobe.color[c]}, 0.012)
                    << "g " << g << (diffuse_entry ? ", diffuse entry" : ", refracted");
            }
        }
    }
}

TEST(Subsurface, AnisotropyKeepsTheReducedMeanFreePath) {
    Subsurface lobe;
    lobe.color = Rgb(0.5f);
    lobe.mean_free_path = Rgb(0.2f);
    lobe.anisotropy = 0.8f;
    EXPECT_NEAR(SubsurfaceMedium(lobe).sigma_t.x * (1 - lobe.anisotropy), 5, 1e-4f);
}

TEST(Subsurface, ExtremeLooksAreFinite) {
    for (const float color : {0.0f, 1e-6f, 0.5f, 1.0f, 5.0f}) {
        for (const float radius : {0.0f, 1e-9f, 1.0f, 1e20f}) {
            for (const float ior : {0.0f, 1.0f, 1.4f, 1e10f}) {
                for (const auto method : {SubsurfaceMethod::burley, SubsurfaceMethod::random_walk,
                                          SubsurfaceMethod::random_walk_skin}) {
                    const auto program = testing::ConstantProgram()
                                             .add(ClosureKind::subsurface,
                                                  {Vec3f(color), Vec3f(1), Vec3f(radius), Vec3f(ior),
                                                   Vec3f(1), Vec3f(1), testing::kNoNormal},
                                                  static_cast<Distribution>(method))
                                             .program;
                    const Vec3f wo = testing::at_angle(30);
                    const Bsdf bsdf = make_bsdf(&program, testing::point_seen_from(wo), {});
                    EXPECT_TRUE(is_finite(bsdf.albedo(wo)));
                    const auto drawn = bsdf.sample(wo, 0.5f, {0.3f, 0.6f});
                    if (!drawn || !drawn->below)
                        continue;
                    const SubsurfaceMedium medium(*drawn->below);
                    EXPECT_TRUE(is_finite(medium.sigma_t) && is_finite(medium.albedo));
                    EXPECT_TRUE(min_component(medium.sigma_t) > 0 && max_component(medium.albedo) <= 1);
                }
            }
        }
    }
}

}  // namespace
}  // namespace nephele
