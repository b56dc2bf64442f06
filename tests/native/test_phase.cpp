// SPDX-License-Identifier: GPL-3.0-or-later
// Henyey-Greenstein and mixtures of it: normalisation, samples against the density, mean cosine, orientation.
#include <gtest/gtest.h>

#include "chi_square.h"
#include "integrators/phase_mixture.h"
#include "media_fixtures.h"

namespace nephele::testing {
namespace {

constexpr float kMeanCosines[] = {-0.95f,  -0.5f, -1e-4f, 0,    1e-6f, 1e-4f, 9e-4f,
                                  1.1e-3f, 0.02f, 0.3f,   0.7f, 0.9f,  0.99f};
const Vec3f kDirections[] = {{0, 0, 1}, {0, 0, -1}, normalize(Vec3f(0.3f, -0.8f, 0.2f))};

TEST(HenyeyGreenstein, SamplesFollowADensityThatIntegratesToOne) {
    for (const float g : kMeanCosines) {
        for (const Vec3f wo : kDirections) {
            const HenyeyGreenstein phase{g};
            // Cells crowd around the peak, which lies at -wo for g > 0 and at wo for g < 0.
            const ChiSquare cells(g < 0 ? wo : -wo, 20, 12, std::fabs(g) > 0.8f ? 3 : 1);
            const auto result = cells.run([&](Rng& rng) { return phase.sample(wo, rng.next2()); },
                                          [&](Vec3f wi) { return double{phase.eval(wo, wi)}; }, 100000, 3);
            EXPECT_NEAR(result.integral, 1, 1e-4) << "g " << g;
            EXPECT_GT(result.p_value, significance(39)) << "g " << g;
        }
    }
}

TEST(HenyeyGreenstein, MeanCosineIsG) {
    for (const float g : kMeanCosines) {
        const HenyeyGreenstein phase{g};
        const Vec3f wo = kDirections[2];
        Rng rng(4);
        test::Mean cosine;
        for (int n = 0; n < 200000; ++n) {
            const Vec3f wi = phase.sample(wo, rng.next2());
            ASSERT_NEAR(length(wi), 1, 1e-5f);
            cosine.add(-double{dot(wo, wi)});
        }
        EXPECT_LT(cosine.z(double{g}), test::kSigmas) << "g " << g << ": " << cosine.mean();
    }
}

TEST(HenyeyGreenstein, ValuesAreTheFormulaAndForwardMeansOnwards) {
    const Vec3f wo(0, 0, 1);
    for (const double g : {-0.95, 0.0, 0.5, 0.99}) {
        for (double c = -1; c <= 1; c += 0.125) {
            const Vec3f wi(static_cast<float>(std::sqrt(1 - c * c)), 0, static_cast<float>(-c));  // c: to -wo
            const double expected = (1 - g * g) / (4 * M_PI * std::pow(1 + g * g - 2 * g * c, 1.5));
            // 1 + g^2 - 2 g c cancels at the peak: 1e-4 of 1e-7 / (1 - 0.99)^2
            EXPECT_NEAR((HenyeyGreenstein{static_cast<float>(g)}.eval(wo, wi)), expected, 3e-3 * expected)
                << g << ' ' << c;
        }
    }
    EXPECT_GT((HenyeyGreenstein{0.5f}.eval(wo, -wo)), (HenyeyGreenstein{0.5f}.eval(wo, wo)));
}

TEST(PhaseMixture, SamplesFollowItsDensityAndItsValueIsTheShareWeightedSum) {
    const auto hg = [](float g) { return PhaseFunction{PhaseKind::henyey_greenstein, g, 0}; };
    const std::vector<ScatterShare> shares{
        {{1, 0, 2}, hg(0.8f)}, {{0.5f, 1, 0}, hg(-0.6f)}, {{0, 0, 0}, hg(0.1f)}, {{1, 1, 1}, hg(0)}};
    for (const Rgb beta : {Rgb(1), Rgb(1, 0, 0), Rgb(0.1f, 2, 0.3f)}) {
        const PhaseMixture phase(shares, beta);
        const Vec3f wo = kDirections[2];
        const auto density = [&](Vec3f wi) {
            float pdf = 0;
            phase.eval(wo, wi, pdf);
            return double{pdf};
        };
        const auto result = ChiSquare(-wo, 20, 12)
                                .run(
                                    [&](Rng& rng) {
                                        const float choice = rng.next();
                                        return phase.sample(wo, choice, rng.next2());
                                    },
                                    density, 100000, 5);
        EXPECT_NEAR(result.integral, 1, 1e-4);
        EXPECT_GT(result.p_value, significance(3));
        float pdf = 0;
        const Vec3f wi = normalize(Vec3f(-0.2f, 0.9f, 0.1f));
        const Rgb value = phase.eval(wo, wi, pdf);
        for (int c = 0; c < 3; ++c) {
            double sum = 0, total = 0;
            for (const ScatterShare& s : shares) {
                sum += double{s.sigma_s[c]} * double{s.phase.eval(wo, wi)};
                total += double{s.sigma_s[c]};
            }
            EXPECT_NEAR(value[c], sum / total, 1e-6);
        }
    }
}

}  // namespace
}  // namespace nephele::testing
