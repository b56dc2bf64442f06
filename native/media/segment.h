// SPDX-License-Identifier: GPL-3.0-or-later
// The media along a piece of a ray: which medium is active on which interval. Built once per ray by the
// scene, then walked by the trackers.
#pragma once

#include <algorithm>
#include <vector>

#include "media/medium.h"

namespace nephele {

/// A medium on [t0, t1] of the ray, t1 possibly infinite.
struct Interval {
    const Medium* medium = nullptr;
    float t0 = 0, t1 = 0;
};

/// A ray's crossing of a face of an instance of a mesh; sign +1 enters, -1 leaves. triangle, u, v: as in Hit.
struct Crossing {
    float t;
    std::uint32_t instance;
    int sign;
    std::uint32_t triangle = 0;
    float u = 0, v = 0;
};

/// The intervals of one ray, with scratch memory that is reused from ray to ray.
struct Segment {
    Ray ray;
    std::uint32_t ray_kind = kCameraRay;
    std::vector<Interval> intervals;
    std::vector<Crossing> crossings;  ///< scratch

    bool empty() const { return intervals.empty(); }
};

/// Calls visit(entry, exit) for each stretch of the line inside one mesh, whose crossings from ray.t_min to
/// infinity are given in order; null for an entry before the ray's start and an exit that never comes. The
/// count of surfaces around the start follows from the crossings alone: what a closed mesh leaves more often
/// than it enters, it started in. Parts of the mesh that overlap are one. For open meshes the rule makes a
/// face seen from behind the end of a stretch, and a face seen from its front the start of one.
template <class Visit>
void for_each_stay(const Crossing* begin, const Crossing* end, Visit&& visit) {
    int depth = 0;
    for (const Crossing* c = begin; c != end; ++c)
        depth -= c->sign;
    depth = std::max(depth, 0);
    const Crossing* entry = nullptr;
    for (const Crossing* c = begin; c != end; ++c) {
        if (c->sign > 0) {
            if (depth++ == 0)
                entry = c;
        } else if (depth > 0 && --depth == 0) {
            visit(entry, c);
        }
    }
    if (depth > 0)
        visit(entry, nullptr);
}

/// Adds intervals of the media on [t0, t1], as far as the segment's ray reaches.
void add_intervals(const Medium* media_begin, const Medium* media_end, float t0, float t1, Segment& segment);

}  // namespace nephele
