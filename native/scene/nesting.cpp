// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/nesting.h"

namespace nephele {

NestedRay::NestedRay(const Intersector& dielectrics, std::span<const Instance> instances, const Ray& ray,
                     std::uint32_t ray_kind)
    : origin_(max_component(max(ray.o, -ray.o))), t_min_(ray.t_min) {
    find_crossings(dielectrics, instances, ray, ray_kind, crossings_);
    const Crossing* const end = crossings_.data() + crossings_.size();
    for (const Crossing* first = crossings_.data(); first != end;) {
        const std::uint32_t instance = first->instance;
        const Crossing* const last =
            std::find_if(first, end, [&](const Crossing& c) { return c.instance != instance; });
        for_each_stay(first, last, [&](const Crossing* entry, const Crossing* exit) {
            stays_.push_back({instance, instances[instance].dielectric_priority, entry, exit,
                              entry ? entry->t : -kInfinity, exit ? exit->t : kInfinity});
        });
        first = last;
    }
}

/// Whether a wall of `stay` at t lies in an object that prevails over it.
bool NestedRay::hidden(const Stay& stay, float t) const {
    const float near = rounding(t);
    return std::any_of(stays_.begin(), stays_.end(), [&](const Stay& s) {
        if (s.instance == stay.instance || s.priority < stay.priority || t < s.t0 - near || t > s.t1 + near)
            return false;
        const bool within = t > s.t0 + near && t < s.t1 - near;
        return s.priority > stay.priority || within || s.instance < stay.instance;
    });
}

/// The prevailing one of the other objects at t.
const Crossing* NestedRay::around(const Stay& stay, float t) const {
    const Stay* found = nullptr;
    for (const Stay& s : stays_) {
        if (s.instance == stay.instance || !s.contains(t))
            continue;
        if (found == nullptr || s.priority > found->priority)
            found = &s;
    }
    return found == nullptr ? nullptr : found->exit ? found->exit : found->entry;
}

std::vector<Interface> NestedRay::interfaces(float end) const {
    std::vector<Interface> out;
    for (const Stay& s : stays_) {
        for (const Crossing* wall : {s.entry, s.exit}) {
            if (wall == nullptr || wall->t < t_min_ || wall->t > end || hidden(s, wall->t))
                continue;
            const float step = 2 * rounding(wall->t);
            out.push_back({wall, around(s, wall == s.entry ? wall->t - step : wall->t + step)});
        }
    }
    std::sort(out.begin(), out.end(),
              [](const Interface& a, const Interface& b) { return a.wall->t < b.wall->t; });
    return out;
}

}  // namespace nephele
