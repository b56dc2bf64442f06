// SPDX-License-Identifier: GPL-3.0-or-later
// How a lamp moves while the shutter is open: it turns and wanders as a whole, so that what asks for its
// light at a time may be moved to where the lamp stands as at the frame. Its size is that of the frame.
#pragma once

#include "math/motion.h"
#include "math/pose.h"

namespace nephele {

class LampMotion {
  public:
    /// Stands still.
    LampMotion() = default;
    /// rest: the placement at the frame. Throws std::invalid_argument as Motion does.
    LampMotion(const Transform& rest, std::span<const std::array<double, 16>> matrices)
        : rest_(rest), motion_(matrices) {}

    bool moves() const { return motion_.moves(); }

    /// The lamp at one time.
    struct Moment {
        Pose rest, now;
        /// Points and vectors of the world, as they lie to the lamp where it stands at the frame.
        Vec3f point_to_rest(Vec3f p) const { return rest.origin + to_rest(p - now.origin); }
        Vec3f to_rest(Vec3f v) const { return rest.to_world(now.to_local(v)); }
        Vec3f point_from_rest(Vec3f p) const { return now.origin + from_rest(p - rest.origin); }
        Vec3f from_rest(Vec3f v) const { return now.to_world(rest.to_local(v)); }
    };
    Moment at(float time) const { return {Pose(rest_), Pose(motion_.at(time))}; }
    const Motion& motion() const { return motion_; }

  private:
    Transform rest_;
    Motion motion_;
};

}  // namespace nephele
