// SPDX-License-Identifier: GPL-3.0-or-later
#include "media/segment.h"

namespace nephele {

namespace {

void add_interval(const Medium* media_begin, const Medium* media_end, float t0, float t1, Segment& segment) {
    t0 = std::max(t0, segment.ray.t_min);
    t1 = std::min(t1, segment.ray.t_max);
    if (!(t0 < t1))
        return;
    for (const Medium* m = media_begin; m != media_end; ++m)
        segment.intervals.push_back({m, t0, t1});
}

}  // namespace

void add_mesh_intervals(const Crossing* begin, const Crossing* end, const Medium* media_begin,
                        const Medium* media_end, Segment& segment) {
    // An edge or corner that several triangles report, at distances that differ by rounding, is crossed once;
    // where some of them are entered and some left, the ray enters before it leaves.
    constexpr float kRounding = 5e-7f;
    const float origin = max_component(max(segment.ray.o, -segment.ray.o));
    const auto for_each_place = [&](auto&& visit) {  // visit(t, enters, leaves)
        for (const Crossing* c = begin; c != end;) {
            const float t = c->t, last = t + kRounding * (origin + std::fabs(t));
            bool enters = false, leaves = false;
            for (; c != end && c->t <= last; ++c)
                (c->sign > 0 ? enters : leaves) = true;
            visit(t, enters, leaves);
        }
    };
    int depth = 0;
    for_each_place([&](float, bool enters, bool leaves) { depth += int{leaves} - int{enters}; });
    depth = std::max(depth, 0);
    float entered = segment.ray.t_min;
    for_each_place([&](float t, bool enters, bool leaves) {
        if (enters && depth++ == 0)
            entered = t;
        if (leaves && depth > 0 && --depth == 0)
            add_interval(media_begin, media_end, entered, t, segment);
    });
    if (depth > 0)
        add_interval(media_begin, media_end, entered, segment.ray.t_max, segment);
}

}  // namespace nephele
