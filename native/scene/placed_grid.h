// SPDX-License-Identifier: GPL-3.0-or-later
// A grid of a volume object, placed in the world.
#pragma once

#include <cstdint>
#include <vector>

#include "grids/volume_fields.h"
#include "media/medium_bounds.h"

namespace nephele {

struct PlacedGrid {
    VolumeField field;
    std::uint64_t id = 0;  ///< GridPlacement::id
    double world_from_index[16];
    IndexBox box;  ///< of all points where it may differ from its background, or where it is active
};

/// The frame in which a program that reads these grids is bounded: the index space of the first, and a box
/// that holds all.
BoundsFrame frame_of(const std::vector<const PlacedGrid*>& grids, const VolumeMotion* motion);

}  // namespace nephele
