// SPDX-License-Identifier: GPL-3.0-or-later
// Every operation of shading programs against values worked out by hand.
#include "grids/volume_fields.h"
#include "shading/program.h"

#include <gtest/gtest.h>

#include <set>
#include <string>
#include <vector>

#include "scene/mesh.h"
#include "shading/shading_inputs.h"
#include "surface_fixtures.h"

namespace nephele {
namespace {

Vec3f s(float v) {
    return Vec3f(v);
}

/// A triangle in an instance that is scaled by 2 and moved by (10, 20, 30), seen from above.
struct Fixture {
    Mesh mesh;
    Instance instance;
    std::vector<Image> images;
    ShadingPoint point;
    VolumeFields fields;  // a number and a vector that grow along x; their first voxel is at (10, 20, 30)
    TextureContext context;

    Fixture() {
        mesh.positions = Buffer(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0});
        mesh.triangles = Buffer(std::vector<std::int32_t>{0, 1, 2});
        mesh.uvs.push_back(Buffer(std::vector<float>{0, 0, 1, 0, 0, 1}));
        mesh.attributes.push_back(Buffer(std::vector<float>{1, 0, 0, 0, 0, 1, 0, 0.5f, 0, 0, 1, 1}));
        mesh.generated_min = {0, 0, 0};
        mesh.generated_size = {1, 1, 0};
        const double matrix[16] = {2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30, 0, 0, 0, 1};
        instance.world_from_object = transform_of(matrix);
        instance.object_from_world = inverse_of(matrix);
        instance.random = 0.75f;
        instance.color = {0.1f, 0.2f, 0.3f, 1};
        instance.pass_index = 7;
        instance.properties = {{0.1f, 0.2f, 0.3f, 0.4f}};

        point.instance = &instance;
        point.mesh = &mesh;
        point.barycentric = {0.25f, 0.5f, 0.25f};
        point.object_p = {0.5f, 0.25f, 0};
        point.p = {11, 20.5f, 30};
        point.ng = point.ns = {0, 0, 1};
        point.wo = normalize(Vec3f(1, 0, 1));
        point.ray_kind = kGlossyRay;
        point.history = RayHistory{.depth = 4, .diffuse = 1}.after(kGlossyRay, true);
        point.history.length = 2.5f;

        const auto ramp = [](float first) {
            const float values[8] = {first, first, first, first, first + 1, first + 1, first + 1, first + 1};
            return brick_grid_of_dense({0, 0, 0}, {2, 2, 2}, values);
        };
        const double moved[16] = {1, 0, 0, -10, 0, 1, 0, -20, 0, 0, 1, -30, 0, 0, 0, 1};
        const Transform index_from_world = transform_of(moved);
        VolumeField number, vector;
        number.components[0] = ramp(10);
        vector.components = {ramp(1), ramp(2), ramp(3)};
        number.index_from_world = vector.index_from_world = index_from_world;
        fields = VolumeFields({number, vector});
        point.volume = &fields;

        Image image;
        image.name = "two by one";
        image.width = 2;
        image.height = 1;
        image.floats = Buffer(std::vector<float>{1, 0, 0, 0.25f, 0, 1, 0, 0.75f});
        images.push_back(image);
        context.images = images;
        const double camera[16] = {1, 0, 0, -11, 0, 1, 0, -20.5,
                                   0, 0, 1, -40, 0, 0, 0, 1};  // 10 above the point
        context.camera_from_world = transform_of(camera);
        context.viewplane = {-1, 1, -1, 1};
    }

    /// Register 4 after one instruction on registers 0 to 3.
    Vec3f result(Op op, std::vector<Vec3f> operands, int mode, std::vector<float> parameters) const {
        Program program;
        operands.resize(4);
        program.registers = operands;
        program.registers.push_back(Vec3f(-99));
        program.code = {{static_cast<std::int32_t>(op), 4, 0, 1, 2, 3, 0, mode}};
        program.parameters = std::move(parameters);
        validate(program, images.size());
        return RegisterFile(program, point, context)[4];
    }
};

struct Row {
    Op op;
    std::vector<Vec3f> operands;
    Vec3f expected;
    int mode = 0;
    std::vector<float> parameters = {};
};

const std::vector<Row>& rows() {
    const Vec3f h = Vec3f(0.70710678f, 0, 0.70710678f);
    static const std::vector<Row> table = {
        {Op::uv, {}, {0.5f, 0.25f, 0}},
        {Op::uv, {}, s(0), 3},  // the mesh has no such map
        {Op::generated, {}, {0.5f, 0.25f, 0}},
        {Op::object_coordinate, {}, {0.5f, 0.25f, 0}},
        {Op::camera_coordinate, {}, {0, 0, 10}},
        {Op::window_coordinate, {}, {0.5f, 0.5f, 0}},
        {Op::position, {}, {11, 20.5f, 30}},
        {Op::normal, {}, {0, 0, 1}},
        {Op::normal_object, {}, {0, 0, 1}},
        {Op::geometric_normal, {}, {0, 0, 1}},
        {Op::incoming, {}, h},
        {Op::reflection, {}, {-h.x, 0, h.z}},
        {Op::backfacing, {}, s(0)},
        {Op::ray_is, {}, s(1), kGlossyRay | kDiffuseRay},
        {Op::ray_is, {}, s(0), kCameraRay},
        {Op::object_location, {}, {10, 20, 30}},
        {Op::object_color, {}, {0.1f, 0.2f, 0.3f}},
        {Op::object_random, {}, s(0.75f)},
        {Op::object_index, {}, s(7)},
        {Op::attribute, {}, {0.25f, 0.5f, 0.25f}},
        {Op::attribute, {}, s(0), 1},
        {Op::attribute_alpha, {}, s(0.5f)},
        {Op::object_alpha, {}, s(1)},
        {Op::object_attribute, {}, {0.1f, 0.2f, 0.3f}},
        {Op::object_attribute, {}, s(0), 1},
        {Op::object_attribute_alpha, {}, s(0.4f)},
        {Op::ray_history, {}, s(2.5f), 0},
        {Op::ray_history, {}, s(5), 1},
        {Op::ray_history, {}, s(1), 2},
        {Op::ray_history, {}, s(1), 3},
        {Op::ray_history, {}, s(0), 4},
        {Op::ray_history, {}, s(1), 6},
        {Op::parametric, {}, {0.25f, 0.5f, 0}},
        {Op::uv_tangent, {}, {1, 0, 0}},
        {Op::uv_tangent, {}, s(0), 3},
        // A step of 100 pixels, 0.01 m wide each, along (1, -1, 0) and (1, 1, 0).
        {Op::position, {}, {11.70710678f, 19.79289322f, 30}, kShift, {100}},
        {Op::position, {}, {11.70710678f, 21.20710678f, 30}, 2 * kShift, {100}},
        {Op::uv, {}, {0.85355339f, -0.10355339f, 0}, kShift, {100}},
        {Op::sphere_projection, {{0.5f, 0.5f, 1}}, {0, 1, 0}},
        {Op::sphere_projection, {{1, 0.5f, 0.5f}}, {0.25f, 0.5f, 0}},
        {Op::tube_projection, {{0.5f, 1, 0.3f}}, {0.5f, 0.3f, 0}},
        {Op::box_projection, {{0.2f, 0.3f, 0.4f}, {0, 0, 1}}, {0.7f, 0.2f, 1}, 2, {0}},
        {Op::box_projection, {{0.2f, 0.3f, 0.4f}, {-1, 0.9f, 0}}, {0.7f, 0.4f, 0.6315789f}, 0, {0.2f}},
        {Op::voronoi, {{1.25f, 2, 3}, s(1), {0, 0.5f, 2}, {1, 0, 0}}, s(0.25f)},  // points at the corners
        {Op::voronoi, {{0.5f, 1, 1.5f}, s(2), {0, 0.5f, 2}, {1, 0, 0}}, {0.5f, 1, 1.5f}, 2},
        {Op::white_noise, {{1, 2, 9}}, s(0.5404823f), 2},
        {Op::gabor, {s(INFINITY), s(1), s(1)}, s(0.5f)},
        {Op::brick, {{0.25f, 0.125f, 0}, {0.02f, 0, 1}, {0.5f, 0.25f, 0}}, {1, 1, 0}, 0, {0.5f, 1, 2, 2}},
        {Op::brick, {{0.5f, 0.125f, 0}, {0.02f, 0, 1}, {0.5f, 0.25f, 0}}, {1, 0, 0}, 0, {0.5f, 1, 2, 2}},
        {Op::convert_space, {{0.5f, 0.25f, 0}}, {11, 20.5f, 30}, 1},
        {Op::convert_space, {{0.5f, 0.25f, 0}}, {1, 0.5f, 0}, 1 | 1 << 4},
        {Op::convert_space, {{11, 20.5f, 30}}, {0, 0, 10}, 2 << 2},
        {Op::bump, {s(3), {1, 1, 0.5f}, {0, 0, 1}}, {0, 0, 1}},
        {Op::bump, {{0, 0.005f, 0}, {1, 1, 0.5f}, {0, 0, 1}}, {-0.5f, 0.5f, 0.70710678f}},
        {Op::bump, {{0, 0.005f, 0}, {0, 1, 0.5f}, {0, 0, 1}}, {0, 0, 1}},
        {Op::wireframe, {s(0.8f)}, s(1)},  // 0.354 m from the nearest edge
        {Op::wireframe, {s(0.6f)}, s(0)},
        {Op::wireframe, {s(80)}, s(1), 1},
        {Op::image, {{0.25f, 0.5f, 0}}, {1, 0, 0}, 0, {0}},
        {Op::image, {{0.5f, 0.5f, 0}}, {0.5f, 0.5f, 0}, 0, {0}},
        {Op::image, {{0.6f, 0.5f, 0}}, {0, 1, 0}, 1, {0}},                          // closest
        {Op::image, {{-0.25f, 0.5f, 0}}, {0, 1, 0}, 1, {0}},                        // repeat
        {Op::image, {{-0.25f, 0.5f, 0}}, {1, 0, 0}, 1 | 1 << 2, {0}},               // extend
        {Op::image, {{-0.25f, 0.5f, 0}}, s(0), 1 | 2 << 2, {0}},                    // clip
        {Op::image, {{-0.75f, 0.5f, 0}}, {0, 1, 0}, 1 | 3 << 2, {0}},               // mirror
        {Op::image, {{0.25f, 0.5f, 0}}, {5.0f / 6, 1.0f / 6, 0}, 2 | 1 << 2, {0}},  // cubic
        {Op::image_alpha, {{0.75f, 0.5f, 0}}, s(0.75f), 0, {0}},
        {Op::environment, {{0, 1, 0}}, {1, 0, 0}, 0, {0}},   // a quarter of the way: the first texel's centre
        {Op::environment, {{0, -5, 0}}, {0, 1, 0}, 0, {0}},  // any length
        {Op::environment_mirror_ball, {{1, 0, 0}}, {0, 1, 0}, 1, {0}},
        {Op::environment_mirror_ball, {{-1, 0, 0}}, {1, 0, 0}, 1, {0}},
        {Op::checker, {{0.1f, 0.1f, 0.1f}, s(1), s(0.5f), s(5)}, s(0.5f)},
        {Op::checker, {{0.3f, 0.1f, 0.1f}, s(1), s(0.5f), s(5)}, s(1)},
        {Op::checker_fac, {{-0.1f, 0.1f, 0.1f}, s(0), s(0), s(5)}, s(1)},
        {Op::noise,
         {{3, 5, 7}, s(1), {0, 0.5f, 2}, s(0)},
         s(0.5f),
         2},  // Perlin noise is 0 at lattice points
        {Op::noise, {{3, 5, 7}, s(1), {2, 0.5f, 2}, s(0)}, s(0), 4},
        {Op::grid, {{10.25f, 20, 30}}, s(10.25f), 0},
        {Op::grid, {{10.25f, 20, 30}}, {1.25f, 2.25f, 3.25f}, 1},
        {Op::grid, {{10.25f, 20, 30}}, s(0), 2},
        {Op::gradient, {{0.3f, 9, 9}}, s(0.3f), 0},
        {Op::ramp, {s(0.25f)}, {0.5f, 1, 2}, 2, {0, 1, 2, 1, 1, 2, 5, 5, 5}},
        {Op::ramp, {s(7)}, {5, 5, 5}, 2, {0, 1, 2, 1, 1, 2, 5, 5, 5}},
        {Op::ramp_alpha, {s(0.75f)}, s(0.5f), 2, {0, 1, 0}},
        {Op::ramp_alpha, {s(NAN)}, s(3), 1, {3, 4}},
        {Op::copy, {{1, 2, 3}}, {1, 2, 3}},
        {Op::add, {{1, 2, 3}, {4, 5, 6}}, {5, 7, 9}},
        {Op::subtract, {{1, 2, 3}, {4, 4, 4}}, {-3, -2, -1}},
        {Op::multiply, {{1, 2, 3}, {4, 5, 6}}, {4, 10, 18}},
        {Op::divide, {{1, 2, 3}, {4, 0, 2}}, {0.25f, 0, 1.5f}},
        {Op::multiply_add, {{1, 2, 3}, {2, 2, 2}, {1, 0, -1}}, {3, 4, 5}},
        {Op::power, {{2, -2, -2}, {3, 2, 0.5f}}, {8, 4, 0}},
        {Op::power, {{0, 0, 4}, {-1, 0, 0.5f}}, {0, 1, 2}},
        {Op::logarithm, {{8, -1, 8}, {2, 2, 1}}, {3, 0, 0}},
        {Op::sqrt, {{9, -1, 0}}, {3, 0, 0}},
        {Op::inverse_sqrt, {{4, -1, 0}}, {0.5f, 0, 0}},
        {Op::absolute, {{-4, 1, 0}}, {4, 1, 0}},
        {Op::exponent, {{0, 1, -1}}, {1, 2.7182818f, 0.36787944f}},
        {Op::minimum, {{1, 5, 0}, {2, 2, 2}}, {1, 2, 0}},
        {Op::maximum, {{1, 5, 0}, {2, 2, 2}}, {2, 5, 2}},
        {Op::less_than, {{1, 2, 3}, s(2)}, {1, 0, 0}},
        {Op::greater_than, {{1, 2, 3}, s(2)}, {0, 0, 1}},
        {Op::sign, {{-4, 0, 3}}, {-1, 0, 1}},
        {Op::compare, {{1, 2, 3}, s(2), s(1)}, {1, 1, 1}},
        {Op::compare, {{1, 2, 2.000001f}, s(2), s(0)}, {0, 1, 1}},
        {Op::smooth_min, {{1, 0, 5}, {1, 5, 0}, s(0.6f)}, {0.9f, 0, 0}},
        {Op::smooth_min, {{1, 0, 5}, {1, 5, 0}, s(0)}, {1, 0, 0}},
        {Op::smooth_max, {{1, 0, 5}, {1, 5, 0}, s(0.6f)}, {1.1f, 5, 5}},
        {Op::round, {{1.4f, 1.5f, -1.5f}}, {1, 2, -1}},
        {Op::floor, {{1.4f, -1.5f, 2}}, {1, -2, 2}},
        {Op::ceil, {{1.4f, -1.5f, 2}}, {2, -1, 2}},
        {Op::truncate, {{1.4f, -1.5f, 2}}, {1, -1, 2}},
        {Op::fraction, {{1.25f, -1.25f, 2}}, {0.25f, 0.75f, 0}},
        {Op::modulo, {{5, -5, 5}, {3, 3, 0}}, {2, -2, 0}},
        {Op::floored_modulo, {{5, -5, 5}, {3, 3, 0}}, {2, 1, 0}},
        {Op::wrap, {{5, -5, 1.5f}, {3, 3, 1}, {1, 1, 1}}, {1, 1, 1}},
        {Op::wrap, {{2.5f, 3.5f, 0.5f}, s(3), s(1)}, {2.5f, 1.5f, 2.5f}},
        {Op::snap, {{5, -5, 5}, {3, 3, 0}}, {3, -6, 0}},
        {Op::pingpong, {{0.25f, 1.25f, 5}, {1, 1, 0}}, {0.25f, 0.75f, 0}},
        {Op::sine, {{0, 1.5707963f, -1.5707963f}}, {0, 1, -1}},
        {Op::cosine, {{0, 3.1415927f, 0}}, {1, -1, 1}},
        {Op::tangent, {{0, 0.78539816f, 0}}, {0, 1, 0}},
        {Op::arcsine, {{0, 1, 2}}, {0, 1.5707963f, 1.5707963f}},
        {Op::arccosine, {{1, -1, -2}}, {0, 3.1415927f, 3.1415927f}},
        {Op::arctangent, {{0, 1, -1}}, {0, 0.78539816f, -0.78539816f}},
        {Op::arctan2, {{1, 1, 0}, {0, 1, -1}}, {1.5707963f, 0.78539816f, 3.1415927f}},
        {Op::sinh, {{0, 1, -1}}, {0, 1.1752012f, -1.1752012f}},
        {Op::cosh, {{0, 1, -1}}, {1, 1.5430806f, 1.5430806f}},
        {Op::tanh, {{0, 1, -1}}, {0, 0.76159416f, -0.76159416f}},
        {Op::clamp, {{-1, 0.5f, 2}, s(0), s(1)}, {0, 0.5f, 1}},
        {Op::mix, {{0, 1, 2}, s(4), {0.5f, 0, 1}}, {2, 1, 4}},
        {Op::map_range, {{1, 2, 3}, {1, 3, 0}, {10, 20, 0}}, {10, 15, 20}, 0},
        {Op::map_range, {{1.5f, 0, 9}, {1, 3, 0}, {0, 1, 0}}, {0.15625f, 0, 1}, 1},
        {Op::map_range, {{1.5f, 0, 9}, {1, 3, 0}, {0, 1, 0}}, {0.103515625f, 0, 1}, 2},
        {Op::map_range, {s(2), {3, 3, 0}, {7, 8, 0}}, s(7), 0},
        {Op::dot, {{1, 2, 3}, {4, 5, 6}}, s(32)},
        {Op::cross, {{1, 0, 0}, {0, 1, 0}}, {0, 0, 1}},
        {Op::length, {{3, 4, 0}}, s(5)},
        {Op::normalize, {{3, 4, 0}}, {0.6f, 0.8f, 0}},
        {Op::normalize, {s(0)}, s(0)},
        {Op::distance, {{1, 1, 1}, {4, 5, 1}}, s(5)},
        {Op::transform, {{1, 2, 3}}, {12, 24, 36}, 0, {2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30}},
        {Op::transform, {{1, 2, 3}}, {2, 4, 6}, 1, {2, 0, 0, 10, 0, 2, 0, 20, 0, 0, 2, 30}},
        {Op::channel, {{1, 2, 3}}, s(2), 1},
        {Op::combine, {s(1), s(2), s(3)}, {1, 2, 3}},
        {Op::average, {{1, 2, 6}}, s(3)},
        {Op::luminance, {{1, 1, 1}}, s(1)},
        {Op::luminance, {{0, 1, 0}}, s(0.7151522f)},
        {Op::rgb_to_hsv, {{0.5f, 0.25f, 0.25f}}, {0, 0.5f, 0.5f}},
        {Op::rgb_to_hsv, {{0.25f, 0.5f, 0.25f}}, {1.0f / 3, 0.5f, 0.5f}},
        {Op::hsv_to_rgb, {{2.0f / 3, 1, 0.5f}}, {0, 0, 0.5f}},
        {Op::hsv_to_rgb, {{1.0f / 6, 0.5f, 1}}, {1, 1, 0.5f}},
        {Op::rgb_to_hsl, {{0.75f, 0.25f, 0.25f}}, {0, 0.5f, 0.5f}},
        {Op::hsl_to_rgb, {{0, 0.5f, 0.5f}}, {0.75f, 0.25f, 0.25f}},
        {Op::hue_saturation, {{0.5f, 0.25f, 0.25f}, {0.5f, 1, 2}, s(1)}, {1, 0.5f, 0.5f}},
        {Op::hue_saturation, {{0.5f, 0.25f, 0.25f}, {1, 1, 1}, s(1)}, {0.25f, 0.5f, 0.5f}},
        {Op::hue_saturation, {{0.5f, 0.25f, 0.25f}, {0.5f, 0, 1}, s(0.5f)}, {0.5f, 0.375f, 0.375f}},
        {Op::bright_contrast, {{0.5f, 0, 1}, {0.1f, 7, 7}, {0.2f, 7, 7}}, {0.6f, 0, 1.2f}},
        {Op::gamma, {{4, -1, 0}, s(0.5f)}, {2, -1, 0}},
        {Op::invert, {{0.2f, 0, 1}, s(1)}, {0.8f, 1, 0}},
        {Op::invert, {{0.2f, 0, 1}, s(0.5f)}, s(0.5f)},
        // Recorded from Cycles 5.0's Blackbody node; to 0.2 %, see the tolerance below.
        {Op::blackbody, {s(1000)}, {4.6014f, 0.0390f, 0}},
        {Op::blackbody, {s(3000)}, {1.7708f, 0.8443f, 0.2722f}},
        {Op::blackbody, {s(6500)}, {1.0426f, 0.9841f, 1.0353f}},
        {Op::blackbody, {s(20000)}, {0.8263f, 0.9945f, 1.5663f}},
        {Op::fresnel, {s(1.5f), {0.70710678f, 0, 0.70710678f}}, s(0.04f)},
        {Op::layer_weight, {s(1.0f / 3), {0.70710678f, 0, 0.70710678f}}, s(0.04f), 0},
        {Op::layer_weight, {s(0.5f), {0, 0, 1}}, s(1 - 0.70710678f), 1},
        {Op::layer_weight, {s(0.75f), {0, 0, 1}}, s(0.5f), 1},
        {Op::normal_map, {{0.5f, 0.5f, 1}, s(1)}, {0, 0, 1}},
        {Op::normal_map, {{1, 0.5f, 0.5f}, s(1)}, {1, 0, 0}},
        {Op::normal_map, {{0.5f, 1, 0.5f}, s(1)}, {0, 1, 0}},
        {Op::normal_map, {{1, 0.5f, 1}, s(0)}, {0, 0, 1}},
        {Op::normal_map, {{1, 0.5f, 0.5f}, s(1)}, {0, 0, 1}, 5},  // no such UV map: the shading normal
    };
    return table;
}

/// Blend modes of 0.4 (red channel), 0.8 and 0 with 0.5, 0.1 and 0.6 by 0.5, from their definitions.
const std::vector<std::pair<BlendMode, Vec3f>> kBlends = {
    {BlendMode::mix, {0.45f, 0.45f, 0.3f}},
    {BlendMode::darken, {0.4f, 0.45f, 0}},
    {BlendMode::multiply, {0.3f, 0.44f, 0}},
    {BlendMode::burn, {0.2f, 0.6363636f, 0}},
    {BlendMode::lighten, {0.45f, 0.8f, 0.3f}},
    {BlendMode::screen, {0.55f, 0.81f, 0.3f}},
    {BlendMode::dodge, {0.5333333f, 0.8421053f, 0}},
    {BlendMode::add, {0.65f, 0.85f, 0.3f}},
    {BlendMode::overlay, {0.4f, 0.72f, 0}},
    {BlendMode::soft_light, {0.4f, 0.736f, 0}},
    {BlendMode::linear_light, {0.4f, 0.4f, 0.1f}},
    {BlendMode::difference, {0.25f, 0.75f, 0.3f}},
    {BlendMode::exclusion, {0.45f, 0.77f, 0.3f}},
    {BlendMode::subtract, {0.15f, 0.75f, -0.3f}},
    {BlendMode::divide, {0.6f, 4.4f, 0}},
    {BlendMode::hue, {0.52f, 0.4f, 0.4f}},
    {BlendMode::saturation, {0.4333333f, 0.8f, 0.0666667f}},
    {BlendMode::color, {0.5333333f, 0.4666667f, 0.4f}},
    {BlendMode::value, {0.35f, 0.7f, 0}},
};

void expect_near(Vec3f value, Vec3f expected, float tolerance, const std::string& what) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(value[c], expected[c], tolerance * (1 + std::fabs(expected[c])))
            << what << ", channel " << c;
    }
}

TEST(Program, OperationsGiveTheirDefinedValues) {
    const Fixture fixture;
    for (const Row& row : rows()) {
        const std::string name = kOpNames[static_cast<int>(row.op)];
        const float tolerance = row.op == Op::blackbody ? 2e-3f : 3e-6f;
        expect_near(fixture.result(row.op, row.operands, row.mode, row.parameters), row.expected, tolerance,
                    name + " mode " + std::to_string(row.mode));
    }
}

TEST(Program, EveryOperationAndBlendModeIsInTheTables) {
    std::set<Op> ops = {Op::blend};
    for (const Row& row : rows())
        ops.insert(row.op);
    EXPECT_EQ(ops.size(), static_cast<std::size_t>(kOpCount));
    std::set<BlendMode> modes;
    for (const auto& [mode, value] : kBlends)
        modes.insert(mode);
    EXPECT_EQ(modes.size(), static_cast<std::size_t>(kBlendModeCount));
}

TEST(Program, BlendModes) {
    const Fixture fixture;
    for (const auto& [mode, expected] : kBlends) {
        const Vec3f a(0.4f, 0.8f, 0), b(0.5f, 0.1f, 0.6f);
        const Vec3f value = fixture.result(Op::blend, {a, b, s(0.5f)}, static_cast<int>(mode), {});
        expect_near(value, expected, 2e-6f, "blend mode " + std::to_string(static_cast<int>(mode)));
        const Vec3f untouched = fixture.result(Op::blend, {a, b, s(0)}, static_cast<int>(mode), {});
        expect_near(untouched, a, 2e-6f, "by nothing, blend mode " + std::to_string(static_cast<int>(mode)));
    }
}

TEST(Program, BackFacesTurnNormalMapsAndIndices) {
    Fixture fixture;
    fixture.point.backfacing = true;  // ng and ns already face the viewer, the mesh's own normal is -z
    expect_near(fixture.result(Op::normal_map, {{0.5f, 0.5f, 1}, s(1)}, 0, {}), {0, 0, 1}, 1e-6f,
                "flat map from behind");
    expect_near(fixture.result(Op::backfacing, {}, 0, {}), s(1), 0, "backfacing");
    const Vec3f n = fixture.point.wo;
    expect_near(fixture.result(Op::fresnel, {s(1.5f), n}, 0, {}), s(0.04f), 1e-6f, "normal incidence");
    expect_near(fixture.result(Op::fresnel, {s(1.5f), {0, 0, 1}}, 0, {}), s(1), 1e-6f,
                "total reflection from inside");
}

TEST(Program, WorldHasDirectionsAndNoObject) {
    Fixture fixture;
    ShadingPoint world;
    const Vec3f d = normalize(Vec3f(1, 2, -2));
    world.p = world.object_p = world.ng = world.ns = d;
    world.wo = -d;
    fixture.point = world;
    expect_near(fixture.result(Op::generated, {}, 0, {}), d, 0, "generated");
    expect_near(fixture.result(Op::position, {}, 0, {}), d, 0, "position");
    for (const Op op : {Op::normal, Op::geometric_normal, Op::normal_object, Op::incoming, Op::reflection}) {
        expect_near(fixture.result(op, {}, 0, {}), -d, 0,
                    kOpNames[static_cast<int>(op)]);  // as Cycles 5.0 has it
    }
    expect_near(fixture.result(Op::window_coordinate, {}, 0, {}), {0.75f, 1, 0}, 1e-6f, "window");
    for (const Op op : {Op::uv, Op::attribute, Op::attribute_alpha, Op::object_location, Op::object_random,
                        Op::object_color, Op::object_index}) {
        expect_near(fixture.result(op, {}, 0, {}), s(0), 0, kOpNames[static_cast<int>(op)]);
    }
}

TEST(Program, InstructionsChainAndMayOverwriteTheirOperands) {
    const Fixture fixture;
    Program program;
    program.registers = {{1, 2, 3}, s(2)};
    const auto op = [](Op o, int dst, int a, int b) {
        return Instruction{static_cast<std::int32_t>(o), dst, a, b, 0, 0, 0, 0};
    };
    program.code = {op(Op::multiply, 0, 0, 1), op(Op::cross, 0, 0, 1), op(Op::add, 1, 0, 0)};
    validate(program, 0);
    const RegisterFile registers(program, fixture.point, fixture.context);
    expect_near(registers[0], {-4, 8, -4}, 0, "cross of (2,4,6) and (2,2,2)");
    expect_near(registers[1], {-8, 16, -8}, 0, "sum");
    expect_near(program.registers[0], {1, 2, 3}, 0, "the program itself stays as it is");
}

TEST(RayKinds, BitsFollowTheTable) {
    EXPECT_EQ(kRayKindCount, 6);
    EXPECT_STREQ(kRayKindNames[0], "camera");
    EXPECT_EQ(kCameraRay, 1u << 0);
    EXPECT_EQ(kDiffuseRay, 1u << 1);
    EXPECT_EQ(kGlossyRay, 1u << 2);
    EXPECT_EQ(kTransmissionRay, 1u << 3);
    EXPECT_EQ(kVolumeRay, 1u << 4);
    EXPECT_EQ(kShadowRay, 1u << 5);
    EXPECT_STREQ(kRayKindNames[5], "shadow");
}

}  // namespace
}  // namespace nephele
