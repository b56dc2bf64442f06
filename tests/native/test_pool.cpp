// SPDX-License-Identifier: GPL-3.0-or-later
// Pooling of sparse statistics: constants stay constant, edges stay edges, fireflies gain no trust, and no
// lack of samples makes a NaN.
#include "guiding/pool.h"

#include <gtest/gtest.h>

#include "math/sampler.h"

namespace nephele::test {
namespace {

constexpr int kSide = 48;

/// n samples of this light per unit of weight.
BranchSums samples_of(float light, float weight = 1, float n = 1) {
    const float x = light * weight, square = light * light * weight;
    return {n * weight, n * x, n * x * x, n * square, n * square * square, 3 * n, n};
}
std::size_t pixel(int x, int y) {
    return static_cast<std::size_t>(y * kSide + x);
}
std::vector<BranchSums> image_of(const BranchSums& sums) {
    return std::vector<BranchSums>(kSide * kSide, sums);
}

TEST(Pool, KeepsConstants) {
    Rng rng(193);
    for (const float n : {1.0f, 100.0f}) {
        auto sums = image_of({});
        std::vector<float> feature;
        for (BranchSums& s : sums) {
            s = samples_of(0.7f, 0.01f + rng.next(), std::floor(1 + n * rng.next()));
            if (rng.next() < 0.5f)
                s = {};
            feature.push_back(3 * rng.next());
        }
        for (const bool edges : {false, true}) {
            for (const Pooled& p : pool(kSide, kSide, sums,
                                        edges ? std::span<const float>(feature) : std::span<const float>())) {
                EXPECT_NEAR(p.light, 0.7f, 1e-4f);
                EXPECT_NEAR(p.cost, 3, 1e-3f);
            }
        }
    }
}

TEST(Pool, WithoutSamplesIsZero) {
    for (const Pooled& p : pool(kSide, kSide, image_of({}), {})) {
        EXPECT_EQ(p.light, 0);
        EXPECT_EQ(p.cost, 0);
    }
    // Weights alone: the branch was never taken.
    for (const Pooled& p : pool(kSide, kSide, image_of({5, 0, 0, 0, 0, 0, 0}), {}))
        EXPECT_EQ(p.light, 0);
    EXPECT_EQ(pool(1, 1, {samples_of(2)}, {})[0].light, 2);
}

TEST(Pool, ASingleSampleIsGivenToAllAround) {
    auto sums = image_of({});
    sums[pixel(20, 20)] = samples_of(4);
    const auto pooled = pool(kSide, kSide, sums, {});
    EXPECT_FLOAT_EQ(pooled[pixel(20, 20)].light, 4);
    EXPECT_FLOAT_EQ(pooled[pixel(47, 0)].light, 4) << "within reach of the widest level";
}

TEST(Pool, ManySamplesAreThePixelsOwn) {
    auto sums = image_of(samples_of(1, 1, 4000));
    sums[pixel(20, 20)] = samples_of(5, 1, 4000);
    const auto pooled = pool(kSide, kSide, sums, {});
    EXPECT_NEAR(pooled[pixel(20, 20)].light, 5, 0.05);
    EXPECT_NEAR(pooled[pixel(25, 20)].light, 1, 0.05);
}

TEST(Pool, FireflyIsGivenNoTrust) {
    auto sums = image_of(samples_of(1, 1, 16));
    BranchSums& s = sums[pixel(20, 20)];
    s = samples_of(1, 1, 63);
    s.light += 1e4f;
    s.light2 += 1e8f;
    s.weight += 1;
    s.taken += 1;
    const auto pooled = pool(kSide, kSide, sums, {});
    // The trust that 64 samples deserve would leave 8/9 of the pixel's own mean, 157.
    EXPECT_LT(pooled[pixel(20, 20)].light, 157 / 4.0);
    EXPECT_NEAR(pooled[pixel(40, 40)].light, 1, 0.5) << "far from it";
}

TEST(Pool, EdgesOfTheFeatureAreRespected) {
    auto sums = image_of(samples_of(1));
    std::vector<float> feature(kSide * kSide, 0);
    for (int y = 0; y < kSide; ++y) {
        for (int x = kSide / 2; x < kSide; ++x) {
            sums[pixel(x, y)] = samples_of(100);
            feature[pixel(x, y)] = 1;
        }
    }
    const auto kept = pool(kSide, kSide, sums, feature), mixed = pool(kSide, kSide, sums, {});
    for (int y = 0; y < kSide; y += 5) {
        EXPECT_NEAR(kept[pixel(kSide / 2 - 1, y)].light, 1, 0.05);
        EXPECT_NEAR(kept[pixel(kSide / 2, y)].light, 100, 1);
        EXPECT_GT(mixed[pixel(kSide / 2 - 1, y)].light, 5);
    }
}

TEST(Pool, HugeSumsStayFinite) {
    for (const float light : {1e10f, 1e15f, 1e18f}) {
        auto sums = image_of(samples_of(1));
        sums[pixel(20, 20)] = samples_of(light);
        for (const Pooled& p : pool(kSide, kSide, sums, {}))
            ASSERT_TRUE(std::isfinite(p.light) && p.light >= 0) << "light " << light << ": " << p.light;
    }
}

}  // namespace
}  // namespace nephele::test
