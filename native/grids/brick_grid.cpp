// SPDX-License-Identifier: GPL-3.0-or-later
// Building of BrickGrids. Nothing here is on the hot path.
#include "grids/brick_grid.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <new>
#include <stdexcept>
#include <string>

#include <Imath/half.h>

namespace nephele {

namespace {

constexpr int kFarthestVoxel = (1 << 24) - BrickGrid::kBlockSize;  // floats still tell voxels apart
/// Memory whose pages count only once written to. (Huge pages were tried: lookups gained 2 %, within the
/// noise.)
void* reserve(std::size_t bytes) {
    constexpr std::size_t kCacheLine = 64;
    void* p = std::aligned_alloc(kCacheLine, (bytes + kCacheLine - 1) / kCacheLine * kCacheLine);
    if (!p)
        throw std::bad_alloc();
    return p;
}

int aligned_down(int v, int step) {
    return v & -step;
}

}  // namespace

// --- BrickGrid
// --------------------------------------------------------------------------------------------------

std::size_t BrickGrid::bytes() const {
    const std::size_t voxel_bytes = voxel_type() == VoxelType::half_float ? 2 : 4;
    return sizeof(*this) + (blocks_.size() + cells_.size()) * sizeof(std::int32_t) +
           constants_.size() * sizeof(float) + brick_count_ * kBrickVoxels * voxel_bytes;
}

BrickGrid::Cell BrickGrid::cell_at(int i, int j, int k) const {
    const std::uint32_t x = static_cast<std::uint32_t>(i) - origin_[0],
                        y = static_cast<std::uint32_t>(j) - origin_[1],
                        z = static_cast<std::uint32_t>(k) - origin_[2];
    if (!inside(x, y, z))
        return {-1, background_};
    const std::int32_t e = entry(x, y, z);
    return e < 0 ? Cell{-1, constants_[static_cast<std::size_t>(~e)]} : Cell{e, 0};
}

bool BrickGrid::constant_block_at(int i, int j, int k, float& value) const {
    const std::uint32_t x = static_cast<std::uint32_t>(i) - origin_[0],
                        y = static_cast<std::uint32_t>(j) - origin_[1],
                        z = static_cast<std::uint32_t>(k) - origin_[2];
    value = background_;
    if (!inside(x, y, z))
        return true;
    const std::int32_t block = block_entry(x, y, z);
    if (block < 0)
        value = constants_[static_cast<std::size_t>(~block)];
    return block < 0;
}

void BrickGrid::read_brick(std::int32_t brick, float* out) const {
    const std::size_t first = static_cast<std::size_t>(brick) * kBrickVoxels;
    if (floats_) {
        std::memcpy(out, floats_ + first, kBrickVoxels * sizeof(float));
        return;
    }
    for (std::size_t v = 0; v < kBrickVoxels; ++v)
        out[v] = half_to_float(halves_[first + v]);
}

float BrickGrid::tricubic(Vec3f p) const {
    const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
    const std::uint32_t x = static_cast<std::uint32_t>(i - 1) - origin_[0];
    const std::uint32_t y = static_cast<std::uint32_t>(j - 1) - origin_[1];
    const std::uint32_t z = static_cast<std::uint32_t>(k - 1) - origin_[2];
    std::size_t first = 0;
    const bool one_cell = inside(x, y, z) && (x & 7) < 5 && (y & 7) < 5 && (z & 7) < 5;
    if (one_cell) {
        const std::int32_t e = entry(x, y, z);
        if (e < 0)
            return constants_[static_cast<std::size_t>(~e)];
        first = static_cast<std::size_t>(e) * kBrickVoxels + voxel_in_brick(x, y, z);
    }
    const auto spans = [](float f) { return cubic_spans(std::max(0.0f, std::min(1.0f, f))); };
    const CubicSpans sx = spans(p.x - static_cast<float>(i)), sy = spans(p.y - static_cast<float>(j)),
                     sz = spans(p.z - static_cast<float>(k));
    const auto along = [](const CubicSpans& s, const float* v) {
        return lerp(lerp(v[0], v[1], s.low), lerp(v[2], v[3], s.high), s.upper);
    };
    float planes[4];
    for (std::uint32_t a = 0; a < 4; ++a) {
        float rows[4];
        for (std::uint32_t b = 0; b < 4; ++b) {
            float v[4];
            for (std::uint32_t c = 0; c < 4; ++c)
                v[c] = one_cell ? voxel(first + (a << 6 | b << 3 | c)) : lookup_table(x + a, y + b, z + c);
            rows[b] = along(sz, v);
        }
        planes[a] = along(sy, rows);
    }
    return along(sx, planes);
}

// --- BrickGridBuilder
// -------------------------------------------------------------------------------------------

BrickGridBuilder::BrickGridBuilder(const IndexBox& extent, float background, VoxelType type,
                                   std::size_t brick_capacity)
    : grid_(new BrickGrid), capacity_(brick_capacity) {
    BrickGrid& g = *grid_;
    g.background_ = background;
    g.constants_.clear();
    if (brick_capacity > INT32_MAX)
        throw std::length_error("more than 2^31 bricks of 8^3 voxels");

    std::size_t block_count = 1;
    for (std::size_t a = 0; a < 3; ++a) {
        if (extent.empty()) {
            block_count = 0;
            break;
        }
        if (extent.min[a] < -kFarthestVoxel || extent.max[a] > kFarthestVoxel) {
            throw std::length_error(
                "lies more than 2^24 voxels from the origin of index space, beyond single precision: move "
                "it, or use "
                "larger voxels");
        }
        const std::int64_t first = aligned_down(extent.min[a], BrickGrid::kBlockSize);
        const std::int64_t blocks = (std::int64_t{extent.max[a]} - first) / BrickGrid::kBlockSize + 1;
        g.origin_[a] = static_cast<std::uint32_t>(first);
        g.blocks_per_axis_[a] = static_cast<std::uint32_t>(blocks);
        g.size_[a] = g.blocks_per_axis_[a] * BrickGrid::kBlockSize;
        if (static_cast<std::size_t>(blocks) > BrickGrid::kMaxBlocks / block_count) {
            throw std::length_error(
                "spans more than 2^24 blocks of 128^3 voxels: crop it, remove stray voxels far from the "
                "rest, or use "
                "larger voxels");
        }
        block_count *= static_cast<std::size_t>(blocks);
    }
    if (extent.empty())
        g.size_ = {};
    g.blocks_.assign(block_count, constant_entry(background));

    const std::size_t voxel_bytes = type == VoxelType::half_float ? 2 : 4;
    // At least one brick, so that the pointers tell the type even of grids without any.
    const std::size_t bricks = std::max<std::size_t>(brick_capacity, 1);
    g.storage_.reset(reserve(bricks * BrickGrid::kBrickVoxels * voxel_bytes));
    if (type == VoxelType::half_float) {
        g.halves_ = static_cast<const std::uint16_t*>(g.storage_.get());
    } else {
        g.floats_ = static_cast<const float*>(g.storage_.get());
    }
}

std::int32_t BrickGridBuilder::constant_entry(float value) {
    const auto [it, is_new] = constant_numbers_.try_emplace(
        std::bit_cast<std::uint32_t>(value), ~static_cast<std::int32_t>(grid_->constants_.size()));
    if (is_new)
        grid_->constants_.push_back(value);
    return it->second;
}

std::array<std::uint32_t, 3> BrickGridBuilder::table_coordinates(std::array<int, 3> corner) const {
    return {static_cast<std::uint32_t>(corner[0]) - grid_->origin_[0],
            static_cast<std::uint32_t>(corner[1]) - grid_->origin_[1],
            static_cast<std::uint32_t>(corner[2]) - grid_->origin_[2]};
}

std::int32_t& BrickGridBuilder::block_of(std::array<std::uint32_t, 3> p) {
    const auto& n = grid_->blocks_per_axis_;
    return grid_->blocks_[(std::size_t{p[0] >> 7} * n[1] + (p[1] >> 7)) * n[2] + (p[2] >> 7)];
}

std::int32_t& BrickGridBuilder::cell_of(std::array<std::uint32_t, 3> p) {
    if (!grid_->inside(p[0], p[1], p[2]))
        throw std::out_of_range("BrickGridBuilder: outside the extent");
    std::int32_t& block = block_of(p);
    auto& cells = grid_->cells_;
    if (block < 0) {
        const auto number = static_cast<std::int32_t>(cells.size() / BrickGrid::kCellsPerBlock);
        cells.insert(cells.end(), BrickGrid::kCellsPerBlock, block);
        block = number;
    }
    return cells[static_cast<std::size_t>(block) * BrickGrid::kCellsPerBlock +
                 ((p[0] << 5 & 0xf00) | (p[1] << 1 & 0xf0) | (p[2] >> 3 & 0xf))];
}

void BrickGridBuilder::set_tile(std::array<int, 3> corner, std::int64_t size, float value) {
    const BrickGrid& g = *grid_;
    const std::int32_t entry = constant_entry(value);
    std::array<std::int64_t, 3> first, last;  // in table coordinates, clipped
    for (std::size_t a = 0; a < 3; ++a) {
        const std::int64_t start = std::int64_t{corner[a]} - static_cast<std::int32_t>(g.origin_[a]);
        first[a] = std::max<std::int64_t>(start, 0);
        last[a] = std::min<std::int64_t>(start + size, g.size_[a]);
    }
    const std::int64_t step =
        size % BrickGrid::kBlockSize == 0 ? BrickGrid::kBlockSize : BrickGrid::kBrickSize;
    for (std::int64_t x = first[0]; x < last[0]; x += step) {
        for (std::int64_t y = first[1]; y < last[1]; y += step) {
            for (std::int64_t z = first[2]; z < last[2]; z += step) {
                const std::array<std::uint32_t, 3> p{static_cast<std::uint32_t>(x),
                                                     static_cast<std::uint32_t>(y),
                                                     static_cast<std::uint32_t>(z)};
                (step == BrickGrid::kBlockSize ? block_of(p) : cell_of(p)) = entry;
            }
        }
    }
}

void BrickGridBuilder::set_brick(std::array<int, 3> corner, const float* values) {
    BrickGrid& g = *grid_;
    std::int32_t& cell = cell_of(table_coordinates(corner));
    if (std::all_of(values, values + BrickGrid::kBrickVoxels, [&](float v) { return v == values[0]; })) {
        cell = constant_entry(values[0]);
        return;
    }
    if (g.brick_count_ == capacity_)
        throw std::length_error("BrickGridBuilder: more bricks than announced");
    const std::size_t first = g.brick_count_ * BrickGrid::kBrickVoxels;
    if (g.halves_) {
        auto* out = static_cast<std::uint16_t*>(g.storage_.get()) + first;
        for (std::size_t v = 0; v < BrickGrid::kBrickVoxels; ++v)
            out[v] = imath_float_to_half(values[v]);
    } else {
        std::memcpy(static_cast<float*>(g.storage_.get()) + first, values,
                    BrickGrid::kBrickVoxels * sizeof(float));
    }
    cell = static_cast<std::int32_t>(g.brick_count_++);
}

/// Blocks whose cells came out equal and constant become constants; the others close the ranks.
void BrickGridBuilder::collapse_blocks() {
    BrickGrid& g = *grid_;
    std::size_t kept = 0;
    std::vector<std::int32_t> cells;
    cells.swap(g.cells_);
    const auto block_cells = [&](std::size_t n) {
        return cells.begin() + static_cast<std::ptrdiff_t>(n * 4096);
    };
    std::vector<std::int32_t> renumbered(cells.size() / BrickGrid::kCellsPerBlock);
    for (std::size_t n = 0; n < renumbered.size(); ++n) {
        const auto begin = block_cells(n), end = block_cells(n + 1);
        const std::int32_t first = *begin;
        if (first < 0 && std::all_of(begin, end, [&](std::int32_t e) { return e == first; })) {
            renumbered[n] = first;
        } else {
            std::copy(begin, end, block_cells(kept));
            renumbered[n] = static_cast<std::int32_t>(kept++);
        }
    }
    g.cells_.assign(cells.begin(), block_cells(kept));
    for (std::int32_t& block : g.blocks_) {
        if (block >= 0)
            block = renumbered[static_cast<std::size_t>(block)];
    }
}

void BrickGridBuilder::find_bounds() {
    BrickGrid& g = *grid_;
    float values[BrickGrid::kBrickVoxels];
    const auto widen_by_brick = [&](std::array<int, 3> corner, std::int32_t brick) {
        const IndexBox& b = g.bounds_;
        bool known = true;
        for (std::size_t a = 0; a < 3; ++a)
            known &= b.min[a] <= corner[a] && corner[a] + 7 <= b.max[a];
        if (known)
            return;
        g.read_brick(brick, values);
        for (int v = 0; v < BrickGrid::kBrickVoxels; ++v) {
            if (values[v] == g.background_)
                continue;
            const std::array<int, 3> p{corner[0] + (v >> 6), corner[1] + (v >> 3 & 7), corner[2] + (v & 7)};
            g.bounds_.include(p);
        }
    };
    const auto widen_by_constant = [&](std::array<int, 3> corner, int size, std::int32_t entry) {
        if (g.constants_[static_cast<std::size_t>(~entry)] == g.background_)
            return;
        g.bounds_.include(corner);
        g.bounds_.include({corner[0] + size - 1, corner[1] + size - 1, corner[2] + size - 1});
    };
    const auto& n = g.blocks_per_axis_;
    for (std::size_t b = 0; b < g.blocks_.size(); ++b) {
        const std::array<std::size_t, 3> position{b / n[2] / n[1], b / n[2] % n[1], b % n[2]};
        std::array<int, 3> corner{};
        for (std::size_t a = 0; a < 3; ++a) {
            corner[a] = static_cast<int>(g.origin_[a] + static_cast<std::uint32_t>(position[a]) * 128u);
        }
        if (g.blocks_[b] < 0) {
            widen_by_constant(corner, BrickGrid::kBlockSize, g.blocks_[b]);
            continue;
        }
        for (int c = 0; c < BrickGrid::kCellsPerBlock; ++c) {
            const std::int32_t e =
                g.cells_[static_cast<std::size_t>(g.blocks_[b]) * 4096 + static_cast<std::size_t>(c)];
            const std::array<int, 3> cell_corner{corner[0] + 8 * (c >> 8), corner[1] + 8 * (c >> 4 & 15),
                                                 corner[2] + 8 * (c & 15)};
            e < 0 ? widen_by_constant(cell_corner, BrickGrid::kBrickSize, e) : widen_by_brick(cell_corner, e);
        }
    }
}

std::shared_ptr<const BrickGrid> BrickGridBuilder::finish(std::int64_t active_voxels,
                                                          const IndexBox& active_bounds) {
    collapse_blocks();
    find_bounds();
    grid_->active_voxels_ = active_voxels;
    grid_->active_bounds_ = active_bounds;
    return std::shared_ptr<const BrickGrid>(std::move(grid_));
}

// --- Dense source
// -----------------------------------------------------------------------------------------------

std::shared_ptr<const BrickGrid> brick_grid_of_dense(std::array<int, 3> corner, std::array<int, 3> size,
                                                     const float* values, float background, VoxelType type) {
    IndexBox extent;
    std::size_t bricks = 1;
    std::array<int, 3> first{};
    for (std::size_t a = 0; a < 3; ++a) {
        extent.min[a] = corner[a];
        extent.max[a] = corner[a] + size[a] - 1;
        first[a] = aligned_down(corner[a], BrickGrid::kBrickSize);
        bricks *=
            static_cast<std::size_t>(std::max(0, (extent.max[a] - first[a]) / BrickGrid::kBrickSize + 1));
    }
    if (extent.empty())
        return BrickGridBuilder({}, background, type, 0).finish(0, {});
    BrickGridBuilder builder(extent, background, type, bricks);
    float brick[BrickGrid::kBrickVoxels];
    for (int x = first[0]; x <= extent.max[0]; x += 8) {
        for (int y = first[1]; y <= extent.max[1]; y += 8) {
            for (int z = first[2]; z <= extent.max[2]; z += 8) {
                for (int v = 0; v < BrickGrid::kBrickVoxels; ++v) {
                    const int i = x + (v >> 6) - corner[0], j = y + (v >> 3 & 7) - corner[1],
                              k = z + (v & 7) - corner[2];
                    const bool in = i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
                    const std::size_t row =
                        static_cast<std::size_t>(in ? i : 0) * static_cast<std::size_t>(size[1]) +
                        static_cast<std::size_t>(in ? j : 0);
                    brick[v] =
                        in ? values[row * static_cast<std::size_t>(size[2]) + static_cast<std::size_t>(k)]
                           : background;
                }
                builder.set_brick({x, y, z}, brick);
            }
        }
    }
    return builder.finish(std::int64_t{size[0]} * size[1] * size[2], extent);
}

}  // namespace nephele
