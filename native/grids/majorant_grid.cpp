// SPDX-License-Identifier: GPL-3.0-or-later
// Building of majorant grids.
//
// What merges: a uniformly random line meets a cube of edge s and volume s^3 in proportion to its surface,
// and stays inside for 2 s / 3 on average. Summed over all lines, a cube with majorant M therefore costs
//     s^3 * M * sigma_scale * kCandidateCost   (candidates: lookups, random numbers)
//     + 1.5 s^2 * kStepCost                    (steps of the walk)
// and eight sub-cubes become one where that costs no more than the best of the eight. With minorants, M is
// the majorant less the minorant, for what lies below a minorant needs no lookup.
#include "grids/majorant_grid.h"

#include <algorithm>

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

namespace nephele {

namespace {

// In units of one candidate. bench/grid_lookup.cpp: a step takes 30 to 40 ns, a candidate 45 to 140 ns; the
// total is flat within 10 % for step costs from 0.3 to 1.2.
constexpr float kCandidateCost = 1.0f, kStepCost = 0.5f;

// Extremes of a brick's voxels, {max, min}, over 8 subsets: where a bit of the index is set (4: x, 2: y, 1:
// z), only the brick's first layer along that axis counts. The cell below such a brick sees just that layer.
using Extremes = std::array<Vec2f, 8>;

void include(Vec2f& e, Vec2f other) {
    e = {std::max(e.x, other.x), std::min(e.y, other.y)};
}

Extremes extremes_of(const float* voxels) {
    Extremes out;
    out.fill({-kInfinity, kInfinity});
    for (int x = 0; x < 8; ++x) {
        Vec2f slab[4];  // by the bits of y and z
        std::fill(slab, slab + 4, Vec2f{-kInfinity, kInfinity});
        for (int y = 0; y < 8; ++y) {
            const float* row = voxels + x * 64 + y * 8;
            const Vec2f first{row[0], row[0]};
            Vec2f all = first;
            for (int z = 1; z < 8; ++z)
                include(all, {row[z], row[z]});
            include(slab[0], all);
            include(slab[1], first);
            if (y == 0) {
                slab[2] = all;
                slab[3] = first;
            }
        }
        for (std::size_t s = 0; s < 4; ++s) {
            include(out[s], slab[s]);
            if (x == 0)
                out[4 + s] = slab[s];
        }
    }
    return out;
}

/// A block's cells at one level of merging: level 0 has 16^3 of them, level 4 one.
struct Level {
    explicit Level(int level) : n(16 >> level), bounds(count()), costs(count()), merged(count()) {}
    std::size_t count() const { return static_cast<std::size_t>(n * n * n); }
    std::size_t index(int x, int y, int z) const { return static_cast<std::size_t>((x * n + y) * n + z); }

    int n;
    std::vector<Vec2f> bounds;  // {majorant, minorant}
    std::vector<float> costs;   // of the best way to divide the cube
    std::vector<char> merged;   // that way is not to divide it
};

/// Decides level by level, from the cells upwards, which cubes stay undivided.
void merge_upwards(std::array<Level, 5>& levels, float sigma_scale, bool with_minorants) {
    for (std::size_t l = 0; l < 5; ++l) {
        Level& level = levels[l];
        const float s = static_cast<float>(8 << l);
        for (int x = 0; x < level.n; ++x) {
            for (int y = 0; y < level.n; ++y) {
                for (int z = 0; z < level.n; ++z) {
                    const std::size_t i = level.index(x, y, z);
                    float divided = kInfinity;
                    if (l > 0) {
                        const Level& below = levels[l - 1];
                        divided = 0;
                        level.bounds[i] = {-kInfinity, kInfinity};
                        for (int c = 0; c < 8; ++c) {
                            const std::size_t j =
                                below.index(2 * x + (c >> 2), 2 * y + (c >> 1 & 1), 2 * z + (c & 1));
                            include(level.bounds[i], below.bounds[j]);
                            divided += below.costs[j];
                        }
                    }
                    const Vec2f bound = level.bounds[i];
                    const float rate = (with_minorants ? bound.x - bound.y : bound.x) * sigma_scale;
                    const float whole = s * s * s * rate * kCandidateCost + 1.5f * s * s * kStepCost;
                    level.merged[i] = whole <= divided;
                    level.costs[i] = std::min(whole, divided);
                }
            }
        }
    }
}

}  // namespace

std::uint32_t MajorantGrid::pack(float majorant, int level) {
    const auto bits = std::bit_cast<std::uint32_t>(std::max(majorant, 0.0f));
    return ((bits + 7u) & ~7u) | static_cast<std::uint32_t>(level);
}

std::size_t MajorantGrid::bytes() const {
    return sizeof(*this) + blocks_.size() * sizeof(Block) + packed_.size() * 4 + minorants_.size() * 4;
}

MajorantGrid::MajorantGrid(const BrickGrid& grid, float sigma_scale, bool with_minorants)
    : background_(grid.background()),
      global_majorant_(grid.background()),
      global_minorant_(grid.background()) {
    if (grid.bounds().empty())
        return;
    std::vector<Extremes> extremes(grid.brick_count());
    tbb::parallel_for(tbb::blocked_range<std::size_t>(0, extremes.size(), 64), [&](const auto& range) {
        float voxels[BrickGrid::kBrickVoxels];
        for (std::size_t b = range.begin(); b != range.end(); ++b) {
            grid.read_brick(static_cast<std::int32_t>(b), voxels);
            extremes[b] = extremes_of(voxels);
        }
    });
    make_table(grid, with_minorants);
    tbb::parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
        if (blocks_[b].node < 0)
            return;
        const std::size_t nz = blocks_per_axis_[2], ny = blocks_per_axis_[1];
        const std::array<std::size_t, 3> position{b / nz / ny, b / nz % ny, b % nz};
        std::array<int, 3> first{};
        for (std::size_t a = 0; a < 3; ++a)
            first[a] = origin_[a] + static_cast<int>(position[a]) * 128;
        build_block(grid, extremes, sigma_scale, first, blocks_[b]);
    });
    for (const Block& block : blocks_) {
        global_majorant_ = std::max(global_majorant_, unpack(block.packed, 0).majorant);
        global_minorant_ = std::min(global_minorant_, block.minorant);
    }
    drop_uniform_nodes();
    if (!with_minorants) {
        global_minorant_ = 0;
        for (Block& block : blocks_)
            block.minorant = 0;
    }
}

/// Lays out the blocks, and reserves a node for each one that is not plainly constant.
void MajorantGrid::make_table(const BrickGrid& grid, bool with_minorants) {
    const IndexBox& bounds = grid.bounds();
    for (std::size_t a = 0; a < 3; ++a) {
        const int first_voxel =
            bounds.min[a] - 1;  // the first whose interpolation sees more than the background
        origin_[a] = first_voxel & -8;
        cells_[a] = ((bounds.max[a] - origin_[a]) >> 3) + 1;
        blocks_per_axis_[a] = static_cast<std::uint32_t>((cells_[a] + 15) / 16);
        support_min_[static_cast<int>(a)] = static_cast<float>(first_voxel);
        support_max_[static_cast<int>(a)] = static_cast<float>(bounds.max[a] + 1);
    }
    const auto& n = blocks_per_axis_;
    blocks_.resize(std::size_t{n[0]} * n[1] * n[2]);
    std::int32_t nodes = 0;
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
        const int x = origin_[0] + 128 * static_cast<int>(b / n[2] / n[1]);
        const int y = origin_[1] + 128 * static_cast<int>(b / n[2] % n[1]);
        const int z = origin_[2] + 128 * static_cast<int>(b % n[2]);
        float value = 0, other = 0;
        bool constant = grid.constant_block_at(x, y, z, value);
        // The 129^3 voxels that this block sees lie in up to 8 blocks of the grid.
        for (int c = 1; c < 8 && constant; ++c) {
            constant = grid.constant_block_at(x + (c & 4 ? 128 : 0), y + (c & 2 ? 128 : 0),
                                              z + (c & 1 ? 128 : 0), other) &&
                       other == value;
        }
        blocks_[b] = {constant ? -1 : nodes++, pack(value, 4), value};
    }
    packed_.resize(static_cast<std::size_t>(nodes) * kCellsPerBlock);
    if (with_minorants)
        minorants_.resize(packed_.size());
}

void MajorantGrid::build_block(const BrickGrid& grid, const std::vector<Extremes>& extremes,
                               float sigma_scale, std::array<int, 3> first_voxel, Block& block) {
    std::array<Level, 5> levels{Level(0), Level(1), Level(2), Level(3), Level(4)};
    // 1. Extremes over the 9^3 voxels of each cell: its own brick's, and the facing layers of the next
    // bricks.
    for (int i = 0; i < kCellsPerBlock; ++i) {
        const std::array<int, 3> cell{i >> 8, i >> 4 & 15, i & 15};
        Vec2f bound{-kInfinity, kInfinity};
        for (int s = 0; s < 8; ++s) {
            const BrickGrid::Cell c = grid.cell_at(first_voxel[0] + 8 * (cell[0] + (s >> 2)),
                                                   first_voxel[1] + 8 * (cell[1] + (s >> 1 & 1)),
                                                   first_voxel[2] + 8 * (cell[2] + (s & 1)));
            include(bound, c.brick < 0
                               ? Vec2f{c.constant, c.constant}
                               : extremes[static_cast<std::size_t>(c.brick)][static_cast<std::size_t>(s)]);
        }
        if (bound.x > bound.y) {  // room for the rounding of interpolation, a few units in the last place
            bound.x += bound.x * 0x1p-21f;
            bound.y -= bound.y * 0x1p-21f;
        }
        levels[0].bounds[static_cast<std::size_t>(i)] = bound;
    }
    // 2. Merge, then give each cell the bounds of the largest undivided cube around it.
    merge_upwards(levels, sigma_scale, !minorants_.empty());
    const std::size_t base = static_cast<std::size_t>(block.node) * kCellsPerBlock;
    for (int i = 0; i < kCellsPerBlock; ++i) {
        std::size_t l = 4, j = 0;
        for (;; --l) {
            j = levels[l].index(i >> (8 + l), (i >> 4 & 15) >> l, (i & 15) >> l);
            if (levels[l].merged[j])
                break;
        }
        packed_[base + static_cast<std::size_t>(i)] = pack(levels[l].bounds[j].x, static_cast<int>(l));
        if (!minorants_.empty())
            minorants_[base + static_cast<std::size_t>(i)] = levels[l].bounds[j].y;
    }
    block.packed = pack(levels[4].bounds[0].x, 4);
    block.minorant = levels[4].bounds[0].y;
}

/// Blocks that became one cube need no node.
void MajorantGrid::drop_uniform_nodes() {
    std::size_t kept = 0;
    for (Block& block : blocks_) {  // nodes are numbered in the order of the blocks
        if (block.node < 0)
            continue;
        const std::size_t from = static_cast<std::size_t>(block.node) * kCellsPerBlock;
        if ((packed_[from] & 7u) == 4u) {
            block.node = -1;
            continue;
        }
        const auto copy_down = [&](auto& values) {
            const auto source = values.begin() + static_cast<std::ptrdiff_t>(from);
            std::copy(source, source + kCellsPerBlock,
                      values.begin() + static_cast<std::ptrdiff_t>(kept * kCellsPerBlock));
        };
        copy_down(packed_);
        if (!minorants_.empty())
            copy_down(minorants_);
        block.node = static_cast<std::int32_t>(kept++);
    }
    packed_.resize(kept * kCellsPerBlock);
    packed_.shrink_to_fit();
    if (!minorants_.empty())
        minorants_.resize(packed_.size());
    minorants_.shrink_to_fit();
}

}  // namespace nephele
