// SPDX-License-Identifier: GPL-3.0-or-later
// A placement without scale and shear.
#pragma once

#include "math/transform.h"

namespace nephele {

/// A turn and a shift; axes: unit vectors at right angles.
struct Pose {
    Vec3f x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1}, origin;

    Pose() = default;
    /// The same of any placement, its scale and shear left out; mirroring stays.
    explicit Pose(const Transform& m) : origin(m.translation) {
        x = safe_normalize(m.column(0));
        const Vec3f up = m.column(1);
        y = safe_normalize(up - x * dot(x, up));
        z = cross(x, y);
        if (dot(z, m.column(2)) < 0)
            z = -z;
    }
    Vec3f to_local(Vec3f v) const { return {dot(v, x), dot(v, y), dot(v, z)}; }
    Vec3f to_world(Vec3f v) const { return x * v.x + y * v.y + z * v.z; }
};

}  // namespace nephele
