// SPDX-License-Identifier: GPL-3.0-or-later
// Majorant grids: what merges, and bounds against brute force.
#include "grids/majorant_grid.h"

#include <gtest/gtest.h>

#include "grid_fixtures.h"

namespace nephele {
namespace {

using namespace test;

TEST(MajorantGrid, UnmergedBoundsAreThoseOfTheNineCubedVoxels) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const GridPtr grid = random_grid(seed);
        const MajorantGrid majorants(*grid, 1e9f, true);  // so dense that no step is worth saving
        for (int x = 0; x < majorants.cells()[0]; ++x) {
            for (int y = 0; y < majorants.cells()[1]; ++y) {
                for (int z = 0; z < majorants.cells()[2]; ++z) {
                    float most = 0, least = kInfinity;
                    for (int v = 0; v < 729; ++v) {
                        const auto& o = majorants.origin();
                        const float value = grid->lookup(o[0] + 8 * x + v / 81, o[1] + 8 * y + v / 9 % 9,
                                                         o[2] + 8 * z + v % 9);
                        most = std::max(most, value);
                        least = std::min(least, value);
                    }
                    const auto bound = majorants.bound_at(x, y, z);
                    ASSERT_GE(bound.majorant, most);
                    ASSERT_LE(bound.minorant, least);
                    // Where equal values were merged, the bounds are as good; otherwise only rounding is
                    // added.
                    ASSERT_LE(bound.majorant, most * (1 + 0x1p-19f));
                    ASSERT_GE(bound.minorant, least - most * 0x1p-19f);
                    if (most == least) {
                        ASSERT_EQ(bound.majorant, bound.minorant);  // values here are halves: no rounding up
                    }
                }
            }
        }
    }
}

TEST(MajorantGrid, MergesInThinMediaOnly) {
    const GridPtr grid = random_grid(4);
    const MajorantGrid thin(*grid, 1e-9f), dense(*grid, 1e9f);
    bool coarse = false, fine = false;
    for (int x = 0; x < thin.cells()[0]; ++x) {
        for (int y = 0; y < thin.cells()[1]; ++y) {
            for (int z = 0; z < thin.cells()[2]; ++z) {
                ASSERT_EQ(thin.bound_at(x, y, z).level, 4);
                ASSERT_GE(thin.bound_at(x, y, z).majorant, dense.bound_at(x, y, z).majorant);
                coarse |= thin.bound_at(x, y, z).majorant > dense.bound_at(x, y, z).majorant;
                fine |= dense.bound_at(x, y, z).level == 0;
            }
        }
    }
    EXPECT_TRUE(coarse);
    EXPECT_TRUE(fine);
    EXPECT_LT(thin.bytes(), dense.bytes());
}

TEST(MajorantGrid, GlobalBoundsAreThoseOfAllVoxels) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const GridPtr grid = random_grid(seed);
        const MajorantGrid majorants(*grid, 1, true);
        float most = grid->background(), least = grid->background();
        const IndexBox& b = grid->bounds();
        for (int i = b.min[0]; i <= b.max[0]; ++i) {
            for (int j = b.min[1]; j <= b.max[1]; ++j) {
                for (int k = b.min[2]; k <= b.max[2]; ++k) {
                    most = std::max(most, grid->lookup(i, j, k));
                    least = std::min(least, grid->lookup(i, j, k));
                }
            }
        }
        EXPECT_GE(majorants.global_majorant(), most);
        EXPECT_LE(majorants.global_majorant(), most * (1 + 0x1p-19f));
        EXPECT_LE(majorants.global_minorant(), least);
        GlobalMajorantWalk walk(majorants, Vec3f(0), Vec3f(1, 0, 0), 2, 7);
        MajorantPiece piece;
        ASSERT_TRUE(walk.next(piece));
        EXPECT_EQ(piece.t_end, 7.0f);
        EXPECT_EQ(piece.majorant, majorants.global_majorant());
        EXPECT_EQ(walk.point(3).x, 3.0f);
        EXPECT_FALSE(walk.next(piece));
        EXPECT_FALSE(GlobalMajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 7, 7).next(piece));
    }
}

}  // namespace
}  // namespace nephele
