// SPDX-License-Identifier: GPL-3.0-or-later
// Kd-trees: leaves divide the table, bound their cells, and are no more than pay. Boxes of both accelerators.
#include "grids/kd_tree.h"

#include <gtest/gtest.h>

#include <bit>

#include "grid_fixtures.h"
#include "grids/majorants.h"

namespace nephele {
namespace {

using namespace test;

bool is_same(const CellBox& a, const CellBox& b) {
    return a.first == b.first && a.end == b.end && a.majorant == b.majorant && a.minorant == b.minorant;
}

/// Checks the box around every cell: it holds the cell, is that of its own corners, and bounds what it holds.
void expect_boxes(const CellBounds& bounds, const Majorants& majorants) {
    const auto& n = bounds.cells();
    for (int x = 0; x < n[0]; ++x) {
        for (int y = 0; y < n[1]; ++y) {
            for (int z = 0; z < n[2]; ++z) {
                const CellBox box = majorants.box_at({x, y, z});
                for (std::size_t a = 0; a < 3; ++a) {
                    const int c = std::array{x, y, z}[a];
                    ASSERT_LE(box.first[a], c);
                    ASSERT_GT(box.end[a], c);
                    ASSERT_GE(box.first[a], 0);
                }
                ASSERT_TRUE(is_same(majorants.box_at(box.first), box));
                const auto last = [&](std::size_t a) { return std::min(box.end[a], n[a]) - 1; };
                ASSERT_TRUE(is_same(majorants.box_at({last(0), last(1), last(2)}), box));
                ASSERT_GE(box.majorant, bounds.at(0, x, y, z).max);
                ASSERT_LE(box.minorant, bounds.at(0, x, y, z).min);
                ASSERT_LE(box.majorant, majorants.global_majorant());
                ASSERT_GE(box.minorant, majorants.global_minorant());
            }
        }
    }
}

TEST(Majorants, BoxesOfBothAcceleratorsDivideTheTableAndBoundTheirCells) {
    for (std::uint64_t seed = 1; seed <= 16; ++seed) {
        const CellBounds bounds = CellBounds::of_grid(*random_grid(seed), kFilters[seed % 3]);
        for (const Accelerator accelerator : {Accelerator::grid, Accelerator::kdtree}) {
            const float sigma_scale = std::array{1e-4f, 0.01f, 1.0f, 1e3f}[seed / 2 % 4];
            const Majorants majorants(bounds, accelerator, sigma_scale, seed % 4 != 0);
            EXPECT_EQ(majorants.accelerator(), accelerator);
            expect_boxes(bounds, majorants);
            if (HasFatalFailure())
                return;
        }
    }
}

TEST(KdTree, DenseMediaAreBoundedCellByCell) {
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        const CellBounds bounds = CellBounds::of_grid(*random_grid(seed), Filter::trilinear);
        const KdTree tree(bounds, 1e9f, true);
        const auto& n = bounds.cells();
        const int needed = std::bit_width(static_cast<unsigned>(n[0] - 1)) +
                           std::bit_width(static_cast<unsigned>(n[1] - 1)) +
                           std::bit_width(static_cast<unsigned>(n[2] - 1));
        ASSERT_LE(tree.depth(), KdTree::kMaxDepth);
        ASSERT_LE(tree.bytes(), sizeof(tree) + (std::size_t{8} << (KdTree::kMaxDepth + 1)));
        if (needed > KdTree::kMaxDepth)
            continue;  // single cells are out of reach
        for (int x = 0; x < n[0]; ++x) {
            for (int y = 0; y < n[1]; ++y) {
                for (int z = 0; z < n[2]; ++z) {
                    // 12 bits of mantissa: outward by 2^-12 at most.
                    const CellBox box = tree.box_at({x, y, z});
                    const Bounds& cell = bounds.at(0, x, y, z);
                    ASSERT_LE(box.majorant, cell.max * (1 + 0x1p-12f)) << "seed " << seed;
                    ASSERT_GE(box.minorant, cell.min * (1 - 0x1p-12f)) << "seed " << seed;
                }
            }
        }
    }
}

TEST(KdTree, ThinMediaAreOneLeaf) {
    const CellBounds bounds = CellBounds::of_grid(*random_grid(4), Filter::trilinear);
    const KdTree thin(bounds, 1e-9f), dense(bounds, 1e9f);
    EXPECT_EQ(thin.leaves(), 1u);
    EXPECT_EQ(thin.depth(), 0);
    EXPECT_GT(dense.leaves(), 100u);
    EXPECT_GE(dense.depth(), 7);
    EXPECT_LT(thin.bytes(), dense.bytes());
}

TEST(KdTree, SplitsWhereTheFieldDoes) {
    // A slab two cells thick in a table of 64^3 cells, along any axis: three leaves; where it begins at an
    // odd cell, the first splits see it two cells at a time, and leave up to two thin leaves more.
    for (std::size_t axis = 0; axis < 3; ++axis) {
        for (const int at : {8, 17, 31, 60}) {
            const CellBounds bounds =
                CellBounds::of_function({{0, 0, 0}, {511, 511, 511}}, {0, 0}, [&](Vec3f lo, Vec3f) {
                    const int cell = static_cast<int>(lo[static_cast<int>(axis)]) / 8;
                    return cell == at || cell == at + 1 ? Bounds{1, 1} : Bounds{0, 0};
                });
            const KdTree tree(bounds, 1, true);
            EXPECT_GE(tree.leaves(), 3u);
            EXPECT_LE(tree.leaves(), at % 2 ? 5u : 3u) << "axis " << axis << " at " << at;
            std::array<int, 3> cell{5, 5, 5};
            cell[axis] = at;
            const CellBox box = tree.box_at(cell);
            EXPECT_EQ(box.first[axis], at);
            EXPECT_EQ(box.end[axis], at + 2);
            EXPECT_EQ(box.end[(axis + 1) % 3] - box.first[(axis + 1) % 3], 64);
            EXPECT_EQ(box.majorant, 1.0f);
            EXPECT_EQ(box.minorant, 1.0f);
        }
    }
}

TEST(KdTree, UnboundedCellsStayApartFromBuildingForever) {
    const CellBounds bounds =
        CellBounds::of_function({{0, 0, 0}, {127, 127, 127}}, {0, 0}, [](Vec3f lo, Vec3f) {
            return lo.x == 64 && lo.y == 64 && lo.z == 64 ? Bounds{kInfinity, 0} : Bounds{lo.x, 0};
        });
    const KdTree tree(bounds, 1);
    EXPECT_EQ(tree.global_majorant(), kInfinity);
    EXPECT_EQ(tree.box_at({8, 8, 8}).majorant, kInfinity);
}

}  // namespace
}  // namespace nephele
