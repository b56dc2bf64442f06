// SPDX-License-Identifier: GPL-3.0-or-later
// Brick grids against dense arrays: values, constants, bounds, interpolation, limits.
#include "grids/brick_grid.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <limits>
#include <stdexcept>
#include <vector>

#include "math/sampler.h"

namespace nephele {
namespace {

/// A dense array, mostly empty in clumps so that bricks, constants and background all occur.
struct Dense {
    std::array<int, 3> corner, size;
    float background;
    std::vector<float> values;

    Dense(std::uint64_t seed, VoxelType type) {
        Rng rng(seed);
        const auto pick = [&](int n) { return static_cast<int>(rng.next() * static_cast<float>(n)); };
        for (std::size_t a = 0; a < 3; ++a) {
            corner[a] = pick(600) - 300;
            size[a] = 1 + pick(a == 0 ? 200 : 40);
        }
        background = seed % 2 ? 0.0f : 0.25f;
        const auto n = static_cast<std::size_t>(size[0] * size[1] * size[2]);
        for (std::size_t i = 0; i < n; ++i) {
            const bool clump = (i / 4096) % 3 == 0;
            const float v = clump ? rng.next() : (i / 4096) % 3 == 1 ? 0.5f : background;
            values.push_back(type == VoxelType::half_float ? half_to_float(imath_float_to_half(v)) : v);
        }
    }
    float at(int i, int j, int k) const {
        i -= corner[0], j -= corner[1], k -= corner[2];
        if (i < 0 || j < 0 || k < 0 || i >= size[0] || j >= size[1] || k >= size[2])
            return background;
        return values[static_cast<std::size_t>((i * size[1] + j) * size[2] + k)];
    }
    /// A random point in the grid or a little beyond; three of four points n have a coordinate on a
    /// multiple of 1 / steps, which are voxel centres, and what lies between them.
    Vec3f point(Rng& rng, int n, float steps) const {
        Vec3f p;
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            p[a] = static_cast<float>(corner[i] - 3) + rng.next() * static_cast<float>(size[i] + 6);
            if (n % 4 == a)
                p[a] = std::floor(steps * p[a]) / steps;
        }
        return p;
    }
    std::shared_ptr<const BrickGrid> grid(VoxelType type) const {
        return brick_grid_of_dense(corner, size, values.data(), background, type);
    }
};

class BrickGridOfType : public testing::TestWithParam<VoxelType> {};
INSTANTIATE_TEST_SUITE_P(Types, BrickGridOfType,
                         testing::Values(VoxelType::single_float, VoxelType::half_float));

TEST_P(BrickGridOfType, ReturnsEveryVoxelOfADenseArrayAndTheBackgroundAround) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const Dense dense(seed, GetParam());
        const auto grid = dense.grid(GetParam());
        EXPECT_EQ(grid->voxel_type(), GetParam());
        IndexBox box{{1 << 20, 1 << 20, 1 << 20}, {-1 << 20, -1 << 20, -1 << 20}};
        for (int i = dense.corner[0] - 9; i < dense.corner[0] + dense.size[0] + 9; ++i) {
            for (int j = dense.corner[1] - 9; j < dense.corner[1] + dense.size[1] + 9; ++j) {
                for (int k = dense.corner[2] - 9; k < dense.corner[2] + dense.size[2] + 9; ++k) {
                    const float expected = dense.at(i, j, k);
                    ASSERT_EQ(grid->lookup(i, j, k), expected)
                        << i << ' ' << j << ' ' << k << " seed " << seed;
                    if (expected == dense.background)
                        continue;
                    box.min = {std::min(box.min[0], i), std::min(box.min[1], j), std::min(box.min[2], k)};
                    box.max = {std::max(box.max[0], i), std::max(box.max[1], j), std::max(box.max[2], k)};
                }
            }
        }
        EXPECT_EQ(grid->bounds(), box.empty() ? IndexBox{} : box) << "seed " << seed;
    }
}

TEST_P(BrickGridOfType, TrilinearMatchesTheFormulaInDoublePrecision) {
    const Dense dense(3, GetParam());
    const auto grid = dense.grid(GetParam());
    Rng rng(11);
    for (int n = 0; n < 200000; ++n) {
        const Vec3f p = dense.point(rng, n, 1);
        const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
        const double f[3] = {double{p.x} - i, double{p.y} - j, double{p.z} - k};
        double expected = 0;
        for (int c = 0; c < 8; ++c) {
            const double w =
                (c & 4 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 1 ? f[2] : 1 - f[2]);
            expected += w * double{dense.at(i + (c >> 2), j + (c >> 1 & 1), k + (c & 1))};
        }
        ASSERT_NEAR(double{grid->trilinear(p)}, expected, 1e-6);
    }
}

TEST(BrickGrid, StochasticLookupTakesTheUpperCornerExactlyWhereTheNumberIsBelowTheFraction) {
    const Dense dense(5, VoxelType::single_float);
    const auto grid = dense.grid(VoxelType::single_float);
    Rng rng(12);
    for (int n = 0; n < 20000; ++n) {
        Vec3f p, f, u;
        std::array<int, 3> corner;
        const int c = n % 8;
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            p[a] = static_cast<float>(dense.corner[i]) + rng.next() * static_cast<float>(dense.size[i] - 1);
            f[a] = p[a] - std::floor(p[a]);
            const bool upper = c >> a & 1 && f[a] > 0;
            u[a] = upper ? std::nextafter(f[a], 0.0f) : f[a];
            corner[i] = floor_to_int(p[a]) + upper;
        }
        ASSERT_EQ(grid->stochastic(p, u), dense.at(corner[0], corner[1], corner[2]));
    }
}

/// Weight of the cubic B-spline centred on 0 at distance x (its textbook form).
double cubic_b_spline(double x) {
    x = std::fabs(x);
    return x >= 2 ? 0 : x >= 1 ? (2 - x) * (2 - x) * (2 - x) / 6 : 2.0 / 3 - x * x + x * x * x / 2;
}

TEST_P(BrickGridOfType, NearestAndTricubicMatchTheirFormulasInDoublePrecision) {
    const Dense dense(4, GetParam());
    const auto grid = dense.grid(GetParam());
    Rng rng(14);
    for (int n = 0; n < 50000; ++n) {
        const Vec3f p = dense.point(rng, n, 2);
        const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
        double expected = 0;
        for (int c = 0; c < 64; ++c) {
            const int x = i - 1 + (c >> 4), y = j - 1 + (c >> 2 & 3), z = k - 1 + (c & 3);
            expected += cubic_b_spline(double{p.x} - x) * cubic_b_spline(double{p.y} - y) *
                        cubic_b_spline(double{p.z} - z) * double{dense.at(x, y, z)};
        }
        ASSERT_NEAR(double{grid->evaluate(Filter::tricubic, p)}, expected, 1e-6);
        const auto nearest = [](float x) { return static_cast<int>(std::floor(double{x} + 0.5)); };
        ASSERT_EQ(grid->evaluate(Filter::nearest, p), dense.at(nearest(p.x), nearest(p.y), nearest(p.z)));
        ASSERT_EQ(grid->evaluate(Filter::trilinear, p), grid->trilinear(p));
    }
}

TEST(BrickGrid, TricubicIsExactWhereVoxelsAreEqual) {
    const float value = 0.1f;
    const auto grid = BrickGridBuilder({}, value, VoxelType::single_float, 0).finish(0, {});
    Rng rng(15);
    for (int n = 0; n < 1000; ++n)
        ASSERT_EQ(grid->tricubic(Vec3f(rng.next(), rng.next(), rng.next()) * 100), value);
    for (const float x : {1e10f, -1e10f, 3e38f, kInfinity, -kInfinity})
        ASSERT_EQ(grid->tricubic(Vec3f(x, 0.5f, 0.5f)), value);
}

TEST(Filter, TheCubicPicksEachVoxelInProportionToItsWeight) {
    constexpr int kNumbers = 100000;  // evenly spaced, so that counts are off by the rounding of one or two
    for (float f = 0; f <= 1; f += 0.0625f) {
        int counts[4] = {};
        for (int s = 0; s < kNumbers; ++s)
            ++counts[pick_cubic_offset(f, (static_cast<float>(s) + 0.5f) / kNumbers) + 1];
        for (int v = 0; v < 4; ++v)
            ASSERT_NEAR(counts[v], kNumbers * cubic_b_spline(double{f} - (v - 1)), 2) << f << ' ' << v;
    }
}

TEST(Filter, TheCubicsTopmostVoxelHasNoPartAtIntegers) {
    EXPECT_EQ(pick_cubic_offset(0, 0), -1);
    EXPECT_EQ(pick_cubic_offset(0, kOneMinusEpsilon), 1);
    EXPECT_EQ(pick_cubic_offset(1, 0), 0);  // where p - floor(p) rounds to 1
    EXPECT_EQ(pick_cubic_offset(1, kOneMinusEpsilon), 2);
}

TEST(BrickGrid, MeanOfStochasticLookupsIsTheFiltersValue) {
    // 50 points and 3 filters with fixed seeds; a bound of 6 standard errors false-alarms with probability
    // 150 * 2e-9.
    const Dense dense(7, VoxelType::single_float);
    const auto grid = dense.grid(VoxelType::single_float);
    Rng rng(13);
    for (int n = 0; n < 150; ++n) {
        const Filter filter = std::array{Filter::nearest, Filter::trilinear, Filter::tricubic}[n % 3];
        Vec3f p;
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            p[a] = static_cast<float>(dense.corner[i]) + rng.next() * static_cast<float>(dense.size[i]);
        }
        double sum = 0, squares = 0;
        constexpr int kSamples = 20000;
        for (int s = 0; s < kSamples; ++s) {
            const double v = double{grid->stochastic(filter, p, Vec3f(rng.next(), rng.next(), rng.next()))};
            sum += v;
            squares += v * v;
        }
        const double mean = sum / kSamples, variance = std::max(squares / kSamples - mean * mean, 0.0);
        EXPECT_NEAR(mean, double{grid->evaluate(filter, p)}, 6 * std::sqrt(variance / kSamples) + 1e-6);
    }
}

TEST(BrickGrid, HalvesConvertAsImathDoes) {
    for (std::uint32_t bits = 0; bits < 65536; ++bits) {
        const auto h = static_cast<std::uint16_t>(bits);
        const float ours = half_to_float(h), theirs = imath_half_to_float(h);
        ASSERT_TRUE(ours == theirs || (std::isnan(ours) && std::isnan(theirs))) << bits;
        ASSERT_EQ(std::signbit(ours), std::signbit(theirs)) << bits;
    }
}

TEST(BrickGrid, TilesOfAllSizesStayConstants) {
    const IndexBox extent{{-4096, -4096, -4096}, {4095, 127, 127}};
    BrickGridBuilder builder(extent, 0.5f, VoxelType::single_float, 0);
    builder.set_tile({-4096, -4096, -4096}, 4096, 2.0f);
    builder.set_tile({0, 0, 0}, 128, 3.0f);
    builder.set_tile({128, 0, 8}, 8, 4.0f);
    const auto grid = builder.finish(0, {});
    EXPECT_EQ(grid->brick_count(), 0u);
    EXPECT_LT(grid->bytes(), 400000u);  // 64 * 33 * 33 blocks of 4 bytes and one block of cells
    EXPECT_EQ(grid->lookup(-4096, -4096, -4096), 2.0f);
    EXPECT_EQ(grid->lookup(-1, -1, -1), 2.0f);
    EXPECT_EQ(grid->lookup(0, -1, -1), 0.5f);
    EXPECT_EQ(grid->lookup(127, 127, 127), 3.0f);
    EXPECT_EQ(grid->lookup(128, 7, 15), 4.0f);
    EXPECT_EQ(grid->lookup(128, 7, 16), 0.5f);
    EXPECT_EQ(grid->lookup(136, 7, 15), 0.5f);
    EXPECT_EQ(grid->bounds(), (IndexBox{{-4096, -4096, -4096}, {135, 127, 127}}));
    EXPECT_EQ(grid->trilinear(Vec3f(-50, -50, -50)), 2.0f);
}

TEST(BrickGrid, LaterPartsReplaceEarlierOnes) {
    BrickGridBuilder builder({{0, 0, 0}, {127, 127, 127}}, 0, VoxelType::single_float, 1);
    builder.set_tile({0, 0, 0}, 128, 1.0f);
    std::vector<float> ramp(512);
    for (std::size_t v = 0; v < ramp.size(); ++v)
        ramp[v] = static_cast<float>(v);
    builder.set_brick({8, 16, 24}, ramp.data());
    EXPECT_THROW(builder.set_brick({16, 16, 24}, ramp.data()), std::length_error);
    EXPECT_THROW(builder.set_brick({128, 0, 0}, ramp.data()), std::out_of_range);
    const auto grid = builder.finish(0, {});
    EXPECT_EQ(grid->lookup(7, 16, 24), 1.0f);
    EXPECT_EQ(grid->lookup(9, 18, 27), 64.0f + 16.0f + 3.0f);
}

TEST(BrickGrid, EqualVoxelsNeedNoMemory) {
    const std::vector<float> ones(128 * 128 * 128, 1.0f);
    const auto grid = brick_grid_of_dense({0, 0, 0}, {128, 128, 128}, ones.data());
    EXPECT_EQ(grid->brick_count(), 0u);
    EXPECT_LT(grid->bytes(), 1000u);
    EXPECT_EQ(grid->lookup(127, 0, 64), 1.0f);
    EXPECT_EQ(grid->active_voxels(), 128 * 128 * 128);
    EXPECT_EQ(grid->active_bounds(), (IndexBox{{0, 0, 0}, {127, 127, 127}}));
}

TEST(BrickGrid, EmptyGridIsItsBackground) {
    const auto grid = BrickGridBuilder({}, 0.75f, VoxelType::half_float, 0).finish(0, {});
    EXPECT_TRUE(grid->bounds().empty());
    EXPECT_EQ(grid->lookup(0, 0, 0), 0.75f);
    EXPECT_EQ(grid->trilinear(Vec3f(0.5f)), 0.75f);
    EXPECT_EQ(grid->stochastic(Vec3f(1e9f), Vec3f(0.5f)), 0.75f);
}

TEST(BrickGrid, PointsThatAreHugeOrNoNumbersReadTheBackground) {
    const Dense dense(2, VoxelType::single_float);
    const auto grid = dense.grid(VoxelType::single_float);
    for (const float x : {1e30f, -1e30f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN()}) {
        EXPECT_EQ(grid->stochastic(Vec3f(x, 0, 0), Vec3f(0.5f)), dense.background);
        EXPECT_EQ(grid->lookup(floor_to_int(x), 0, 0), dense.background);
    }
}

TEST(BrickGrid, RefusesTablesThatAreTooLargeOrTooFarAway) {
    const auto build = [](const IndexBox& box) { BrickGridBuilder(box, 0, VoxelType::single_float, 0); };
    EXPECT_NO_THROW(build({{-16384, -16384, -16384}, {16383, 16383, 16383}}));  // 2^24 blocks
    EXPECT_THROW(build({{-16385, -16384, -16384}, {16383, 16383, 16383}}), std::length_error);
    EXPECT_THROW(build({{-1 << 25, 0, 0}, {0, 0, 0}}), std::length_error);
    EXPECT_THROW(build({{INT32_MIN, INT32_MIN, INT32_MIN}, {INT32_MAX, INT32_MAX, INT32_MAX}}),
                 std::length_error);
}

}  // namespace
}  // namespace nephele
