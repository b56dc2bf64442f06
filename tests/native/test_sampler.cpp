// SPDX-License-Identifier: GPL-3.0-or-later
// Random numbers: the net property of Sobol pairs, independence between pairs, pixels and seeds, and the
// distributions that Rng draws. Seeds are fixed; each statistical check would fail a right generator with
// probability kFalseAlarm (1e-5) or, for z-tests, 4e-8.
#include <gtest/gtest.h>

#include <bit>
#include <set>

#include "cell_counts.h"
#include "media_fixtures.h"

namespace nephele::test {
namespace {

/// The k-th pair of a path's dimensions, for every sample of a pixel.
std::vector<Vec2f> pairs_of(std::uint64_t seed, std::uint32_t pixel, int k, int samples) {
    std::vector<Vec2f> out;
    for (int i = 0; i < samples; ++i) {
        PathSampler sampler(true, seed, pixel, static_cast<std::uint32_t>(i));
        Vec2f u;
        for (int skip = 0; skip <= k; ++skip)
            u = sampler.next2();
        out.push_back(u);
    }
    return out;
}

TEST(PathSampler, EveryPairIsAZeroTwoNetInBaseTwo) {
    for (const std::uint64_t seed : {0u, 1u, 12345u}) {
        for (const int k : {0, 1, 7, PathSampler::kStructuredPairs - 1}) {
            for (int m = 0; m <= 8; ++m) {
                const auto points = pairs_of(seed, 77, k, 1 << m);
                for (int a = 0; a <= m; ++a) {  // 2^a columns by 2^(m - a) rows: one point each
                    std::set<std::pair<int, int>> cells;
                    for (const Vec2f p : points) {
                        cells.emplace(static_cast<int>(p.x * static_cast<float>(1 << a)),
                                      static_cast<int>(p.y * static_cast<float>(1 << (m - a))));
                    }
                    ASSERT_EQ(cells.size(), points.size())
                        << "pair " << k << ", 2^" << m << " points, split " << a;
                }
            }
        }
    }
}

TEST(PathSampler, StaysANetFromAnyAlignedBlockOfSamples) {
    for (const std::uint32_t begin : {64u, 960u, 0xffffff00u}) {
        std::set<int> cells;
        for (std::uint32_t i = 0; i < 64; ++i) {
            PathSampler sampler(true, 9, 3, begin + i);
            const Vec2f p = sampler.next2();
            cells.insert(static_cast<int>(p.x * 8) * 8 + static_cast<int>(p.y * 8));
        }
        EXPECT_EQ(cells.size(), 64u);
    }
}

TEST(PathSampler, NumbersAreInTheUnitIntervalAndUniformOverPixels) {
    std::vector<std::uint64_t> counts(256);
    for (std::uint32_t pixel = 0; pixel < 100000; ++pixel) {
        PathSampler sampler(true, 4, pixel, 5);
        for (int k = 0; k < 3; ++k) {
            const Vec2f u = sampler.next2();
            ASSERT_TRUE(u.x >= 0 && u.x < 1 && u.y >= 0 && u.y < 1);
            ++counts[static_cast<std::size_t>(u.x * 16) * 16 + static_cast<std::size_t>(u.y * 16)];
        }
    }
    EXPECT_GT(chi_square_p(counts, std::vector<double>(256, 1 / 256.0), 300000), kFalseAlarm);
}

/// Correlation of two sequences of uniform numbers, in standard errors.
double correlation_z(const std::function<std::pair<float, float>(int)>& draw, int n) {
    Mean product;
    for (int i = 0; i < n; ++i) {
        const auto [a, b] = draw(i);
        product.add((double{a} - 0.5) * (double{b} - 0.5));
    }
    return product.mean() / std::sqrt(1.0 / 144 / n);
}

TEST(PathSampler, PairsPixelsAndSeedsAreUncorrelated) {
    constexpr int kDraws =
        1 << 14;  // over pixels: within one pixel nets are even more regular than independent numbers
    const auto draw = [](std::uint64_t seed, int pixel, int pair) {
        PathSampler sampler(true, seed, static_cast<std::uint32_t>(pixel),
                            static_cast<std::uint32_t>(pixel % 16));
        Vec2f u;
        for (int k = 0; k <= pair; ++k)
            u = sampler.next2();
        return u;
    };
    for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
            const double across = correlation_z(
                [&](int i) { return std::pair(draw(1, i, a).x, a == b ? draw(1, i, b).y : draw(1, i, b).x); },
                kDraws);
            EXPECT_LT(std::fabs(across), kSigmas) << "pairs " << a << ' ' << b;
        }
    }
    const double pixels =
        correlation_z([&](int i) { return std::pair(draw(1, i, 0).x, draw(1, i + 16, 0).x); }, kDraws);
    const double seeds =
        correlation_z([&](int i) { return std::pair(draw(1, i, 0).x, draw(2, i, 0).x); }, kDraws);
    EXPECT_LT(std::fabs(pixels), kSigmas);
    EXPECT_LT(std::fabs(seeds), kSigmas);
}

TEST(PathSampler, TwoPairsFillTheirFourDimensionsLikeIndependentNumbers) {
    std::vector<std::uint64_t> counts(256);
    for (std::uint32_t pixel = 0; pixel < 2000; ++pixel) {
        for (std::uint32_t i = 0; i < 64; ++i) {
            PathSampler sampler(true, 8, pixel, i);
            const Vec2f a = sampler.next2(), b = sampler.next2();
            const auto cell = [](float u) { return static_cast<std::size_t>(u * 4); };
            ++counts[((cell(a.x) * 4 + cell(a.y)) * 4 + cell(b.x)) * 4 + cell(b.y)];
        }
    }
    for (const std::uint64_t n :
         counts)  // shuffled anew per pixel: each cell's count is a sum over many pixels
        EXPECT_NEAR(static_cast<double>(n), 500, kSigmas * std::sqrt(500.0));
}

/// The first pair of every sample of a pixel, each in its epoch of a power of two.
std::vector<Vec2f> in_epochs(std::uint32_t pixel, std::uint32_t begin, std::uint32_t end) {
    std::vector<Vec2f> out;
    for (std::uint32_t i = begin; i < end; ++i) {
        PathSampler sampler(true, 3, pixel, i);
        sampler.enter_epoch(static_cast<std::uint32_t>(std::bit_width(i)));
        out.push_back(sampler.next2());
    }
    return out;
}

TEST(PathSampler, AnEpochIsANetByItselfAndTellsNothingOfOthers) {
    for (std::uint32_t begin = 1; begin <= 64; begin *= 2) {
        std::set<int> strata;
        for (const Vec2f p : in_epochs(5, begin, 2 * begin))
            strata.insert(static_cast<int>(p.x * static_cast<float>(begin)));
        EXPECT_EQ(strata.size(), begin);
    }
    // Without epochs samples 1 and 2 would never share a quarter. In epochs all pairs of quarters are alike.
    std::vector<std::uint64_t> counts(16);
    for (std::uint32_t pixel = 0; pixel < 16000; ++pixel) {
        const auto p = in_epochs(pixel, 1, 3);
        ++counts[static_cast<std::size_t>(p[0].x * 4) * 4 + static_cast<std::size_t>(p[1].x * 4)];
    }
    EXPECT_GT(chi_square_p(counts, std::vector<double>(16, 1 / 16.0), 16000), kFalseAlarm);
}

TEST(PathSampler, IsUnstructuredWhereAskedAndBeyondItsPairs) {
    for (const bool structured : {true, false}) {
        std::set<float> seen;
        PathSampler sampler(structured, 1, 2, 3);
        for (int k = 0; k < PathSampler::kStructuredPairs + 200; ++k)
            seen.insert(sampler.next2().x);
        EXPECT_GE(seen.size(), static_cast<std::size_t>(PathSampler::kStructuredPairs + 198));
    }
}

TEST(PathSampler, WhatIsDrawnAsideDoesNotShiftThePath) {
    PathSampler a(true, 1, 2, 3), b(true, 1, 2, 3);
    Rng aside = a.aside();
    EXPECT_NE(aside.next(), PathSampler(true, 1, 2, 3).rng().next());
    EXPECT_EQ(a.rng().next(), b.rng().next());
    EXPECT_EQ(a.next(), b.next());
}

TEST(Rng, IsUniformSeriallyIndependentAndDependsOnTheSeed) {
    for (std::uint64_t seed = 0; seed < 8; ++seed) {
        Rng rng(seed);
        std::vector<std::uint64_t> single(1024), serial(1024);
        float before = rng.next();
        for (int n = 0; n < 200000; ++n) {
            const float u = rng.next();
            ASSERT_TRUE(u >= 0 && u < 1);
            ++single[static_cast<std::size_t>(u * 1024)];
            ++serial[static_cast<std::size_t>(before * 32) * 32 + static_cast<std::size_t>(u * 32)];
            before = u;
        }
        const std::vector<double> flat(1024, 1 / 1024.0);
        EXPECT_GT(chi_square_p(single, flat, 200000), kFalseAlarm) << "seed " << seed;
        EXPECT_GT(chi_square_p(serial, flat, 200000), kFalseAlarm) << "seed " << seed;
        EXPECT_NE(Rng(seed).next_uint(), Rng(seed + 1).next_uint());
    }
}

TEST(Rng, ThreeNumbersFromTwoDrawsAreUniformTogether) {
    Rng rng(5);
    std::vector<std::uint64_t> counts(4096);
    for (int n = 0; n < 400000; ++n) {
        const Vec3f u = rng.next3();
        const auto cell = [](float v) { return static_cast<std::size_t>(v * 16); };
        ++counts[(cell(u.x) * 16 + cell(u.y)) * 16 + cell(u.z)];
    }
    EXPECT_GT(chi_square_p(counts, std::vector<double>(4096, 1 / 4096.0), 400000), kFalseAlarm);
}

TEST(Rng, ExponentialHasItsMeanItsDistributionAndItsTail) {
    constexpr int kDraws = 4000000;
    Rng rng(6);
    Mean mean;
    std::vector<std::uint64_t> counts(200);
    std::vector<double> probabilities(200);
    for (int n = 0; n < kDraws; ++n) {
        const float x = rng.next_exponential();
        ASSERT_TRUE(x > 0 && x < kInfinity);
        mean.add(double{x});
        if (x < 20)
            ++counts[static_cast<std::size_t>(x * 10)];
    }
    EXPECT_LT(mean.z(1), kSigmas);
    for (std::size_t b = 0; b < 200; ++b) {
        const double low = static_cast<double>(b) / 10;
        probabilities[b] = std::exp(-low) - std::exp(-low - 0.1);
    }
    EXPECT_GT(chi_square_p(counts, probabilities, kDraws), kFalseAlarm);
}

}  // namespace
}  // namespace nephele::test
