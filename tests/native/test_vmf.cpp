// SPDX-License-Identifier: GPL-3.0-or-later
// The von Mises-Fisher distribution against quadrature and its own samples, from uniform to a tenth of a
// degree.
#include "guiding/vmf.h"

#include <gtest/gtest.h>

#include "chi_square.h"

namespace nephele::test {
namespace {

using testing::ChiSquare;

const Vec3f kAxis = normalize(Vec3f(0.3f, -0.8f, 0.5f));

/// A direction whose cosine to the axis is 1 + less_one.
Vec3f around(Vec3f axis, double less_one, double phi) {
    const double sine = std::sqrt(std::max(-less_one * (2 + less_one), 0.0));
    return Frame(axis).to_world(Vec3f(static_cast<float>(sine * std::cos(phi)),
                                      static_cast<float>(sine * std::sin(phi)),
                                      static_cast<float>(1 + less_one)));
}

/// Integral over the sphere of f(cosine - 1), for f that falls off as exp(kappa (cosine - 1)), by the
/// midpoint rule.
template <class F>
double over_the_sphere(double kappa, F&& f) {
    constexpr int kSteps = 20000;
    // x = 1 - cosine in [0, 2], in two pieces: the lobe, and the rest.
    const double knee = std::min(2.0, 40 / std::max(kappa, 1e-9));
    double sum = 0;
    for (const auto& [low, high] : {std::pair{0.0, knee}, std::pair{knee, 2.0}}) {
        for (int i = 0; i < kSteps; ++i)
            sum += f(-(low + (high - low) * (i + 0.5) / kSteps)) * (high - low) / kSteps;
    }
    return 2 * M_PI * sum;
}

TEST(Vmf, IntegratesToOne) {
    for (const float kappa :
         {0.0f, 1e-6f, 0.9e-4f, 1.1e-4f, 0.01f, 0.5f, 1.0f, 3.0f, 10.0f, 100.0f, 1e3f, 1e4f}) {
        const double integral = over_the_sphere(double{kappa}, [&](double less_one) {
            return double{vmf_peak(kappa)} * std::exp(double{kappa} * less_one);
        });
        EXPECT_NEAR(integral, 1, 2e-6) << kappa;
    }
}

TEST(Vmf, DensityOfDirectionsIsTheClosedForm) {
    // In the narrow lobes too, where a plain cosine has no digits left.
    for (const float kappa : {0.0f, 1.0f, 30.0f, 1e3f, 1e4f}) {
        for (const double x : {0.0, 1e-5, 1e-4, 1e-3, 0.1, 1.0, 1.9}) {
            const double expected = double{vmf_peak(kappa)} * std::exp(-double{kappa} * x);
            const double tolerance = 1e-4 + 2e-6 * double{kappa} * std::sqrt(x);  // of directions in floats
            if (double{kappa} * x < 60) {
                EXPECT_NEAR(double{vmf_pdf({kAxis, kappa}, around(kAxis, -x, 0.7))} / expected, 1, tolerance)
                    << kappa << ' ' << x;
            }
        }
    }
    EXPECT_EQ(vmf_pdf({kAxis, 1e4f}, -kAxis), 0);
}

// False alarms: 1 in 100 sets of seeds (chi_square.h).
TEST(Vmf, SamplesFollowTheDensity) {
    constexpr float kKappas[] = {0, 5e-5f, 0.3f, 2, 20, 300, 1e4f};
    std::uint64_t seed = 811;
    for (const float kappa : kKappas) {
        const VmfLobe lobe{kAxis, kappa};
        // Narrow lobes get narrow rows.
        const double spread = kappa > 1000 ? 6 : kappa > 10 ? 3 : 1;
        const auto result = ChiSquare(kAxis, 20, 8, spread)
                                .run([&](Rng& rng) { return vmf_sample(lobe, rng.next2()); },
                                     [&](Vec3f w) { return double{vmf_pdf(lobe, w)}; }, 100000, seed++);
        EXPECT_GT(result.p_value, testing::significance(7)) << kappa;
        EXPECT_NEAR(result.integral, 1, 1e-3) << kappa;
    }
}

TEST(Vmf, SamplesAreUnitAndFiniteAtTheEdges) {
    for (const float kappa : {0.0f, 1e-5f, 1e-3f, 1.0f, 1e4f, kLargestKappa}) {
        for (const float u : {0.0f, 0.5f, kOneMinusEpsilon}) {
            for (const Vec3f axis : {Vec3f(0, 0, 1), Vec3f(0, 0, -1), Vec3f(1, 0, 0), kAxis}) {
                const Vec3f w = vmf_sample({axis, kappa}, {u, 0.3f});
                ASSERT_TRUE(is_finite(w)) << kappa << ' ' << u;
                EXPECT_NEAR(length(w), 1, 1e-6f);
                if (u == 0) {
                    EXPECT_NEAR(dot(w, axis), 1, 1e-6f);
                }
            }
        }
    }
}

TEST(Vmf, MeanCosineIsTheIntegral) {
    for (const float kappa :
         {0.0f, 1e-4f, 0.01f, 0.049f, 0.051f, 0.3f, 1.0f, 5.0f, 49.0f, 51.0f, 1e3f, 1e5f}) {
        const double mean = over_the_sphere(double{kappa}, [&](double less_one) {
            return double{vmf_peak(kappa)} * std::exp(double{kappa} * less_one) * (1 + less_one);
        });
        EXPECT_NEAR(double{vmf_mean_cosine(kappa)}, mean, 3e-6) << kappa;
    }
}

TEST(Vmf, MeanCosineAndConcentrationAreInverse) {
    for (double r = 0; r < 0.99999; r = r < 0.99 ? r + 0.001 : r + 0.1 * (1 - r)) {
        const auto cosine = static_cast<float>(r);
        EXPECT_NEAR(vmf_mean_cosine(vmf_kappa(cosine)), cosine, 1e-4) << r;
        // Relative to the spread, which is what tells narrow lobes apart.
        EXPECT_NEAR((1 - vmf_mean_cosine(vmf_kappa(cosine))) / (1 - cosine), 1, 0.02) << r;
    }
    for (double kappa = 1e-3; kappa < 1e5; kappa *= 1.07) {
        const auto k = static_cast<float>(kappa);
        // A float's mean cosine has the spread, 1 / kappa, to within its last bit.
        const double tolerance = 1e-4 + kappa * 0x1p-23;
        EXPECT_NEAR(double{vmf_kappa(vmf_mean_cosine(k))} / double{k}, 1, tolerance) << kappa;
    }
    EXPECT_EQ(vmf_kappa(0), 0);
    EXPECT_EQ(vmf_kappa(-0.5f), 0);
    for (const float beyond : {1.0f, 1.5f}) {
        EXPECT_GT(vmf_kappa(beyond), 0.98f * kLargestKappa);
        EXPECT_LE(vmf_kappa(beyond), kLargestKappa);
    }
}

TEST(Vmf, ConcentrationGrowsWithTheMeanCosine) {
    float last = -1;
    for (int i = 0; i < 100000; ++i) {
        const float kappa = vmf_kappa(static_cast<float>(i) / 100000);
        ASSERT_GE(kappa, last * (1 - 1e-4f)) << i;
        last = kappa;
    }
}

TEST(Vmf, HenyeyGreensteinsLobePointsWhereItScatters) {
    const VmfLobe forward = vmf_of_henyey_greenstein(0.8f, kAxis),
                  backward = vmf_of_henyey_greenstein(-0.8f, kAxis);
    EXPECT_EQ(dot(forward.mu, kAxis), dot(kAxis, kAxis));
    EXPECT_EQ(dot(backward.mu, kAxis), -dot(kAxis, kAxis));
    EXPECT_EQ(forward.kappa, backward.kappa);
    EXPECT_NEAR(vmf_mean_cosine(forward.kappa), 0.8f, 1e-4);
    EXPECT_EQ(vmf_of_henyey_greenstein(0, kAxis).kappa, 0);
}

}  // namespace
}  // namespace nephele::test
