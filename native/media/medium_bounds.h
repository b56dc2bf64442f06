// SPDX-License-Identifier: GPL-3.0-or-later
// Bounds of what varies in a medium: over the cells of a grid's index space, or of one made up for a program.
#pragma once

#include <memory>

#include "grids/majorants.h"
#include "math/transform.h"
#include "media/program_medium.h"

namespace nephele {

/// Bounds of a medium's scale (see MajorantTrack).
struct MediumBounds {
    Majorants majorants;
    Transform index_from_world;
};

/// What bounds are made for.
struct BoundsOptions {
    Accelerator accelerator = Accelerator::grid;
    bool minorants = false;  ///< else they are all 0
};

/// An index space in which a program's medium fills a box of voxels; its bounds are made by cells of 8.
struct BoundsFrame {
    Transform index_from_world, world_from_index;
    IndexBox box;
};

/// The frame of a box of the world, its longest side divided into 32 cells.
BoundsFrame frame_of_box(Vec3f lo, Vec3f hi);

/// Bounds of a medium's extinction over its frame. Where it emits, the majorant is somewhat above:
/// candidates, between which emission is gathered, then come often enough. Throws std::invalid_argument where
/// the extinction has no bound.
std::shared_ptr<const MediumBounds> bounds_of_program(const ProgramMedium& medium, const BoundsFrame& frame,
                                                      const BoundsOptions& options);

}  // namespace nephele
