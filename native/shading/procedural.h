// SPDX-License-Identifier: GPL-3.0-or-later
// The procedural textures as operations of programs: how opcodes.py packs their settings into operands and
// modes.
#pragma once

#include "shading/brick.h"
#include "shading/gabor.h"
#include "shading/noise.h"
#include "shading/voronoi.h"

namespace nephele {

/// Dimensions of a texture as modes count them: 0 3D, 1 2D, 2 1D, 3 4D.
constexpr int texture_dimensions(int code) {
    return code == 3 ? 4 : 3 - code;
}

/// What the mode of "noise" says.
struct NoiseMode {
    bool color, normalize;
    int dimensions;
    NoiseType type;

    explicit constexpr NoiseMode(std::int32_t mode)
        : color((mode & 1) != 0),
          normalize((mode & 2) != 0),
          dimensions(texture_dimensions(mode >> 2 & 3)),
          type(static_cast<NoiseType>(mode >> 4)) {}
};

enum class VoronoiOutput { distance, color, position, w };
/// What the mode of "voronoi" says.
struct VoronoiMode {
    VoronoiOutput output;
    int dimensions;
    VoronoiFeature feature;
    VoronoiMetric metric;
    bool normalize;

    explicit constexpr VoronoiMode(std::int32_t mode)
        : output(static_cast<VoronoiOutput>(mode & 3)),
          dimensions(texture_dimensions(mode >> 2 & 3)),
          feature(static_cast<VoronoiFeature>(mode >> 7)),
          metric(static_cast<VoronoiMetric>(mode >> 4 & 3)),
          normalize((mode >> 6 & 1) != 0) {}
};
inline constexpr std::int32_t kLargestNoiseMode = 4 << 4 | 15, kLargestVoronoiMode = 4 << 7 | 127;

/// Values of the operations "noise", "voronoi", "white_noise", "gabor" and "brick" on their operands.
Vec3f noise_operation(std::int32_t mode, Vec3f a, Vec3f b, Vec3f c, Vec3f d);
Vec3f voronoi_operation(std::int32_t mode, Vec3f a, Vec3f b, Vec3f c, Vec3f d);
Vec3f white_noise_operation(std::int32_t mode, Vec3f a, Vec3f b);
Vec3f gabor_operation(std::int32_t mode, Vec3f a, Vec3f b, Vec3f c);
Vec3f brick_operation(const float* parameters, Vec3f a, Vec3f b, Vec3f c);

}  // namespace nephele
