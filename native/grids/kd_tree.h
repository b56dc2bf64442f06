// SPDX-License-Identifier: GPL-3.0-or-later
// A kd-tree of majorants and minorants over cells of 8^3 voxels: Yue, Iwasaki, Chen, Dobashi, Nishita 2010,
// "Unbiased, adaptive stochastic sampling for rendering inhomogeneous participating media". Unlike a grid's
// cubes its leaves have any shape, so that one leaf may cover a slab of empty space or a flat cloud's inside.
//
// Nodes are 64 bits in the order of a heap: the children of node i are 2i + 1 and 2i + 2.
//
//     bits  0-1    axis of the split; 3: a leaf
//     bits  2-23   the split: first cell of the upper child
//     bits 24-43   majorant, rounded up;     floats without sign and with 12 bits of mantissa
//     bits 44-63   minorant, rounded down
//
// A walk finds each leaf from the root by its cell, as it finds the cubes of a grid: no plane is computed
// twice, so that rounding can neither skip a leaf nor loop. How splits are chosen: see kd_tree.cpp.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <vector>

#include "grids/cell_bounds.h"
#include "grids/majorant_walk.h"
#include "math/vec.h"

namespace nephele {

class KdTree {
  public:
    static constexpr int kMaxDepth = 18;  ///< at most 2^19 - 1 nodes: 4 MiB

    /// Of a field that is nowhere negative. `sigma_scale`: sigma_t that a value of 1 stands for, per unit of
    /// index space; it decides what splits. Without minorants every minorant inside the support is 0, and
    /// splits are chosen for trackers that do not use them.
    explicit KdTree(const CellBounds& bounds, float sigma_scale, bool with_minorants = false);

    float global_majorant() const { return global_majorant_; }
    float global_minorant() const { return global_minorant_; }
    const Bounds& background() const { return background_; }
    std::size_t bytes() const { return sizeof(*this) + nodes_.size() * sizeof(std::uint64_t); }
    /// Number of leaves, and of splits on the way to the deepest one.
    std::size_t leaves() const;
    int depth() const { return std::bit_width(nodes_.size()) - 1; }

    /// The leaf around a cell of the table.
    CellBox box_at(const std::array<int, 3>& cell) const {
        std::array<std::array<int, 3>, 2> box{std::array<int, 3>{0, 0, 0}, cells_};  // first, end
        std::size_t i = 0;
        std::uint64_t node = nodes_[0];
        for (; (node & 3) != kLeaf; node = nodes_[i]) {
            const std::size_t axis = node & 3;
            const auto split = static_cast<int>(node >> 2 & kSplitMask);
            const bool upper = cell[axis] >= split;
            box[!upper][axis] = split;
            i = 2 * i + 1 + upper;
        }
        return {box[0], box[1], majorant_of(node), minorant_of(node)};
    }
    /// First voxel of the table's first cell: a multiple of 8.
    const std::array<int, 3>& origin() const { return origin_; }
    /// Number of cells of the table.
    const std::array<int, 3>& cells() const { return cells_; }
    /// Outside [support_min, support_max) there is only the background. Equal where that is all.
    Vec3f support_min() const { return support_min_; }
    Vec3f support_max() const { return support_max_; }

  private:
    friend class KdTreeBuilder;
    static constexpr std::uint64_t kLeaf = 3, kSplitMask = (1u << 22) - 1, kValueMask = (1u << 20) - 1;
    static constexpr int kDroppedBits = 11;  // of a float's mantissa

    static float majorant_of(std::uint64_t node) {
        return std::bit_cast<float>(static_cast<std::uint32_t>(node >> 24 & kValueMask) << kDroppedBits);
    }
    static float minorant_of(std::uint64_t node) {
        return std::bit_cast<float>(static_cast<std::uint32_t>(node >> 44) << kDroppedBits);
    }
    /// A leaf with these bounds, rounded outward.
    static std::uint64_t pack(const Bounds& bounds);
    /// The same node, split.
    static std::uint64_t split_node(std::uint64_t node, std::size_t axis, int split) {
        return (node & ~std::uint64_t{0xffffff}) | static_cast<std::uint64_t>(split) << 2 | axis;
    }

    std::array<int, 3> origin_{}, cells_{};
    std::vector<std::uint64_t> nodes_;
    Vec3f support_min_, support_max_;
    Bounds background_;
    float global_majorant_ = 0, global_minorant_ = 0;
};

using KdTreeWalk = BoxWalk<KdTree>;

}  // namespace nephele
