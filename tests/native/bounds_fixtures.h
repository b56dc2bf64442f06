// SPDX-License-Identifier: GPL-3.0-or-later
// A volume in which programs are bounded and run: an object that is turned, scaled and moved, with a mesh,
// images, a camera and a grid; random operands, and the comparison of values with their bounds.
#pragma once

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "grids/volume_fields.h"
#include "scene/mesh.h"
#include "shading/program_bounds.h"

namespace nephele::test {

/// Random numbers, of fixed seeds.
class Random {
  public:
    explicit Random(std::uint32_t seed) : engine_(seed) {}

    float unit() { return std::uniform_real_distribution<float>(0, 1)(engine_); }
    float between(float lo, float hi) { return lo + (hi - lo) * unit(); }
    int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(engine_); }
    Vec3f vector(float lo, float hi) { return {between(lo, hi), between(lo, hi), between(lo, hi)}; }

    /// An interval as programs meet them: around 0, 1, small integers or any number, wide, narrow or a point.
    Interval1 interval() {
        const float centers[] = {0,
                                 1,
                                 static_cast<float>(below(9) - 4),
                                 between(-3, 3),
                                 between(0, 1),
                                 std::exp(between(-20, 20)) * (below(2) == 0 ? 1.0f : -1.0f)};
        const float center = centers[below(6)], size = std::max(1.0f, std::fabs(center));
        const float widths[] = {0, 1e-6f * size, 0.1f * size, size, 5 * size};
        const float before = widths[below(5)], after = widths[below(5)];
        return {center - before * unit(), center + after * unit()};
    }
    /// A number of an interval, often an end of it.
    float inside(Interval1 i) {
        const auto lo = static_cast<float>(i.lo), hi = static_cast<float>(i.hi);
        const int kind = below(6);
        return kind == 0 ? lo : kind == 1 ? hi : std::clamp(between(lo, hi), lo, hi);
    }
    Vec3f inside(const Interval3& i) { return {inside(i[0]), inside(i[1]), inside(i[2])}; }

  private:
    std::mt19937 engine_;
};

class Volume {
  public:
    Volume() {
        mesh.positions = Buffer(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
        mesh.triangles = Buffer(std::vector<std::int32_t>{0, 1, 2});
        mesh.uvs.push_back(Buffer(std::vector<float>{0, 0, 1, 0, 0, 1}));
        mesh.attributes.push_back(Buffer(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0.5f, 0, 0, 1, 1}));
        mesh.generated_min = {-1, -2, 0.5f};
        mesh.generated_size = {2, 3, 0};
        const double matrix[16] = {1.2, -0.8, 0, 3, 0.8, 1.2, 0.1, -2, 0, 0.3, 2, 1, 0, 0, 0, 1};
        instance.world_from_object = transform_of(matrix);
        instance.object_from_world = inverse_of(matrix);
        instance.random = 0.75f;
        instance.color = {0.1f, 0.2f, 0.3f, 1};
        instance.pass_index = 7;
        instance.properties = {{0.5f, -2, 30, 0.25f}};

        Random random(1);
        std::vector<float> texels(4 * 5 * 3);
        for (float& texel : texels)
            texel = random.between(-0.5f, 2);
        Image image;
        image.width = 5;
        image.height = 3;
        image.floats = Buffer(texels);
        images.push_back(image);
        image_bounds.emplace_back(image);
        context.images = images;
        const double camera[16] = {1, 0.1, 0, -3, -0.1, 1, 0, -2, 0, 0, 1, -7, 0, 0, 0, 1};
        context.camera_from_world = transform_of(camera);
        context.viewplane = {-1, 1, -0.5f, 0.5f};

        std::vector<float> voxels(8 * 8 * 8);
        for (float& v : voxels)
            v = random.between(0.2f, 1.5f);
        VolumeField field;
        field.components[0] = brick_grid_of_dense({0, 0, 0}, {8, 8, 8}, voxels.data());
        field.bounds[0] =
            std::make_shared<const CellBounds>(CellBounds::of_grid(*field.components[0], field.filter));
        fields = VolumeFields({field});
        set_point({0, 0, 0}, random);
    }

    /// Moves the shading point to a point of the world, with any ray and normals.
    void set_point(Vec3f p, Random& random) {
        const auto direction = [&] { return normalize(random.vector(-1, 1) + Vec3f(1e-3f)); };
        point.instance = &instance;
        point.mesh = &mesh;
        point.volume = &fields;
        point.barycentric = {0.25f, 0.5f, 0.25f};
        point.p = p;
        point.object_p = instance.object_from_world.point(p);
        point.ng = direction();
        point.ns = direction();
        point.wo = direction();
        point.backfacing = random.below(2) == 1;
        point.ray_kind = 1u << random.below(6);
    }

    BoundsInput input(Vec3f lo, Vec3f hi) const {
        return {lo, hi, point, context, image_bounds, [](std::int32_t, Vec3f, Vec3f) {
                    return Interval3(Interval1(0, 1.500001));  // 0 outside the grid
                }};
    }

    Mesh mesh;
    Instance instance;
    std::vector<Image> images;
    std::vector<ImageBounds> image_bounds;
    TextureContext context;
    VolumeFields fields;
    ShadingPoint point;
};

/// Whether bounds hold a value; NaN needs the mark that it may appear.
inline bool holds(const Interval1& bounds, float v) {
    return std::isnan(v) ? bounds.nan : bounds.contains(v);
}
inline bool holds(const Interval3& bounds, Vec3f v) {
    return holds(bounds[0], v.x) && holds(bounds[1], v.y) && holds(bounds[2], v.z);
}

}  // namespace nephele::test
