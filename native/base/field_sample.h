// SPDX-License-Identifier: GPL-3.0-or-later
// What a path tells about light at one of its vertices: the segment that leaves it, and what came back.
#pragma once

#include <cstdint>

#include "base/vsp_record.h"
#include "math/vec.h"

namespace nephele {

/// Which part of the field a vertex belongs to: volumes, or surfaces by the axis that their geometric normal
/// is nearest to. The two faces of a thin wall see different light.
enum class FieldPart : std::uint32_t { volume, minus_x, plus_x, minus_y, plus_y, minus_z, plus_z };
inline constexpr int kFieldParts = 7;

/// Of a surface. n: its geometric normal, on the side that the path is on.
inline FieldPart part_facing(Vec3f n) {
    const Vec3f a(std::abs(n.x), std::abs(n.y), std::abs(n.z));
    const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
    return static_cast<FieldPart>(1 + 2 * axis + (n[axis] > 0 ? 1 : 0));
}

/// What one vertex teaches the guiding field. World space; light, scattering: mean over RGB.
struct FieldSample {
    std::uint64_t key = 0;  ///< of the path and the vertex, another for each: samples count in this order
    Vec3f p, wi;            ///< the vertex, and the unit direction in which the path went on
    float distance = kInfinity;  ///< along wi to the path's next event, m
    float pdf = 0;               ///< with which wi was drawn, 1/sr, whatever took part in it
    float scatter_pdf = 0;       ///< with which the BSDF or phase function alone draws wi, 1/sr
    float guide_pdf = -1;        ///< with which the field alone would have drawn it, 1/sr; < 0: not asked
    float scattering = 0;        ///< BSDF times cosine, or phase function with albedo, 1/sr
    float light = 0;             ///< radiance that came along wi: an unbiased sample of what light sampling
                                 ///< at p leaves over
    float cost = 0;              ///< work of the rest of the path
    FieldPart part = FieldPart::volume;
    VspRecord vsp;  ///< of the segment along wi
};

}  // namespace nephele
