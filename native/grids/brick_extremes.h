// SPDX-License-Identifier: GPL-3.0-or-later
// Extremes of a brick's voxels over the parts of it that cells see: its own cell sees all of it, the cells
// before it along an axis only the first layers, those after it only the last ones.
#pragma once

#include <array>
#include <cstddef>

#include "grids/cell_bounds.h"

namespace nephele {

/// Parts of a brick by 3 digits, x first: for each axis its last layers (only where there are any to be
/// seen), all, or its first layers. A cell thus sees part s of the brick that lies digit - kBefore bricks
/// from it.
template <int kLast, int kFirst>
struct BrickExtremes {
    static constexpr int kBefore = kLast > 0 ? 1 : 0;  ///< the digit that stands for all
    static constexpr std::size_t kParts = kBefore + 2;

    std::array<Bounds, kParts * kParts * kParts> parts;

    explicit BrickExtremes(const float* voxels);
    BrickExtremes() = default;
};

/// `kLast`, `kFirst`: number of layers of those parts.
template <int kLast, int kFirst>
BrickExtremes<kLast, kFirst>::BrickExtremes(const float* voxels) {
    // One axis after the other, as a separable filter. Kinds of rows (along z) and of slabs (along y and z)
    // are widened into each part of which their layer is one.
    const auto widen = [](auto& wider, int layer, const auto& kinds) {
        const std::size_t n = kinds.size();
        for (std::size_t k = 0; k < n; ++k) {
            if (kLast > 0 && layer >= 8 - kLast)
                wider[k].include(kinds[k]);
            wider[kBefore * n + k].include(kinds[k]);
            if (layer < kFirst)
                wider[(kBefore + 1) * n + k].include(kinds[k]);
        }
    };
    for (int x = 0; x < 8; ++x) {
        std::array<Bounds, kParts * kParts> slab;
        for (int y = 0; y < 8; ++y) {
            const float* row = voxels + x * 64 + y * 8;
            std::array<Bounds, kParts> kinds;
            for (int z = 0; z < 8; ++z)
                kinds[kBefore].include({row[z], row[z]});
            for (int z = 0; z < kFirst; ++z)
                kinds[kBefore + 1].include({row[z], row[z]});
            for (int z = 8 - kLast; z < 8; ++z)
                kinds[0].include({row[z], row[z]});
            widen(slab, y, kinds);
        }
        widen(parts, x, slab);
    }
}

}  // namespace nephele
