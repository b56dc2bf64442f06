// SPDX-License-Identifier: GPL-3.0-or-later
// Where a ray enters and leaves meshes, over its whole length, in one traversal.
#pragma once

#include <span>
#include <vector>

#include "media/segment.h"
#include "scene/intersector.h"

namespace nephele {

/// Fills `out` with the crossings from ray.t_min to infinity of the instances that rays of this kind see, by
/// instance and then by distance; entries come before exits at the same place. hierarchy: with watertight
/// faces.
void find_crossings(const Intersector& hierarchy, std::span<const Instance> instances, const Ray& ray,
                    std::uint32_t ray_kind, std::vector<Crossing>& out);

}  // namespace nephele
