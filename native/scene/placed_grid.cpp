// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/placed_grid.h"

namespace nephele {

BoundsFrame frame_of(const std::vector<const PlacedGrid*>& grids, const VolumeMotion* motion) {
    const PlacedGrid& first = *grids.front();
    BoundsFrame frame{first.field.index_from_world, transform_of(first.world_from_index), {}};
    for (const PlacedGrid* grid : grids) {
        const Transform world_from_index = transform_of(grid->world_from_index);
        Vec3f lo(kInfinity), hi(-kInfinity);  // world
        for (int corner = 0; corner < 8; ++corner) {
            Vec3f p;
            for (int a = 0; a < 3; ++a) {
                const auto i = static_cast<std::size_t>(a);
                p[a] = static_cast<float>(corner >> a & 1 ? grid->box.max[i] : grid->box.min[i]);
            }
            lo = min(lo, world_from_index.point(p));
            hi = max(hi, world_from_index.point(p));
        }
        if (motion) {  // what gets here was carried the other way
            Vec3f from = lo, to = hi;
            motion->grow(from, to);
            const Vec3f reach = max(lo - from, to - hi);
            lo = lo - max(reach, Vec3f(0));
            hi = hi + max(reach, Vec3f(0));
        }
        for (int corner = 0; corner < 8; ++corner) {
            const Vec3f p = frame.index_from_world.point(
                {corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z});
            frame.box.include({floor_to_int(p.x), floor_to_int(p.y), floor_to_int(p.z)});
            frame.box.include({floor_to_int(p.x) + 1, floor_to_int(p.y) + 1, floor_to_int(p.z) + 1});
        }
    }
    return frame;
}

}  // namespace nephele
