// SPDX-License-Identifier: GPL-3.0-or-later
// What keys of parts hold of the things that scenes are made of: all that can tell in what is built of them.
#pragma once

#include "base/part_key.h"
#include "media/medium_bounds.h"
#include "scene/mesh.h"
#include "shading/program.h"

namespace nephele {

void add_to(PartKey& key, const Image& image);
/// A program as `context` lets it run: the images that it reads, and the camera where it asks for it.
void add_to(PartKey& key, const Program& program, const TextureContext& context);
/// Where a medium's program runs: what its shading points have in common.
void add_to(PartKey& key, const ShadingPoint& place);
void add_to(PartKey& key, const BoundsFrame& frame, const BoundsOptions& options);

}  // namespace nephele
