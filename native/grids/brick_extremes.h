// SPDX-License-Identifier: GPL-3.0-or-later
// Extremes of a brick's voxels over the parts of it that cells see: its own cell sees all of it, the cells
// before it along an axis only the first layers, those after it only the last ones.
#pragma once

#include <array>
#include <cstddef>

#include "grids/cell_bounds.h"

namespace nephele {

/// Parts of a brick by 3 digits of base 3, x first: for each axis 0 is the last layers, 1 all, 2 the first
/// layers. A cell thus sees part s of the brick that lies (digit - 1) bricks away from it along each axis.
using BrickExtremes = std::array<Bounds, 27>;

/// `kLast`, `kFirst`: number of layers of those parts; parts of 0 layers come as no place at all.
template <int kLast, int kFirst>
BrickExtremes extremes_of_brick(const float* voxels) {
    // One axis after the other, as a separable filter. Kinds of rows (along z) and of slabs (along y and z)
    // are widened into each part of which their layer is one.
    const auto widen = [](auto& parts, int layer, const auto& kinds) {
        for (std::size_t k = 0; k < kinds.size(); ++k) {
            if (kLast > 0 && layer >= 8 - kLast)
                parts[k].include(kinds[k]);
            parts[kinds.size() + k].include(kinds[k]);
            if (layer < kFirst)
                parts[2 * kinds.size() + k].include(kinds[k]);
        }
    };
    BrickExtremes out;
    for (int x = 0; x < 8; ++x) {
        std::array<Bounds, 9> slab;
        for (int y = 0; y < 8; ++y) {
            const float* row = voxels + x * 64 + y * 8;
            std::array<Bounds, 3> kinds;
            for (int z = 0; z < 8; ++z)
                kinds[1].include({row[z], row[z]});
            for (int z = 0; z < kFirst; ++z)
                kinds[2].include({row[z], row[z]});
            for (int z = 8 - kLast; z < 8; ++z)
                kinds[0].include({row[z], row[z]});
            widen(slab, y, kinds);
        }
        widen(out, x, slab);
    }
    return out;
}

}  // namespace nephele
