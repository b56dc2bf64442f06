// SPDX-License-Identifier: GPL-3.0-or-later
// An immutable sparse scalar grid in index space, laid out for fast random lookups.
//
// Voxel (i, j, k) has its centre at the integer point (i, j, k). Two levels: a dense table over blocks of
// 128^3 voxels; a block is one constant, or 16^3 entries, each a constant or the number of a brick of 8^3
// voxels. Outside the table lies the background. Constants are never expanded to voxels.
//
//     blocks_[x >> 7, y >> 7, z >> 7]          < 0: constants_[~entry]
//       -> cells_[block, x >> 3, y >> 3, z >> 3]   < 0: constants_[~entry]
//         -> voxels[brick, x & 7, y & 7, z & 7]      half or float, z fastest
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <unordered_map>
#include <vector>

#ifdef __F16C__
#include <immintrin.h>
#endif

#include "grids/filter.h"
#include "math/vec.h"

namespace nephele {

/// Voxels min to max, both included.
struct IndexBox {
    std::array<int, 3> min{0, 0, 0}, max{-1, -1, -1};

    bool empty() const { return min[0] > max[0] || min[1] > max[1] || min[2] > max[2]; }
    bool operator==(const IndexBox&) const = default;
    void include(const std::array<int, 3>& voxel) {
        const bool was_empty = empty();
        for (std::size_t a = 0; a < 3; ++a) {
            min[a] = was_empty ? voxel[a] : std::min(min[a], voxel[a]);
            max[a] = was_empty ? voxel[a] : std::max(max[a], voxel[a]);
        }
    }
};

/// How bricks keep their voxels. `half_float` is lossless only for values that are halves already.
enum class VoxelType { half_float, single_float };

/// Value of an IEEE half. (Imath's own header puts the name `half` into the global namespace of all who
/// include it.)
inline float half_to_float(std::uint16_t bits) {
#ifdef __F16C__
    return _cvtsh_ss(bits);
#else
    // Widen exponent and mantissa in place, then correct the exponent's bias: exact for denormals, too.
    const float magnitude = std::bit_cast<float>((bits & 0x7fffu) << 13) * 0x1p112f;
    const std::uint32_t special = magnitude >= 65536.0f ? 0x7f800000u : 0;  // infinity and NaN
    return std::bit_cast<float>(std::bit_cast<std::uint32_t>(magnitude) | special | (bits & 0x8000u) << 16);
#endif
}

/// floor(x) as an integer; NaN and what lies beyond +-2^30 become +-2^30.
inline int floor_to_int(float x) {
    constexpr float kLimit = 0x1p30f;
    return static_cast<int>(std::floor(std::max(-kLimit, std::min(kLimit, x))));
}

class BrickGrid {
  public:
    static constexpr int kBrickSize = 8, kBrickVoxels = 512;
    static constexpr int kBlockSize = 128, kCellsPerBlock = 4096;
    static constexpr std::size_t kMaxBlocks = std::size_t{1} << 24;

    /// Value of voxel (i, j, k).
    float lookup(int i, int j, int k) const;
    /// Trilinear interpolation at a point of index space.
    float trilinear(Vec3f p_index) const;
    /// The voxel at a random corner of p's interpolation cell; its expectation over u in [0,1)^3 is
    /// `trilinear(p)`.
    float stochastic(Vec3f p_index, Vec3f u) const;
    /// The voxel nearest to a point; halfway between two, the upper one.
    float nearest(Vec3f p_index) const;
    /// Cubic B-spline through the 4^3 voxels around a point, see filter.h.
    float tricubic(Vec3f p_index) const;
    /// One of those voxels at random; its expectation over u in [0,1)^3 is `tricubic(p)`.
    float stochastic_tricubic(Vec3f p_index, Vec3f u) const;
    /// The filter's value at a point.
    float evaluate(Filter filter, Vec3f p_index) const;
    /// One voxel, whose expectation over u in [0,1)^3 is `evaluate(filter, p)`.
    float stochastic(Filter filter, Vec3f p_index, Vec3f u) const;

    float background() const { return background_; }
    VoxelType voxel_type() const { return halves_ ? VoxelType::half_float : VoxelType::single_float; }
    /// Smallest box that holds every voxel whose value differs from the background.
    const IndexBox& bounds() const { return bounds_; }
    /// Box of the source's active voxels. Where the background is not 0, this is what tells the volume's
    /// extent.
    const IndexBox& active_bounds() const { return active_bounds_; }
    /// Number of active voxels of the source, those of tiles included.
    std::int64_t active_voxels() const { return active_voxels_; }
    std::size_t brick_count() const { return brick_count_; }
    std::size_t bytes() const;

    /// The 8^3 voxels around (i, j, k): all equal to `constant`, or those of brick number `brick`.
    struct Cell {
        std::int32_t brick = -1;
        float constant = 0;
    };
    Cell cell_at(int i, int j, int k) const;
    /// The 512 voxels of a brick as floats, z fastest.
    void read_brick(std::int32_t brick, float* out) const;
    /// The common value of the 128^3 voxels around (i, j, k), if the table knows the block to be constant.
    bool constant_block_at(int i, int j, int k, float& value) const;

  private:
    friend class BrickGridBuilder;
    struct Free {
        void operator()(void* p) const { std::free(p); }
    };
    static constexpr std::int32_t kOutside = INT32_MIN;

    BrickGrid() = default;
    float voxel(std::size_t index) const { return halves_ ? half_to_float(halves_[index]) : floats_[index]; }
    std::int32_t block_entry(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        return blocks_[(std::size_t{x >> 7} * blocks_per_axis_[1] + (y >> 7)) * blocks_per_axis_[2] +
                       (z >> 7)];
    }
    /// Entry of the cell at table coordinates (x, y, z), which lie inside: a brick number, or ~(number of a
    /// constant).
    std::int32_t entry(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        const std::int32_t block = block_entry(x, y, z);
        if (block < 0)
            return block;
        return cells_[static_cast<std::size_t>(block) * kCellsPerBlock +
                      ((x << 5 & 0xf00) | (y << 1 & 0xf0) | (z >> 3 & 0xf))];
    }
    static std::uint32_t voxel_in_brick(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
        return (x & 7) << 6 | (y & 7) << 3 | (z & 7);
    }
    bool inside(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
        return x < size_[0] && y < size_[1] && z < size_[2];
    }
    float lookup_table(std::uint32_t x, std::uint32_t y, std::uint32_t z) const;

    std::array<std::uint32_t, 3> origin_{},
        size_{};  // of the table, in voxels; two's complement, multiples of 128
    std::array<std::uint32_t, 3> blocks_per_axis_{};
    std::vector<std::int32_t> blocks_, cells_;
    std::vector<float> constants_{0.0f};
    const std::uint16_t* halves_ = nullptr;  // one of the two, into storage_
    const float* floats_ = nullptr;
    std::unique_ptr<void, Free> storage_;
    float background_ = 0;
    IndexBox bounds_, active_bounds_;
    std::size_t brick_count_ = 0;
    std::int64_t active_voxels_ = 0;
};

/// Fills a BrickGrid, once, from one thread. Later tiles and bricks replace earlier ones at the same place.
class BrickGridBuilder {
  public:
    /// `extent` bounds all that will be set; `brick_capacity` bounds the number of bricks: their memory is
    /// reserved at once but only touched as bricks arrive, so that nothing is ever copied. Throws
    /// std::length_error where the extent needs more than kMaxBlocks blocks.
    BrickGridBuilder(const IndexBox& extent, float background, VoxelType type, std::size_t brick_capacity);

    /// Sets the cube of `size` voxels (a multiple of 8; its corner too) to a constant; clipped to the table.
    void set_tile(std::array<int, 3> corner, std::int64_t size, float value);
    /// Sets 8^3 voxels from 512 floats, z fastest. The corner is a multiple of 8.
    void set_brick(std::array<int, 3> corner, const float* values);
    /// The grid. Both arguments only describe the source, see BrickGrid.
    std::shared_ptr<const BrickGrid> finish(std::int64_t active_voxels, const IndexBox& active_bounds);

  private:
    std::int32_t constant_entry(float value);
    std::int32_t& cell_of(std::array<std::uint32_t, 3> p);
    std::int32_t& block_of(std::array<std::uint32_t, 3> p);
    std::array<std::uint32_t, 3> table_coordinates(std::array<int, 3> corner) const;
    void collapse_blocks();
    void find_bounds();

    std::unique_ptr<BrickGrid> grid_;
    std::unordered_map<std::uint32_t, std::int32_t> constant_numbers_;
    std::size_t capacity_ = 0;
};

/// A grid of nx * ny * nz values (z fastest) whose first voxel is at `corner`.
std::shared_ptr<const BrickGrid> brick_grid_of_dense(std::array<int, 3> corner, std::array<int, 3> size,
                                                     const float* values, float background = 0,
                                                     VoxelType type = VoxelType::single_float);

// --- Hot path
// ---------------------------------------------------------------------------------------------------

inline float BrickGrid::lookup_table(std::uint32_t x, std::uint32_t y, std::uint32_t z) const {
    if (!inside(x, y, z))
        return background_;
    const std::int32_t e = entry(x, y, z);
    if (e < 0)
        return constants_[static_cast<std::size_t>(~e)];
    return voxel(static_cast<std::size_t>(e) * kBrickVoxels + voxel_in_brick(x, y, z));
}

inline float BrickGrid::lookup(int i, int j, int k) const {
    return lookup_table(static_cast<std::uint32_t>(i) - origin_[0],
                        static_cast<std::uint32_t>(j) - origin_[1],
                        static_cast<std::uint32_t>(k) - origin_[2]);
}

inline float BrickGrid::stochastic(Vec3f p, Vec3f u) const {
    const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
    return lookup(i + (u.x < p.x - static_cast<float>(i)), j + (u.y < p.y - static_cast<float>(j)),
                  k + (u.z < p.z - static_cast<float>(k)));
}

inline float BrickGrid::nearest(Vec3f p) const {
    const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
    return lookup(i + (p.x - static_cast<float>(i) >= 0.5f), j + (p.y - static_cast<float>(j) >= 0.5f),
                  k + (p.z - static_cast<float>(k) >= 0.5f));
}

inline float BrickGrid::stochastic_tricubic(Vec3f p, Vec3f u) const {
    const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
    return lookup(i + pick_cubic_offset(p.x - static_cast<float>(i), u.x),
                  j + pick_cubic_offset(p.y - static_cast<float>(j), u.y),
                  k + pick_cubic_offset(p.z - static_cast<float>(k), u.z));
}

inline float BrickGrid::stochastic(Filter filter, Vec3f p, Vec3f u) const {
    if (filter == Filter::trilinear)
        return stochastic(p, u);
    return filter == Filter::nearest ? nearest(p) : stochastic_tricubic(p, u);
}

inline float BrickGrid::evaluate(Filter filter, Vec3f p) const {
    if (filter == Filter::trilinear)
        return trilinear(p);
    return filter == Filter::nearest ? nearest(p) : tricubic(p);
}

inline float BrickGrid::trilinear(Vec3f p) const {
    const int i = floor_to_int(p.x), j = floor_to_int(p.y), k = floor_to_int(p.z);
    const float fx = p.x - static_cast<float>(i), fy = p.y - static_cast<float>(j),
                fz = p.z - static_cast<float>(k);
    const std::uint32_t x = static_cast<std::uint32_t>(i) - origin_[0];
    const std::uint32_t y = static_cast<std::uint32_t>(j) - origin_[1];
    const std::uint32_t z = static_cast<std::uint32_t>(k) - origin_[2];
    float v[8];
    if (inside(x, y, z) && (x & 7) != 7 && (y & 7) != 7 && (z & 7) != 7) {  // all 8 corners in one cell
        const std::int32_t e = entry(x, y, z);
        if (e < 0)
            return constants_[static_cast<std::size_t>(~e)];
        const std::size_t first = static_cast<std::size_t>(e) * kBrickVoxels + voxel_in_brick(x, y, z);
        for (std::size_t c = 0; c < 8; ++c)
            v[c] = voxel(first + ((c & 4) << 4 | (c & 2) << 2 | (c & 1)));
    } else {
        for (std::uint32_t c = 0; c < 8; ++c)
            v[c] = lookup_table(x + (c >> 2), y + (c >> 1 & 1), z + (c & 1));
    }
    const float x00 = lerp(v[0], v[4], fx), x01 = lerp(v[1], v[5], fx);
    const float x10 = lerp(v[2], v[6], fx), x11 = lerp(v[3], v[7], fx);
    return lerp(lerp(x00, x10, fy), lerp(x01, x11, fy), fz);
}

}  // namespace nephele
