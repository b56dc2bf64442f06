// SPDX-License-Identifier: GPL-3.0-or-later
#include "media/segment.h"

namespace nephele {

void add_intervals(const Medium* media_begin, const Medium* media_end, float t0, float t1, Segment& segment) {
    t0 = std::max(t0, segment.ray.t_min);
    t1 = std::min(t1, segment.ray.t_max);
    if (!(t0 < t1))
        return;
    for (const Medium* m = media_begin; m != media_end; ++m)
        segment.intervals.push_back({m, t0, t1});
}

}  // namespace nephele
