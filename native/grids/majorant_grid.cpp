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

#include "base/parallel.h"

namespace nephele {

namespace {

// In units of one candidate. bench/grid_lookup.cpp: a step takes 30 to 40 ns, a candidate 45 to 140 ns; the
// total is flat within 10 % for step costs from 0.3 to 1.2.
constexpr float kCandidateCost = 1.0f, kStepCost = 0.5f;

/// A block's cells at one level of merging: level 0 has 16^3 of them, level 4 one.
struct Level {
    explicit Level(int level) : n(16 >> level), bounds(count()), costs(count()), merged(count()) {}
    std::size_t count() const { return static_cast<std::size_t>(n * n * n); }
    std::size_t index(int x, int y, int z) const { return static_cast<std::size_t>((x * n + y) * n + z); }

    int n;
    std::vector<Bounds> bounds;
    std::vector<float> costs;  // of the best way to divide the cube
    std::vector<char> merged;  // that way is not to divide it
};

/// Decides level by level, from the cells upwards, which cubes stay undivided.
void merge_upwards(const CellBounds& bounds, const std::array<int, 3>& position, std::array<Level, 5>& levels,
                   float sigma_scale, bool with_minorants) {
    for (int l = 0; l < 5; ++l) {
        Level& level = levels[static_cast<std::size_t>(l)];
        const int n = level.n;
        const float s = static_cast<float>(8 << l);
        for (int x = 0; x < n; ++x) {
            for (int y = 0; y < n; ++y) {
                for (int z = 0; z < n; ++z) {
                    const std::size_t i = level.index(x, y, z);
                    float divided = kInfinity;
                    if (l > 0) {
                        const Level& below = levels[static_cast<std::size_t>(l - 1)];
                        divided = 0;
                        for (int c = 0; c < 8; ++c)
                            divided += below.costs[below.index(2 * x + (c >> 2), 2 * y + (c >> 1 & 1),
                                                               2 * z + (c & 1))];
                    }
                    const Bounds& bound =
                        bounds.at(l, position[0] * n + x, position[1] * n + y, position[2] * n + z);
                    const float rate = (with_minorants ? bound.max - bound.min : bound.max) * sigma_scale;
                    const float whole = s * s * s * rate * kCandidateCost + 1.5f * s * s * kStepCost;
                    level.bounds[i] = bound;
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

MajorantGrid::MajorantGrid(const CellBounds& bounds, float sigma_scale, bool with_minorants)
    : origin_(bounds.origin()),
      cells_(bounds.cells()),
      support_min_(bounds.support_min()),
      support_max_(bounds.support_max()),
      background_(bounds.background()),
      global_majorant_(unpack(pack(bounds.global().max, 0), 0).majorant),
      global_minorant_(with_minorants ? bounds.global().min : 0) {
    const auto& n = bounds.blocks();
    std::vector<std::array<int, 3>> positions;
    std::int32_t nodes = 0;
    for (int x = 0; x < n[0]; ++x) {
        for (int y = 0; y < n[1]; ++y) {
            for (int z = 0; z < n[2]; ++z) {
                const Bounds& whole = bounds.at(4, x, y, z);
                positions.push_back({x, y, z});
                blocks_.push_back({bounds.is_uniform(x, y, z) ? -1 : nodes++, pack(whole.max, 4),
                                   with_minorants ? whole.min : 0});
            }
        }
    }
    for (std::size_t a = 0; a < 3; ++a)
        blocks_per_axis_[a] = static_cast<std::uint32_t>(n[a]);
    packed_.resize(static_cast<std::size_t>(nodes) * kCellsPerBlock);
    if (with_minorants)
        minorants_.resize(packed_.size());
    parallel_for(std::size_t{0}, blocks_.size(), [&](std::size_t b) {
        if (blocks_[b].node >= 0)
            build_block(bounds, sigma_scale, positions[b], blocks_[b]);
    });
    drop_uniform_nodes();
}

void MajorantGrid::build_block(const CellBounds& bounds, float sigma_scale,
                               const std::array<int, 3>& position, Block& block) {
    std::array<Level, 5> levels{Level(0), Level(1), Level(2), Level(3), Level(4)};
    merge_upwards(bounds, position, levels, sigma_scale, !minorants_.empty());
    // Each cell takes the bounds of the largest undivided cube around it.
    const std::size_t base = static_cast<std::size_t>(block.node) * kCellsPerBlock;
    for (int i = 0; i < kCellsPerBlock; ++i) {
        std::size_t l = 4, j = 0;
        for (;; --l) {
            j = levels[l].index(i >> (8 + l), (i >> 4 & 15) >> l, (i & 15) >> l);
            if (levels[l].merged[j])
                break;
        }
        packed_[base + static_cast<std::size_t>(i)] = pack(levels[l].bounds[j].max, static_cast<int>(l));
        if (!minorants_.empty())
            minorants_[base + static_cast<std::size_t>(i)] = levels[l].bounds[j].min;
    }
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
