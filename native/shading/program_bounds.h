// SPDX-License-Identifier: GPL-3.0-or-later
// What a shading program can return inside a box of space: its registers' bounds, by interval arithmetic. The
// twin of program.h for majorants of media whose coefficients a program computes. Operands count as
// independent of each other, so that bounds are true but not always tight.
#pragma once

#include <functional>

#include "shading/interval.h"
#include "shading/program.h"

namespace nephele {

/// Bounds of three floats, channel by channel.
struct Interval3 {
    Vec3f lo, hi;
    std::uint8_t nan = 0;  ///< bit c: channel c may also be NaN

    Interval3() = default;
    explicit Interval3(Vec3f v);
    Interval3(Interval1 x, Interval1 y, Interval1 z);
    explicit Interval3(Interval1 v) : Interval3(v, v, v) {}

    Interval1 operator[](int c) const { return {lo[c], hi[c], (nan >> c & 1) != 0}; }
};

/// p moved by a fixed vector.
inline Interval3 moved(const Interval3& p, Vec3f by) {
    return {p[0] + double{by.x}, p[1] + double{by.y}, p[2] + double{by.z}};
}

/// Bounds of all that filtering an image can give. Made once per image: they cost a pass over its texels.
struct ImageBounds {
    Interval3 rgb;
    Interval1 alpha;

    ImageBounds() = default;
    explicit ImageBounds(const Image& image);
};

/// Where a program is to be bounded. What does not vary over the box is read from `point`: instance, mesh,
/// volume, triangle and barycentric coordinates. Its position, normals and ray are not looked at: positions
/// are those of the box (and object_p what the instance's object_from_world makes of them), directions are
/// any. The box moves as the instance does: positions are those of all times then.
struct BoundsInput {
    Vec3f lo, hi;  ///< the box, world space as at the frame; directions for the world
    const ShadingPoint& point;
    const TextureContext& context;
    std::span<const ImageBounds> images;  ///< one per context.images
    /// Bounds of what the volume's field `number` gives at any point of a box of the world, whose ends may be
    /// infinite. Asked where point.volume is not null only.
    std::function<Interval3(std::int32_t number, Vec3f lo, Vec3f hi)> grid_range;
    /// Of an instance that moves: where what stands at the frame gets to. It is between these at all times.
    std::span<const Transform> world_from_rest{};
};

/// Bounds of the registers that run() leaves at any point of the box. registers: room for
/// program.registers.size() values. The program must be validated.
void bound(const Program& program, const BoundsInput& input, Interval3* registers);

/// As finite() and non_negative() of program.h: what closures make of a register.
Interval3 finite(const Interval3& v);
Interval3 non_negative(const Interval3& v);

}  // namespace nephele
