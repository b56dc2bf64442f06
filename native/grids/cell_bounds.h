// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of a scalar field over cells of index space: what majorant grids and kd-trees are built from, and
// what answers "between which values does the field stay in this box?".
//
// Cell b of an axis is the closed interval [8b, 8b + 8] of index space. The field is a BrickGrid under a
// filter, or any function whose values over a box can be bounded. Cells lie in a sparse table of blocks of
// 16^3; a block whose cells all have the same bounds is one entry. Every level of a pyramid above the cells
// is kept, too: a unit of level l is a cube of 2^l cells.
//
//     level 0          1         2        3       4        5 and up
//     cells_           + 8^3     + 4^3    + 2^3   blocks   halved per axis, down to one
//     |<-- of the blocks that are not uniform ->|
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

#include "grids/brick_grid.h"
#include "grids/filter.h"
#include "math/vec.h"

namespace nephele {

/// The values of a field in some place lie in [min, max]. As it comes: of no place at all.
struct Bounds {
    float max = -kInfinity, min = kInfinity;

    bool operator==(const Bounds&) const = default;
    void include(const Bounds& other) {
        max = std::max(max, other.max);
        min = std::min(min, other.min);
    }
};

class CellBounds {
  public:
    static constexpr int kCellSize = 8, kBlockCells = 16;
    /// Most cells that a function is asked for.
    static constexpr std::size_t kMaxFunctionCells = std::size_t{1} << 24;

    /// Bounds of the function over the closed box [lo, hi] of index space; called from many threads at once.
    using Function = std::function<Bounds(Vec3f lo_index, Vec3f hi_index)>;

    /// Bounds of `grid.evaluate(filter, p)` and `grid.stochastic(filter, p, u)`. A cell's bounds run over
    /// exactly the voxels that a point of it can see, but for a few units in the last place of room for the
    /// rounding of interpolation.
    static CellBounds of_grid(const BrickGrid& grid, Filter filter);
    /// Bounds of a function at the points [min, max + 1) of `box`; beyond, the field lies within
    /// `background`. The function is called once for each cell that meets the box, and for the whole cell:
    /// best choose an index space where the box is made of whole cells. What it returns as NaN counts as
    /// unbounded. Throws std::length_error for more than kMaxFunctionCells cells, or a box beyond 2^24.
    static CellBounds of_function(const IndexBox& box, Bounds background, const Function& function);

    CellBounds(CellBounds&&) = default;
    CellBounds& operator=(CellBounds&&) = default;

    /// Bounds outside the support.
    const Bounds& background() const { return background_; }
    /// Bounds everywhere. Infinite where a function could not be bounded.
    const Bounds& global() const { return global_; }
    /// Outside [support_min, support_max) there is only the background. Equal where that is all.
    Vec3f support_min() const { return support_min_; }
    Vec3f support_max() const { return support_max_; }
    /// Where the table's first cell begins: a multiple of 8.
    const std::array<int, 3>& origin() const { return origin_; }
    /// Number of cells of the table, and of its blocks; the last blocks may be in part outside.
    const std::array<int, 3>& cells() const { return cells_; }
    const std::array<int, 3>& blocks() const { return blocks_per_axis_; }
    /// Number of levels: the last one has a single unit (none where there are no cells).
    int levels() const { return 5 + static_cast<int>(coarse_.size()); }
    std::size_t bytes() const;

    /// Bounds of unit (x, y, z) of a level; it must touch the table.
    const Bounds& at(int level, int x, int y, int z) const {
        if (level > 4)
            return coarse_[static_cast<std::size_t>(level - 5)].at(x, y, z);
        const int shift = 4 - level;
        const Block& block = block_at(x >> shift, y >> shift, z >> shift);
        if (!block.units || level == 4)
            return block.bounds;
        const int mask = (1 << shift) - 1;
        return block.units[kFirstUnit[level] + static_cast<std::size_t>((x & mask) << 2 * shift |
                                                                        (y & mask) << shift | (z & mask))];
    }
    /// Whether all cells of a block have the same bounds.
    bool is_uniform(int bx, int by, int bz) const { return !block_at(bx, by, bz).units; }

    /// Bounds over the closed box [lo, hi] of index space, from at most 3^3 units: tight to the cell for
    /// small boxes, coarse for large ones. A box with a NaN, or turned inside out, is taken to be all of
    /// space.
    Bounds range(Vec3f lo_index, Vec3f hi_index) const;

  private:
    /// Position of each level's first unit among those of a block.
    static constexpr std::size_t kFirstUnit[4] = {0, 4096, 4096 + 512, 4096 + 512 + 64};
    static constexpr std::size_t kUnits = 4096 + 512 + 64 + 8;

    struct Block {
        Bounds bounds;
        std::unique_ptr<Bounds[]> units;  // null: all are `bounds`
    };
    struct CoarseLevel {
        std::array<int, 3> size;
        std::vector<Bounds> units;
        const Bounds& at(int x, int y, int z) const {
            return units[(static_cast<std::size_t>(x) * static_cast<std::size_t>(size[1]) +
                          static_cast<std::size_t>(y)) *
                             static_cast<std::size_t>(size[2]) +
                         static_cast<std::size_t>(z)];
        }
    };

    explicit CellBounds(Bounds background) : background_(background), global_(background) {}
    const Block& block_at(int bx, int by, int bz) const {
        return blocks_[(static_cast<std::size_t>(bx) * static_cast<std::size_t>(blocks_per_axis_[1]) +
                        static_cast<std::size_t>(by)) *
                           static_cast<std::size_t>(blocks_per_axis_[2]) +
                       static_cast<std::size_t>(bz)];
    }
    void make_table(const std::array<int, 3>& first, const std::array<int, 3>& last);
    template <class Extremes>
    void fill_from(const BrickGrid& grid, Filter filter);
    /// First point of a block.
    std::array<int, 3> corner_of(std::size_t block) const;
    static void finish_block(Block& block, std::unique_ptr<Bounds[]> units);
    void finish();

    std::array<int, 3> origin_{}, cells_{}, blocks_per_axis_{};
    std::vector<Block> blocks_;
    std::vector<CoarseLevel> coarse_;
    Vec3f support_min_, support_max_;
    Bounds background_, global_;
};

}  // namespace nephele
