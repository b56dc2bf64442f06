// SPDX-License-Identifier: GPL-3.0-or-later
// A wall of bricks, as Blender's Brick Texture has it.
#pragma once

#include "math/vec.h"

namespace nephele {

struct BrickSettings {
    float mortar_size = 0.02f, mortar_smooth = 0.1f;
    float bias = 0;  ///< towards the second colour, [-1, 1]
    float width = 0.5f, row_height = 0.25f;
    float offset = 0.5f, squash = 1;  ///< of the rows whose number `every` divides
    int offset_every = 2, squash_every = 2;
};
struct Brick {
    float tint = 0;    ///< share of the second colour, [0, 1]
    float mortar = 0;  ///< [0, 1]
};
/// The wall at an already scaled point; only x and y count.
Brick brick(Vec3f p, const BrickSettings& settings);

}  // namespace nephele
