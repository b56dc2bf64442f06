// SPDX-License-Identifier: GPL-3.0-or-later
// Nested dielectrics (Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images"): where
// objects with a dielectric priority overlap, the one of highest priority is there alone. Its walls count,
// with the index of refraction of what surrounds them; walls of the others inside it do not.
//
// As with media nothing is carried along a path: all walls on a ray are found at once, and which objects its
// start lies in follows from them. Objects of equal priority merge: their walls inside each other do not
// count. Walls in the same place, to rounding, count as one, so that objects may also just touch.
#pragma once

#include <algorithm>

#include "scene/crossings.h"

namespace nephele {

/// A wall that counts. around: a wall of the object that surrounds it on the other side, null for none.
struct Interface {
    const Crossing* wall;
    const Crossing* around;
};

/// The objects with a priority along one ray.
class NestedRay {
  public:
    /// dielectrics: hierarchy of the instances with a priority, with watertight faces.
    NestedRay(const Intersector& dielectrics, std::span<const Instance> instances, const Ray& ray,
              std::uint32_t ray_kind);
    NestedRay(const NestedRay&) = delete;
    NestedRay& operator=(const NestedRay&) = delete;

    /// Walls between ray.t_min and `end` that count, nearest first.
    std::vector<Interface> interfaces(float end) const;

    /// Calls visit(a, b) for each part of [t0, t1] that is outside of every object above `priority`.
    template <class Visit>
    void visit_outside_above(int priority, float t0, float t1, Visit&& visit) const {
        for (float t = t0; t < t1;) {
            float next = t1, free_from = t;
            for (const Stay& s : stays_) {
                if (s.priority <= priority || s.t1 <= t)
                    continue;
                if (s.t0 <= t)
                    free_from = std::max(free_from, s.t1);
                else
                    next = std::min(next, s.t0);
            }
            if (free_from > t) {
                t = free_from;
                continue;
            }
            visit(t, next);
            t = next;
        }
    }

  private:
    /// A stretch of the ray inside an object; unbounded where it has no wall.
    struct Stay {
        std::uint32_t instance;
        int priority;
        const Crossing *entry, *exit;
        float t0, t1;

        bool contains(float t) const { return t0 <= t && t <= t1; }
    };

    float rounding(float t) const { return 1e-6f * (origin_ + std::fabs(t)); }
    bool hidden(const Stay& stay, float t) const;
    const Crossing* around(const Stay& stay, float t) const;

    float origin_;  ///< size of the origin's coordinates
    float t_min_;
    std::vector<Crossing> crossings_;
    std::vector<Stay> stays_;
};

}  // namespace nephele
