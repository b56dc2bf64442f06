// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/procedural.h"

namespace nephele {

Vec3f noise_operation(std::int32_t mode, Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
    const NoiseMode m(mode);
    const NoiseSettings settings{c.x, c.y, c.z, d.x, m.normalize, m.dimensions, m.type, b.z, d.y};
    const NoisePoint p(a * b.x, b.x * b.y);
    return m.color ? noise_color(p, settings) : Vec3f(noise_value(p, settings));
}

Vec3f voronoi_operation(std::int32_t mode, Vec3f a, Vec3f b, Vec3f c, Vec3f d) {
    const VoronoiMode m(mode);
    const VoronoiSettings settings{m.feature, m.metric, m.dimensions, m.normalize, c.x,
                                   c.y,       c.z,      d.x,          b.z,         d.y};
    const float scale = b.x;
    const Voronoi v = voronoi({a.x * scale, a.y * scale, a.z * scale, b.y * scale}, settings);
    const auto unscaled = [&](std::size_t i) { return scale != 0 ? v.position[i] / scale : 0; };
    switch (m.output) {
        case VoronoiOutput::distance:
            return Vec3f(v.distance);
        case VoronoiOutput::color:
            return v.color;
        case VoronoiOutput::position:
            return {unscaled(0), unscaled(1), unscaled(2)};
        default:
            return Vec3f(unscaled(m.dimensions == 1 ? 0 : 3));
    }
}

Vec3f white_noise_operation(std::int32_t mode, Vec3f a, Vec3f b) {
    const int dimensions = texture_dimensions(mode >> 1);
    const NoisePoint p(a, b.x);
    return mode & 1 ? white_noise_color(p, dimensions) : Vec3f(white_noise(p, dimensions));
}

Vec3f gabor_operation(std::int32_t mode, Vec3f a, Vec3f b, Vec3f c) {
    const Gabor g = gabor_noise(a, {b.x, b.y, b.z, c, (mode & 4) != 0});
    const int output = mode & 3;
    return Vec3f(output == 0 ? g.value : output == 1 ? g.phase : g.intensity);
}

Vec3f brick_operation(const float* parameters, Vec3f a, Vec3f b, Vec3f c) {
    const auto integer = [](float x) {
        return static_cast<int>(std::max(0.0f, std::min(x, 99.0f)));  // NaN counts as 0
    };
    const Brick wall = brick(a, {b.x, b.y, b.z, c.x, c.y, parameters[0], parameters[1],
                                 integer(parameters[2]), integer(parameters[3])});
    return {wall.tint, wall.mortar, 0};
}

}  // namespace nephele
