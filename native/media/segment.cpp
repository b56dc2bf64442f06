// SPDX-License-Identifier: GPL-3.0-or-later
#include "media/segment.h"

#include "scene/mesh.h"

namespace nephele {

RestRay::RestRay(const Instance& instance, const Ray& world_ray) : ray(world_ray) {
    rest_from_world = instance.world_from_object * inverse_of(instance.motion.at(world_ray.time));
    ray.o = rest_from_world.point(world_ray.o);
    ray.d = rest_from_world.vector(world_ray.d);
}

void add_intervals(const Medium* media_begin, const Medium* media_end, float t0, float t1, Segment& segment,
                   std::uint32_t rest) {
    t0 = std::max(t0, segment.ray.t_min);
    t1 = std::min(t1, segment.ray.t_max);
    if (!(t0 < t1))
        return;
    for (const Medium* m = media_begin; m != media_end; ++m)
        segment.intervals.push_back({m, t0, t1, rest});
}

}  // namespace nephele
