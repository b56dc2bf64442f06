// SPDX-License-Identifier: GPL-3.0-or-later
// Building of cell bounds, and range queries.
#include "grids/cell_bounds.h"

#include <limits>
#include <stdexcept>

#include "base/parallel.h"
#include "grids/brick_extremes.h"

namespace nephele {

namespace {

constexpr int kBlockSize = CellBounds::kCellSize * CellBounds::kBlockCells;  // in voxels

std::array<int, 3> cell_of_unit(std::size_t i) {
    return {static_cast<int>(i >> 8), static_cast<int>(i >> 4 & 15), static_cast<int>(i & 15)};
}

/// Room for the rounding of nested linear interpolations of values within `b`: each one may leave the range
/// by 2^-23 of its largest magnitude. Interpolation between equal values is exact.
Bounds with_room(Bounds b, Filter filter) {
    if (filter == Filter::nearest || !(b.min < b.max))
        return b;
    const float room =
        std::max(std::fabs(b.max), std::fabs(b.min)) * (filter == Filter::tricubic ? 0x1p-20f : 0x1p-21f);
    b.max += room;
    b.min = b.min >= 0 ? std::max(b.min - room, 0.0f) : b.min - room;  // no sign is gained
    return b;
}

template <class Extremes>
std::vector<Extremes> extremes_of_bricks(const BrickGrid& grid) {
    std::vector<Extremes> extremes(grid.brick_count());
    parallel_ranges(std::size_t{0}, extremes.size(), 64, [&](const auto& range) {
        float voxels[BrickGrid::kBrickVoxels];
        for (std::size_t b = range.begin(); b != range.end(); ++b) {
            grid.read_brick(static_cast<std::int32_t>(b), voxels);
            extremes[b] = Extremes(voxels);
        }
    });
    return extremes;
}

/// Whether all voxels that a block at `corner` sees are known to be equal: they lie in 2^3 or 3^3 blocks of
/// the grid.
bool is_constant_block(const BrickGrid& grid, const std::array<int, 3>& corner, Reach reach, float& value) {
    const int offsets[3] = {-reach.below, 0, kBlockSize + reach.above - 1};
    const int first = reach.below > 0 ? 0 : 1;
    grid.constant_block_at(corner[0], corner[1], corner[2], value);
    for (int x = first; x < 3; ++x) {
        for (int y = first; y < 3; ++y) {
            for (int z = first; z < 3; ++z) {
                float other = 0;
                if (!grid.constant_block_at(corner[0] + offsets[x], corner[1] + offsets[y],
                                            corner[2] + offsets[z], other) ||
                    other != value)
                    return false;
            }
        }
    }
    return true;
}

/// Bounds of the cell whose first voxel is `corner`, from the bricks in it and around it.
template <class Extremes>
Bounds bounds_of_cell(const BrickGrid& grid, const std::vector<Extremes>& extremes,
                      const std::array<int, 3>& corner) {
    constexpr int kParts = static_cast<int>(Extremes::kParts), kBefore = Extremes::kBefore;
    Bounds bounds;
    std::size_t part = 0;
    for (int x = 0; x < kParts; ++x) {
        for (int y = 0; y < kParts; ++y) {
            for (int z = 0; z < kParts; ++z, ++part) {
                const BrickGrid::Cell c =
                    grid.cell_at(corner[0] + 8 * (x - kBefore), corner[1] + 8 * (y - kBefore),
                                 corner[2] + 8 * (z - kBefore));
                bounds.include(c.brick < 0 ? Bounds{c.constant, c.constant}
                                           : extremes[static_cast<std::size_t>(c.brick)].parts[part]);
            }
        }
    }
    return bounds;
}

}  // namespace

CellBounds CellBounds::of_grid(const BrickGrid& grid, Filter filter) {
    CellBounds out({grid.background(), grid.background()});
    const IndexBox& box = grid.bounds();
    if (box.empty()) {
        out.finish();
        return out;
    }
    const Reach reach = reach_of(filter);
    std::array<int, 3> first, last;  // voxels floor(p) of the points p of the support
    for (std::size_t a = 0; a < 3; ++a) {
        const int i = static_cast<int>(a);
        first[a] = box.min[a] - reach.above;
        last[a] = box.max[a] + reach.below;
        const float half = filter == Filter::nearest ? 0.5f : 0.0f;
        out.support_min_[i] = static_cast<float>(first[a]) + half;
        out.support_max_[i] = static_cast<float>(last[a] + 1) - half;
    }
    out.make_table(first, last);
    if (filter == Filter::tricubic) {
        out.fill_from<BrickExtremes<1, 2>>(grid, filter);
    } else {
        out.fill_from<BrickExtremes<0, 1>>(grid, filter);
    }
    out.finish();
    return out;
}

template <class Extremes>
void CellBounds::fill_from(const BrickGrid& grid, Filter filter) {
    const std::vector<Extremes> extremes = extremes_of_bricks<Extremes>(grid);
    parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
        const std::array<int, 3> corner = corner_of(b);
        float value = 0;
        if (is_constant_block(grid, corner, reach_of(filter), value)) {
            blocks_[b].bounds = {value, value};
            return;
        }
        auto units = std::make_unique_for_overwrite<Bounds[]>(kUnits);
        for (std::size_t i = 0; i < 4096; ++i) {
            const std::array<int, 3> cell = cell_of_unit(i);
            units[i] = with_room(
                bounds_of_cell(grid, extremes,
                               {corner[0] + 8 * cell[0], corner[1] + 8 * cell[1], corner[2] + 8 * cell[2]}),
                filter);
        }
        finish_block(blocks_[b], std::move(units));
    });
}

CellBounds CellBounds::of_function(const IndexBox& box, Bounds background, const Function& function) {
    CellBounds out(background);
    if (box.empty()) {
        out.finish();
        return out;
    }
    std::size_t cells = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        constexpr int kFarthest = 1 << 24;
        if (box.min[a] < -kFarthest || box.max[a] >= kFarthest)
            throw std::length_error("bounds are asked for beyond 2^24, where single precision ends");
        const int i = static_cast<int>(a);
        out.support_min_[i] = static_cast<float>(box.min[a]);
        out.support_max_[i] = static_cast<float>(box.max[a] + 1);
        const auto n = static_cast<std::size_t>((box.max[a] >> 3) - (box.min[a] >> 3) + 1);
        if (n > kMaxFunctionCells / cells)
            throw std::length_error("bounds are asked for more than 2^24 cells: use larger ones");
        cells *= n;
    }
    out.make_table(box.min, box.max);
    const auto bounds_at = [&](const std::array<int, 3>& corner) {
        Vec3f lo, hi;
        for (int a = 0; a < 3; ++a) {
            lo[a] = static_cast<float>(corner[static_cast<std::size_t>(a)]);
            hi[a] = lo[a] + kCellSize;
        }
        Bounds b = function(lo, hi);
        b.max = b.max < kInfinity ? b.max : kInfinity;  // also for NaN
        b.min = b.min > -kInfinity ? b.min : -kInfinity;
        return b;
    };
    parallel_for(std::size_t{0}, out.blocks_.size(), [&](std::size_t b) {
        const std::array<int, 3> corner = out.corner_of(b);
        auto units = std::make_unique<Bounds[]>(kUnits);
        parallel_for(std::size_t{0}, std::size_t{256}, [&](std::size_t row) {
            for (std::size_t i = 16 * row; i < 16 * row + 16; ++i) {
                const std::array<int, 3> cell = cell_of_unit(i);
                std::array<int, 3> first;
                bool in_table = true;
                for (std::size_t a = 0; a < 3; ++a) {
                    first[a] = corner[a] + 8 * cell[a];
                    in_table &= (first[a] - out.origin_[a]) >> 3 < out.cells_[a];
                }
                units[i] = in_table ? bounds_at(first) : background;
            }
        });
        finish_block(out.blocks_[b], std::move(units));
    });
    out.finish();
    return out;
}

void CellBounds::make_table(const std::array<int, 3>& first, const std::array<int, 3>& last) {
    std::size_t blocks = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        origin_[a] = first[a] & -kCellSize;
        cells_[a] = ((last[a] - origin_[a]) >> 3) + 1;
        blocks_per_axis_[a] = (cells_[a] + kBlockCells - 1) / kBlockCells;
        blocks *= static_cast<std::size_t>(blocks_per_axis_[a]);
    }
    blocks_.resize(blocks);
}

std::array<int, 3> CellBounds::corner_of(std::size_t block) const {
    const auto ny = static_cast<std::size_t>(blocks_per_axis_[1]),
               nz = static_cast<std::size_t>(blocks_per_axis_[2]);
    const std::array<std::size_t, 3> position{block / nz / ny, block / nz % ny, block % nz};
    std::array<int, 3> corner{};
    for (std::size_t a = 0; a < 3; ++a)
        corner[a] = origin_[a] + static_cast<int>(position[a]) * kBlockSize;
    return corner;
}

/// Fills the levels above the cells; a block that is uniform keeps none.
void CellBounds::finish_block(Block& block, std::unique_ptr<Bounds[]> units) {
    bool uniform = true;
    for (std::size_t i = 1; i < 4096 && uniform; ++i)
        uniform = units[i] == units[0];
    block.bounds = {};
    if (uniform) {
        block.bounds = units[0];
        return;
    }
    for (std::size_t level = 1; level < 4; ++level) {
        const std::size_t shift = 4 - level, n = std::size_t{1} << shift;
        const Bounds* below = &units[kFirstUnit[level - 1]];
        Bounds* out = &units[kFirstUnit[level]];
        for (std::size_t x = 0; x < n; ++x) {
            for (std::size_t y = 0; y < n; ++y) {
                for (std::size_t z = 0; z < n; ++z, ++out) {
                    *out = {};
                    for (std::size_t c = 0; c < 8; ++c)
                        out->include(below[(2 * x + (c >> 2)) * 4 * n * n + (2 * y + (c >> 1 & 1)) * 2 * n +
                                           2 * z + (c & 1)]);
                }
            }
        }
    }
    for (std::size_t i = kFirstUnit[3]; i < kUnits; ++i)
        block.bounds.include(units[i]);
    block.units = std::move(units);
}

/// The levels above the blocks, and the extremes of all.
void CellBounds::finish() {
    for (const Block& block : blocks_)
        global_.include(block.bounds);
    std::array<int, 3> size = blocks_per_axis_;
    for (int level = 5; size[0] > 1 || size[1] > 1 || size[2] > 1; ++level) {
        const std::array<int, 3> below = size;
        for (int& n : size)
            n = (n + 1) / 2;
        CoarseLevel coarse{size, {}};
        for (int x = 0; x < size[0]; ++x) {
            for (int y = 0; y < size[1]; ++y) {
                for (int z = 0; z < size[2]; ++z) {
                    Bounds bounds;
                    for (int c = 0; c < 8; ++c) {
                        const int cx = 2 * x + (c >> 2), cy = 2 * y + (c >> 1 & 1), cz = 2 * z + (c & 1);
                        if (cx < below[0] && cy < below[1] && cz < below[2])
                            bounds.include(at(level - 1, cx, cy, cz));
                    }
                    coarse.units.push_back(bounds);
                }
            }
        }
        coarse_.push_back(std::move(coarse));
    }
}

std::size_t CellBounds::bytes() const {
    std::size_t bytes = sizeof(*this) + blocks_.size() * sizeof(Block);
    for (const Block& block : blocks_)
        bytes += block.units ? kUnits * sizeof(Bounds) : 0;
    for (const CoarseLevel& level : coarse_)
        bytes += level.units.size() * sizeof(Bounds);
    return bytes;
}

Bounds CellBounds::range(Vec3f lo, Vec3f hi) const {
    if (blocks_.empty())
        return background_;
    Bounds bounds;
    std::array<int, 3> first, last;
    bool inside = true;
    for (std::size_t a = 0; a < 3; ++a) {
        const int i = static_cast<int>(a);
        if (!(lo[i] <= hi[i]))
            return global_;
        if (lo[i] >= support_max_[i] || hi[i] < support_min_[i])
            return background_;
        inside &= lo[i] >= support_min_[i] && hi[i] < support_max_[i];
        first[a] = std::clamp((floor_to_int(lo[i]) - origin_[a]) >> 3, 0, cells_[a] - 1);
        last[a] = std::clamp((floor_to_int(hi[i]) - origin_[a]) >> 3, 0, cells_[a] - 1);
    }
    if (!inside)
        bounds = background_;
    int level = 0;
    for (std::size_t a = 0; a < 3; ++a) {
        while ((last[a] >> level) - (first[a] >> level) > 2)
            ++level;
    }
    for (int x = first[0] >> level; x <= last[0] >> level; ++x) {
        for (int y = first[1] >> level; y <= last[1] >> level; ++y) {
            for (int z = first[2] >> level; z <= last[2] >> level; ++z)
                bounds.include(at(level, x, y, z));
        }
    }
    return bounds;
}

}  // namespace nephele
