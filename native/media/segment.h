// SPDX-License-Identifier: GPL-3.0-or-later
// The media along a piece of a ray: which medium is active on which interval. Built once per ray by the
// scene, then walked by the trackers.
#pragma once

#include <algorithm>
#include <vector>

#include "compiled/motion.h"
#include "media/medium.h"

namespace nephele {

/// A ray at its time of the shutter as seen from an object that moves: in the space of the world where that
/// object stands as at the frame itself, where its grids and bounds are. Parameters t are the ray's own.
struct RestRay {
    Ray ray;  ///< its direction is of unit length only where the object does not stretch
    Transform rest_from_world;

    RestRay(const Instance& instance, const Ray& world_ray);
};

inline constexpr std::uint32_t kStandsStill = ~0u;

/// A medium on [t0, t1] of the ray, t1 possibly infinite. rest: number of the segment's rest ray in which a
/// medium that varies is looked up, where its object moves.
struct Interval {
    const Medium* medium = nullptr;
    float t0 = 0, t1 = 0;
    std::uint32_t rest = kStandsStill;
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
    std::vector<RestRay> rests;
    std::vector<Crossing> crossings;  ///< scratch

    bool empty() const { return intervals.empty(); }
    static bool moves(const Interval& interval) { return compiled::motion && interval.rest != kStandsStill; }
    /// Null where the interval's medium stands still.
    const RestRay* rest_of(const Interval& interval) const {
        return moves(interval) ? &rests[interval.rest] : nullptr;
    }
    /// The ray in the space in which the interval's medium is looked up.
    const Ray& ray_of(const Interval& interval) const {
        return moves(interval) ? rests[interval.rest].ray : ray;
    }
    /// Where a program computes the interval's medium at t.
    VolumePoint volume_point(const Interval& interval, float t) const {
        const RestRay* rest = rest_of(interval);
        return {ray.at(t), -ray.d, ray_kind, ray.time, rest ? &rest->rest_from_world : nullptr};
    }
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

/// Adds intervals of the media on [t0, t1], as far as the segment's ray reaches. rest: see Interval.
void add_intervals(const Medium* media_begin, const Medium* media_end, float t0, float t1, Segment& segment,
                   std::uint32_t rest = kStandsStill);

}  // namespace nephele
