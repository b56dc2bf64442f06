// SPDX-License-Identifier: GPL-3.0-or-later
// Upper and lower bounds of a field over cells of 8^3 voxels, for walks of rays. Cells merge into cubes of 16
// to 128 voxels where fewer steps are worth more null collisions (see majorant_grid.cpp).
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "grids/cell_bounds.h"
#include "grids/majorant_walk.h"
#include "math/vec.h"

namespace nephele {

class MajorantGrid {
  public:
    static constexpr int kCellsPerBlock = 4096;

    struct Bound {
        float majorant = 0, minorant = 0;
        int level = 0;  ///< the bound holds on an aligned cube of 2^level cells a side
    };

    /// `sigma_scale`: sigma_t that a value of 1 stands for, per unit of index space; it decides what merges.
    /// Without minorants every minorant is 0, and memory is halved.
    explicit MajorantGrid(const CellBounds& bounds, float sigma_scale, bool with_minorants = false);
    /// Of a grid under the trilinear filter.
    explicit MajorantGrid(const BrickGrid& grid, float sigma_scale, bool with_minorants = false)
        : MajorantGrid(CellBounds::of_grid(grid, Filter::trilinear), sigma_scale, with_minorants) {}

    float global_majorant() const { return global_majorant_; }
    float global_minorant() const { return global_minorant_; }
    const Bounds& background() const { return background_; }
    std::size_t bytes() const;

    /// Bound at cell (x, y, z), counted from the table's first cell; it must lie inside.
    Bound bound_at(int x, int y, int z) const {
        const auto ux = static_cast<std::uint32_t>(x), uy = static_cast<std::uint32_t>(y),
                   uz = static_cast<std::uint32_t>(z);
        const Block& block =
            blocks_[(std::size_t{ux >> 4} * blocks_per_axis_[1] + (uy >> 4)) * blocks_per_axis_[2] +
                    (uz >> 4)];
        if (block.node < 0)
            return unpack(block.packed, block.minorant);
        const std::size_t i = static_cast<std::size_t>(block.node) * kCellsPerBlock +
                              ((ux & 15) << 8 | (uy & 15) << 4 | (uz & 15));
        return unpack(packed_[i], minorants_.empty() ? 0 : minorants_[i]);
    }
    /// The cube of cells around a cell that have one bound.
    CellBox box_at(const std::array<int, 3>& cell) const {
        const Bound bound = bound_at(cell[0], cell[1], cell[2]);
        const int cube = 1 << bound.level;
        const std::array<int, 3> first{cell[0] & -cube, cell[1] & -cube, cell[2] & -cube};
        return {first, {first[0] + cube, first[1] + cube, first[2] + cube}, bound.majorant, bound.minorant};
    }
    /// First voxel of the table's first cell: a multiple of 8.
    const std::array<int, 3>& origin() const { return origin_; }
    /// Number of cells of the table.
    const std::array<int, 3>& cells() const { return cells_; }
    /// Outside [support_min, support_max) there is only the background. Equal where that is all.
    Vec3f support_min() const { return support_min_; }
    Vec3f support_max() const { return support_max_; }

  private:
    struct Block {
        std::int32_t node = -1;  // number of 4096 cells, or -1: one bound
        std::uint32_t packed = 4;
        float minorant = 0;
    };
    // A majorant is rounded up to a multiple of 8 units in the last place; its level takes the three free
    // bits.
    static std::uint32_t pack(float majorant, int level);
    static Bound unpack(std::uint32_t packed, float minorant) {
        return {std::bit_cast<float>(packed & ~7u), minorant, static_cast<int>(packed & 7u)};
    }
    void build_block(const CellBounds& bounds, float sigma_scale, const std::array<int, 3>& position,
                     Block& block);
    void drop_uniform_nodes();

    std::array<int, 3> origin_{}, cells_{};
    std::array<std::uint32_t, 3> blocks_per_axis_{};
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> packed_;
    std::vector<float> minorants_;
    Vec3f support_min_, support_max_;
    Bounds background_;
    float global_majorant_ = 0, global_minorant_ = 0;
};

using MajorantWalk = BoxWalk<MajorantGrid>;

}  // namespace nephele
