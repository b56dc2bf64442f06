// SPDX-License-Identifier: GPL-3.0-or-later
// The media along a piece of a ray: which medium is active on which interval. Built once per ray by the
// scene, then walked by the trackers.
#pragma once

#include <vector>

#include "media/medium.h"

namespace nephele {

/// A medium on [t0, t1] of the ray, t1 possibly infinite.
struct Interval {
    const Medium* medium = nullptr;
    float t0 = 0, t1 = 0;
};

/// A ray's crossing of a mesh that bounds a region; sign +1 enters, -1 leaves.
struct Crossing {
    float t;
    std::uint32_t region;
    int sign;
};

/// The intervals of one ray, with scratch memory that is reused from ray to ray.
struct Segment {
    Ray ray;
    std::uint32_t ray_kind = kCameraRay;
    std::vector<Interval> intervals;
    std::vector<Crossing> crossings;  ///< scratch

    bool empty() const { return intervals.empty(); }
};

/// Adds the intervals of `media` in [ray.t_min, ray.t_max] of one mesh region whose sorted crossings are
/// given over the whole line. The count of surfaces around the origin follows from the crossings alone: what
/// a closed mesh leaves more often than it enters, it started in. For open meshes that rule makes a face seen
/// from behind the end of a medium, and a face seen from its front the start of one.
void add_mesh_intervals(const Crossing* begin, const Crossing* end, const Medium* media_begin,
                        const Medium* media_end, Segment& segment);

}  // namespace nephele
