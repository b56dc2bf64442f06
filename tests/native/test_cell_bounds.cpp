// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of cells and of boxes, against brute force over voxels and points.
#include "grids/cell_bounds.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>

#include "grid_fixtures.h"

namespace nephele {
namespace {

using namespace test;

/// Extremes of the voxels that points of the closed cell can see.
Bounds brute_force(const BrickGrid& grid, Filter filter, const std::array<int, 3>& corner) {
    const int more = filter == Filter::tricubic ? 1 : 0;
    Bounds out;
    for (int i = corner[0] - more; i <= corner[0] + 8 + more; ++i) {
        for (int j = corner[1] - more; j <= corner[1] + 8 + more; ++j) {
            for (int k = corner[2] - more; k <= corner[2] + 8 + more; ++k) {
                const float v = grid.lookup(i, j, k);
                out.include({v, v});
            }
        }
    }
    return out;
}

void expect_cell(const BrickGrid& grid, Filter filter, const CellBounds& bounds, int x, int y, int z) {
    const auto& o = bounds.origin();
    const Bounds expected = brute_force(grid, filter, {o[0] + 8 * x, o[1] + 8 * y, o[2] + 8 * z});
    const Bounds& found = bounds.at(0, x, y, z);
    ASSERT_GE(found.max, expected.max);
    ASSERT_LE(found.min, expected.min);
    ASSERT_LE(found.max, expected.max * (1 + 0x1p-19f));  // only rounding is added
    ASSERT_GE(found.min, expected.min - expected.max * 0x1p-19f);
    if (filter == Filter::nearest || expected.max == expected.min) {
        ASSERT_EQ(found, expected);
    }
}

TEST(CellBounds, RunOverExactlyTheVoxelsThatACellCanSee) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const GridPtr grid = random_grid(seed);
        const Filter filter = kFilters[seed / 2 % 3];
        const CellBounds bounds = CellBounds::of_grid(*grid, filter);
        const auto& n = bounds.cells();
        for (int x = 0; x < n[0]; ++x) {
            for (int y = 0; y < n[1]; ++y) {
                for (int z = 0; z < n[2]; ++z) {
                    expect_cell(*grid, filter, bounds, x, y, z);
                    if (HasFatalFailure())
                        return;
                    for (int level = 1; level < bounds.levels(); ++level) {
                        const Bounds& unit = bounds.at(level, x >> level, y >> level, z >> level);
                        ASSERT_GE(unit.max, bounds.at(0, x, y, z).max);
                        ASSERT_LE(unit.min, bounds.at(0, x, y, z).min);
                    }
                }
            }
        }
        EXPECT_EQ(bounds.global(), bounds.range(Vec3f(-1e6f), Vec3f(1e6f))) << "seed " << seed;
    }
}

TEST(CellBounds, TheSupportIsWhereAFilterSeesMoreThanTheBackground) {
    // One voxel: its filters reach 0.5, 1 and 2 voxels; the table ends where cells see the background alone.
    const float reach[] = {0.5f, 1, 2};
    for (const Filter filter : kFilters) {
        for (const int at : {-9, -8, -2, -1, 0, 1, 7, 8, 15}) {
            const float value = 2;
            const GridPtr grid = brick_grid_of_dense({at, at, at}, {1, 1, 1}, &value, 0.5f);
            const CellBounds bounds = CellBounds::of_grid(*grid, filter);
            const float r = reach[static_cast<int>(filter)], centre = static_cast<float>(at);
            EXPECT_EQ(bounds.support_min(), Vec3f(centre - r));
            EXPECT_EQ(bounds.support_max(), Vec3f(centre + r));
            const int cells = bounds.cells()[0], first = bounds.origin()[0];
            EXPECT_LE(static_cast<float>(first), centre - r);
            EXPECT_GT(static_cast<float>(first + 8), centre - r);
            EXPECT_GE(static_cast<float>(first + 8 * cells), centre + r);
            EXPECT_LT(static_cast<float>(first + 8 * (cells - 1)), centre + r);
            EXPECT_EQ(bounds.background(), (Bounds{0.5f, 0.5f}));
            const float inside = std::nextafter(centre + r, centre), outside = centre + r;
            EXPECT_GE(grid->evaluate(filter, Vec3f(inside)), 0.5f);
            EXPECT_EQ(grid->evaluate(filter, Vec3f(outside)), 0.5f);
            EXPECT_EQ(bounds.range(Vec3f(outside), Vec3f(outside + 5)), bounds.background());
        }
    }
}

TEST(CellBounds, RangesBoundEveryLookupInTheBox) {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        const GridPtr grid = random_grid(seed);
        const Filter filter = kFilters[seed % 3];
        const CellBounds bounds = CellBounds::of_grid(*grid, filter);
        const Vec3f size = bounds.support_max() - bounds.support_min();
        Rng rng(seed + 3000);
        for (int n = 0; n < 300; ++n) {
            Vec3f lo, hi;
            const float scale = std::pow(2.0f, 1 - 12 * rng.next());  // of all sizes
            for (int a = 0; a < 3; ++a) {
                lo[a] = bounds.support_min()[a] + size[a] * (rng.next() * 1.4f - 0.2f);
                hi[a] = lo[a] + size[a] * scale * rng.next();
                if (rng.next() < 0.3f)
                    hi[a] = std::max(8 * std::floor(hi[a] / 8), lo[a]);
                if (rng.next() < 0.1f)
                    hi[a] = lo[a];
            }
            const Bounds range = bounds.range(lo, hi);
            for (int s = 0; s < 16; ++s) {
                Vec3f p;
                for (int a = 0; a < 3; ++a)
                    p[a] = s < 8 ? (s >> a & 1 ? lo[a] : hi[a])
                                 : std::min(lo[a] + (hi[a] - lo[a]) * rng.next(), hi[a]);
                expect_bounded(*grid, filter, p, range.min, range.max, rng, "seed " + std::to_string(seed));
                if (HasFatalFailure())
                    return;
            }
        }
    }
}

TEST(CellBounds, SmallRangesAreTightToTheCell) {
    const GridPtr grid = random_grid(4);
    const CellBounds bounds = CellBounds::of_grid(*grid, Filter::trilinear);
    const auto& n = bounds.cells();
    for (int x = 1; x + 3 < n[0]; ++x) {
        const int y = n[1] / 2, z = n[2] / 2;
        const auto point = [&](float cx) {
            return Vec3f(static_cast<float>(bounds.origin()[0]) + 8 * (static_cast<float>(x) + cx),
                         static_cast<float>(bounds.origin()[1] + 8 * y + 3),
                         static_cast<float>(bounds.origin()[2] + 8 * z + 3));
        };
        Bounds three = bounds.at(0, x, y, z);
        EXPECT_EQ(bounds.range(point(0.1f), point(0.9f)), three);
        three.include(bounds.at(0, x + 1, y, z));
        three.include(bounds.at(0, x + 2, y, z));
        EXPECT_EQ(bounds.range(point(0.1f), point(2.9f)), three);
    }
    const float nan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(bounds.range(Vec3f(nan, 0, 0), Vec3f(1)), bounds.global());
    EXPECT_EQ(bounds.range(Vec3f(1), Vec3f(0)), bounds.global());
    EXPECT_EQ(bounds.range(Vec3f(-kInfinity), Vec3f(kInfinity)), bounds.global());
}

TEST(CellBounds, GridsWithoutContentAreBackground) {
    const GridPtr grid = BrickGridBuilder({}, 0.3f, VoxelType::single_float, 0).finish(0, {});
    const CellBounds bounds = CellBounds::of_grid(*grid, Filter::tricubic);
    EXPECT_EQ(bounds.global(), (Bounds{0.3f, 0.3f}));
    EXPECT_EQ(bounds.range(Vec3f(-1), Vec3f(1)), (Bounds{0.3f, 0.3f}));
    EXPECT_EQ(bounds.support_min(), bounds.support_max());
}

TEST(CellBounds, LeaveRoomForTheRoundingOfInterpolation) {
    // 1 + (tiny - 1) is 0: the interpolation's end falls below both voxels.
    const float values[] = {1.0f, 1e-9f};
    const GridPtr grid = brick_grid_of_dense({-1, 0, 0}, {2, 1, 1}, values, 1e-9f);
    const Vec3f p(-1e-10f, 0, 0);
    ASSERT_LT(grid->trilinear(p), 1e-9f);
    EXPECT_LE(CellBounds::of_grid(*grid, Filter::trilinear).range(p, p).min, grid->trilinear(p));
}

/// A function whose bounds over a box are known exactly, but for rounding.
float wave(Vec3f p) {
    return std::fabs(p.x) * 0.01f + p.y * p.y * 0.001f + std::max(0.0f, p.z);
}
Bounds bounds_of_wave(Vec3f lo, Vec3f hi) {
    const auto magnitude = [](float a, float b) {
        const float most = std::max(std::fabs(a), std::fabs(b));
        return Bounds{most, a <= 0 && b >= 0 ? 0 : std::min(std::fabs(a), std::fabs(b))};
    };
    const Bounds x = magnitude(lo.x, hi.x), y = magnitude(lo.y, hi.y);
    const float up = 1 + 0x1p-20f;
    return {(x.max * 0.01f + y.max * y.max * 0.001f + std::max(0.0f, hi.z)) * up,
            (x.min * 0.01f + y.min * y.min * 0.001f + std::max(0.0f, lo.z)) / up};
}

TEST(CellBounds, OfAFunctionAskItOncePerCellAndHoldInEveryBox) {
    const IndexBox box{{-30, 5, -200}, {100, 44, 47}};
    std::atomic<int> calls = 0;
    const CellBounds bounds = CellBounds::of_function(box, {0, 0}, [&](Vec3f lo, Vec3f hi) {
        ++calls;
        return bounds_of_wave(lo, hi);
    });
    EXPECT_EQ(calls, bounds.cells()[0] * bounds.cells()[1] * bounds.cells()[2]);
    EXPECT_EQ(bounds.support_min(), Vec3f(-30, 5, -200));
    EXPECT_EQ(bounds.support_max(), Vec3f(101, 45, 48));
    Rng rng(5);
    for (int n = 0; n < 20000; ++n) {
        Vec3f lo, hi;
        const float scale = rng.next() < 0.5f ? 1.0f : 0.1f;
        for (int a = 0; a < 3; ++a) {
            lo[a] = -250 + 400 * rng.next();
            hi[a] = lo[a] + 200 * scale * rng.next();
        }
        const Bounds range = bounds.range(lo, hi);
        const Vec3f p = lo + (hi - lo) * Vec3f(rng.next(), rng.next(), rng.next());
        const Vec3f first = bounds.support_min(), end = bounds.support_max();
        const bool in = min(max(p, first), end) == p;
        const float value = in ? wave(p) : 0;
        ASSERT_LE(value, range.max);
        ASSERT_GE(value, range.min);
    }
}

TEST(CellBounds, OfAFunctionAreUniformWhereItIsConstant) {
    const IndexBox box{{0, 0, 0}, {511, 511, 511}};
    const CellBounds bounds = CellBounds::of_function(box, {0, 0}, [](Vec3f lo, Vec3f) {
        return lo.x < 128 && lo.y < 64 ? Bounds{2, 1} : Bounds{3, 3};
    });
    int uniform = 0;
    for (int b = 0; b < 64; ++b)
        uniform += bounds.is_uniform(b >> 4, b >> 2 & 3, b & 3);
    EXPECT_EQ(uniform, 60);
    EXPECT_EQ(bounds.global(), (Bounds{3, 0}));
}

TEST(CellBounds, OfAFunctionRefuseWhatTheyCannotHold) {
    const auto zero = [](Vec3f, Vec3f) { return Bounds{0, 0}; };
    EXPECT_THROW(CellBounds::of_function({{0, 0, 0}, {4095, 4095, 4095}}, {0, 0}, zero), std::length_error);
    EXPECT_THROW(CellBounds::of_function({{0, 0, 0}, {1 << 24, 7, 7}}, {0, 0}, zero), std::length_error);
    const float nan = std::numeric_limits<float>::quiet_NaN();
    const CellBounds odd = CellBounds::of_function({{0, 0, 0}, {15, 7, 7}}, {0, 0}, [&](Vec3f lo, Vec3f) {
        return lo.x > 0 ? Bounds{nan, nan} : Bounds{1, 1};
    });
    EXPECT_EQ(odd.at(0, 1, 0, 0), (Bounds{kInfinity, -kInfinity}));
    EXPECT_EQ(odd.at(0, 0, 0, 0), (Bounds{1, 1}));
    EXPECT_EQ(odd.global(), (Bounds{kInfinity, -kInfinity}));
}

}  // namespace
}  // namespace nephele
