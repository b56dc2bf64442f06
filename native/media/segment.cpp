// SPDX-License-Identifier: GPL-3.0-or-later
#include "media/segment.h"

namespace nephele {

namespace {

void add_interval(const Medium* media_begin, const Medium* media_end, float t0, float t1, Segment& segment) {
    t0 = std::max(t0, segment.ray.t_min);
    t1 = std::min(t1, segment.ray.t_max);
    if (!(t0 < t1)) return;
    for (const Medium* m = media_begin; m != media_end; ++m) segment.intervals.push_back({m, t0, t1});
}

}  // namespace

void add_mesh_intervals(const Crossing* begin, const Crossing* end, const Medium* media_begin, const Medium* media_end,
                        Segment& segment) {
    int depth = 0;
    const auto repeats = [&](const Crossing* c) {  // an edge that two triangles report is crossed once
        return c != begin && c->t == (c - 1)->t && c->sign == (c - 1)->sign;
    };
    for (const Crossing* c = begin; c != end; ++c) depth -= repeats(c) ? 0 : c->sign;
    depth = std::max(depth, 0);
    float entered = segment.ray.t_min;
    for (const Crossing* c = begin; c != end; ++c) {
        if (repeats(c)) continue;
        const int next = std::max(depth + c->sign, 0);
        if (depth > 0 && next == 0) add_interval(media_begin, media_end, entered, c->t, segment);
        if (depth == 0 && next > 0) entered = c->t;
        depth = next;
    }
    if (depth > 0) add_interval(media_begin, media_end, entered, segment.ray.t_max, segment);
}

}  // namespace nephele
