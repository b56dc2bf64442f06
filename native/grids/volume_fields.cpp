// SPDX-License-Identifier: GPL-3.0-or-later
#include "grids/volume_fields.h"

namespace nephele {

namespace {

/// The box that an affine map makes of a box, with room for rounding. Ends may be infinite.
void map_box(const Transform& map, Vec3f lo, Vec3f hi, Vec3f& out_lo, Vec3f& out_hi) {
    constexpr double kRounding = 1e-6;
    for (int r = 0; r < 3; ++r) {
        double from = double{map.translation[r]}, to = from, size = std::fabs(from);
        for (int c = 0; c < 3; ++c) {
            const double m = double{map.row[static_cast<std::size_t>(r)][c]};
            if (m == 0)
                continue;
            const double a = m * double{lo[c]}, b = m * double{hi[c]};
            from += std::min(a, b);
            to += std::max(a, b);
            size += std::max(std::fabs(a), std::fabs(b));
        }
        out_lo[r] = static_cast<float>(from - kRounding * size);
        out_hi[r] = static_cast<float>(to + kRounding * size);
    }
}

}  // namespace

std::array<Bounds, 3> VolumeField::range(Vec3f lo_world, Vec3f hi_world) const {
    Vec3f lo, hi;
    map_box(index_from_world, lo_world, hi_world, lo, hi);
    std::array<Bounds, 3> out;
    for (std::size_t c = 0; c < 3; ++c)
        out[c] = c == 0 || is_vector() ? bounds[c]->range(lo, hi) : out[0];
    return out;
}

void VolumeMotion::grow(Vec3f& lo_world, Vec3f& hi_world) const {
    std::array<Bounds, 3> v;
    if (velocity.size() == 1) {
        v = velocity[0].range(lo_world, hi_world);
    } else {
        for (std::size_t c = 0; c < 3; ++c)
            v[c] = velocity[c].range(lo_world, hi_world)[0];
    }
    Vec3f lo, hi;  // of the way travelled in a frame
    map_box(world_from_velocity, {v[0].min, v[1].min, v[2].min}, {v[0].max, v[1].max, v[2].max}, lo, hi);
    const Vec3f a = min(min(lo * open, hi * open), min(lo * close, hi * close));
    const Vec3f b = max(max(lo * open, hi * open), max(lo * close, hi * close));
    lo_world = lo_world - b;
    hi_world = hi_world - a;
}

std::array<Bounds, 3> VolumeFields::range(std::int32_t number, Vec3f lo_world, Vec3f hi_world) const {
    const auto i = static_cast<std::size_t>(number);
    if (i >= fields_.size() || !fields_[i].components[0])
        return {Bounds{0, 0}, Bounds{0, 0}, Bounds{0, 0}};
    if (motion_)
        motion_->grow(lo_world, hi_world);
    return fields_[i].range(lo_world, hi_world);
}

void VolumeField::add_to(PartKey& key) const {
    for (std::size_t c = 0; c < 3; ++c)
        key.add(components[c]).add(bounds[c]);
    key.add(filter).add(index_from_world);
}

void VolumeMotion::add_to(PartKey& key) const {
    key.add(velocity.size());
    for (const VolumeField& field : velocity)
        field.add_to(key);
    key.add(world_from_velocity).add(open).add(close);
}

void VolumeFields::add_to(PartKey& key) const {
    key.add(fields_.size());
    for (const VolumeField& field : fields_)
        field.add_to(key);
    key.add(motion_ != nullptr);
    if (motion_)
        motion_->add_to(key);
}

}  // namespace nephele
