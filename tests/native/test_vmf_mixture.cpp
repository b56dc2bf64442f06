// SPDX-License-Identifier: GPL-3.0-or-later
// Mixtures of von Mises-Fisher lobes: density, samples, products against quadrature, and parallax against a
// point of light.
#include "guiding/vmf_mixture.h"

#include <gtest/gtest.h>

#include "chi_square.h"

namespace nephele::test {
namespace {

using testing::ChiSquare;

struct Lobe {
    float weight;
    Vec3f towards;
    float kappa;
};

VmfMixture mixture_of(const std::vector<Lobe>& lobes) {
    VmfMixture out;
    int k = 0;
    for (const Lobe& lobe : lobes)
        out.set(k++, lobe.weight, {normalize(lobe.towards), lobe.kappa}, 0);
    return out;
}
const VmfMixture kThree =
    mixture_of({{0.5f, {1, 0.2f, 0.1f}, 4}, {0.3f, {-0.3f, 1, -0.5f}, 40}, {0.2f, {0, -1, 1}, 0.5f}});

/// Integral of f over the sphere, by the midpoint rule in cosine and azimuth.
template <class F>
double over_the_sphere(F&& f, int rows = 400) {
    double sum = 0;
    for (int i = 0; i < rows; ++i) {
        for (int j = 0; j < 2 * rows; ++j) {
            const double c = (i + 0.5) / rows * 2 - 1, s = std::sqrt(1 - c * c),
                         phi = (j + 0.5) / rows * M_PI;
            sum += f(Vec3f(static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
                           static_cast<float>(c)));
        }
    }
    return sum * 2 * M_PI / rows / rows;
}

TEST(ExpOfNegative, IsTheExponential) {
    double worst = 0;
    for (int i = 0; i <= 2000000; ++i) {
        const float x = -87.0f * static_cast<float>(i) / 2000000;
        const double exact = std::exp(double{x});
        worst = std::max(worst, std::fabs(double{exp_of_negative(x)} - exact) / exact);
    }
    // To which a float's argument adds its rounding in base 2: half a bit of 126.
    EXPECT_LT(worst, 1e-6 + 126 * 0x1p-24 * 0.693);
    for (int i = 0; i <= 100000; ++i) {
        const float x = -static_cast<float>(i) / 100000;
        ASSERT_NEAR(double{exp_of_negative(x)} / std::exp(double{x}), 1, 1e-6) << x;
    }
    EXPECT_NEAR(exp_of_negative(0), 1, 1e-6);
    EXPECT_EQ(exp_of_negative(-88), 0);
    EXPECT_EQ(exp_of_negative(-1e30f), 0);
    EXPECT_EQ(exp_of_negative(-kInfinity), 0);
}

TEST(ExpOfNegative, IsNeverADenormal) {
    for (float x = -80; x > -110; x = std::nextafter(x - 1e-4f, -kInfinity)) {
        const float e = exp_of_negative(x);
        ASSERT_TRUE(e == 0 || std::isnormal(e)) << x;
        ASSERT_EQ(e == 0, x < -126 * 0.693147181f) << x;
    }
}

TEST(VmfMixture, DensityIsTheSumOfItsLobes) {
    Rng rng(823);
    for (int i = 0; i < 1000; ++i) {
        VmfMixture m;
        double expected = 0;
        const Vec3f w = sample_sphere(rng.next2());
        for (int k = 0; k < kMostLobes; ++k) {
            const VmfLobe lobe{sample_sphere(rng.next2()), std::exp(8 * rng.next() - 1)};
            const float weight = rng.next() < 0.3f ? 0 : rng.next();
            m.set(k, weight, lobe, 0);
            expected += double{weight} * double{vmf_pdf(lobe, w)};
        }
        EXPECT_NEAR(double{m.pdf(w)}, expected, 1e-5 * expected + 1e-30);
        EXPECT_GE(m.pdf(w), 0);
    }
    EXPECT_EQ(VmfMixture().pdf({0, 0, 1}), 0);
}

TEST(VmfMixture, IntegratesToOne) {
    EXPECT_NEAR(over_the_sphere([&](Vec3f w) { return double{kThree.pdf(w)}; }), 1, 1e-4);
}

// False alarms: 1 in 100 sets of seeds (chi_square.h).
TEST(VmfMixture, SamplesFollowTheDensity) {
    VmfMixture eight;
    Rng lobes(827);
    for (int k = 0; k < kMostLobes; ++k)
        eight.set(k, 1.0f / kMostLobes, {sample_sphere(lobes.next2()), std::exp(5 * lobes.next())}, 0);
    VmfMixture gaps = kThree;  // lobes that are not there, first, between and last
    gaps.set(5, 0.2f, {{0, 0, -1}, 10}, 0);
    gaps.weight[0] = 0;
    gaps.weight[1] = 0.6f;
    std::uint64_t seed = 829;
    for (const VmfMixture& m : {kThree, eight, gaps}) {
        const auto result = ChiSquare({0, 0, 1}, 24, 32)
                                .run(
                                    [&](Rng& rng) {
                                        const float choice = rng.next();
                                        return m.sample(choice, rng.next2());
                                    },
                                    [&](Vec3f w) { return double{m.pdf(w)}; }, 200000, seed++);
        EXPECT_GT(result.p_value, testing::significance(3));
        EXPECT_NEAR(result.integral, 1, 1e-3);
    }
    EXPECT_GT(gaps.pdf(gaps.sample(0, {0.5f, 0.5f})), 0) << "the first lobe is not there";
    EXPECT_GT(gaps.pdf(gaps.sample(kOneMinusEpsilon, {0.5f, 0.5f})), 0) << "nor is the last";
}

TEST(VmfMixture, ProductIsTheProduct) {
    for (const VmfLobe& lobe :
         {VmfLobe{normalize(Vec3f(0.5f, 0.7f, 0)), 6}, VmfLobe{normalize(Vec3f(-1, 0, 0.2f)), 60},
          VmfLobe{{0, 0, 1}, 0}, VmfLobe{-normalize(Vec3f(1, 0.2f, 0.1f)), 4}, VmfLobe{{0, 1, 0}, 1e-3f}}) {
        const VmfMixture::Product product = kThree.times(lobe);
        const double integral =
            over_the_sphere([&](Vec3f w) { return double{kThree.pdf(w)} * double{vmf_pdf(lobe, w)}; });
        EXPECT_NEAR(double{product.integral} / integral, 1, 1e-4) << lobe.kappa;
        EXPECT_NEAR(over_the_sphere([&](Vec3f w) { return double{product.mixture.pdf(w)}; }), 1, 1e-4)
            << lobe.kappa;
        Rng rng(839);
        for (int i = 0; i < 300; ++i) {
            const Vec3f w = sample_sphere(rng.next2());
            const double expected = double{kThree.pdf(w)} * double{vmf_pdf(lobe, w)} / integral;
            ASSERT_NEAR(double{product.mixture.pdf(w)}, expected, 2e-4 * expected + 1e-12) << lobe.kappa;
        }
        double total = 0;
        for (const float w : product.mixture.weight)
            total += double{w};
        EXPECT_NEAR(total, 1, 1e-6);
    }
}

TEST(VmfMixture, ProductOfNarrowLobesKeepsItsDigits) {
    // Two lobes of concentration k that are x apart: their product's integral is known, and falls fast.
    constexpr float kKappa = 1e4f;
    const VmfMixture one = mixture_of({{1, {0, 0, 1}, kKappa}});
    for (const double apart : {0.0, 1e-3, 1e-2, 5e-2}) {
        const Vec3f mu(static_cast<float>(std::sin(apart)), 0, static_cast<float>(std::cos(apart)));
        const double k3 = double{kKappa} * 2 * std::cos(apart / 2);
        const double expected =
            double{kKappa} / (2 * M_PI) * double{kKappa} / k3 * std::exp(k3 - 2 * double{kKappa});
        EXPECT_NEAR(double{one.times({mu, kKappa}).integral} / expected, 1, 1e-3) << apart;
    }
    // Nothing in common: the mixture as it was.
    const VmfMixture::Product none = one.times({{0, 0, -1}, kKappa});
    EXPECT_EQ(none.integral, 0);
    EXPECT_EQ(none.mixture.weight, one.weight);
    EXPECT_EQ(none.mixture.kappa, one.kappa);
}

TEST(VmfMixture, SeenFromElsewhereLobesPointAtTheirLight) {
    const Vec3f source(3, -1, 2);
    VmfMixture m = mixture_of({{0.6f, source, 50}, {0.4f, {0, 0, -1}, 5}});
    m.inverse_distance[0] = 1 / length(source);
    for (const Vec3f offset :
         {Vec3f(0), Vec3f(1, 0, 0), Vec3f(-4, 2, 0.5f), Vec3f(3, -1, 1), Vec3f(6, -2, 4)}) {
        const VmfMixture seen = m.seen_from(offset);
        EXPECT_LT(length(seen.mu(0) - normalize(source - offset)), 1e-6f);
        EXPECT_LT(length(seen.mu(1) - Vec3f(0, 0, -1)), 1e-6f) << "from infinity";
        EXPECT_EQ(seen.weight, m.weight);
        EXPECT_EQ(seen.kappa, m.kappa);
    }
    for (const Vec3f offset : {source, source * 0.97f, source + Vec3f(0.1f, 0.1f, 0.1f)}) {
        const VmfMixture seen = m.seen_from(offset);
        EXPECT_EQ(seen.mu(0), m.mu(0)) << "at the source any direction is as good";
        EXPECT_TRUE(is_finite(seen.mu(1)));
        EXPECT_NEAR(over_the_sphere([&](Vec3f w) { return double{seen.pdf(w)}; }), 1, 1e-4);
    }
}

TEST(VmfMixture, ResponsibilitiesAddUpToOne) {
    Rng rng(853);
    VmfMixture narrow = mixture_of({{0.7f, {0, 0, 1}, 1e4f}, {0.3f, {1, 0, 0}, 1e4f}});
    for (const VmfMixture& m : {kThree, narrow}) {
        for (int i = 0; i < 1000; ++i) {
            const Vec3f w = sample_sphere(rng.next2());
            const LobeValues gamma = m.responsibilities(w);
            double sum = 0;
            for (std::size_t k = 0; k < kMostLobes; ++k) {
                EXPECT_GE(gamma[k], 0);
                if (m.weight[k] == 0) {
                    EXPECT_EQ(gamma[k], 0);
                }
                sum += double{gamma[k]};
            }
            ASSERT_NEAR(sum, 1, 1e-6);
        }
    }
    EXPECT_NEAR(narrow.responsibilities({0, 0, 1})[0], 1, 1e-6);
    EXPECT_NEAR(narrow.responsibilities({1, 0, 0})[1], 1, 1e-6);
    EXPECT_EQ(narrow.responsibilities({0, -1, 0}), narrow.weight) << "beyond all lobes: by weight";
}

}  // namespace
}  // namespace nephele::test
