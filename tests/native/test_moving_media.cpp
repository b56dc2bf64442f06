// SPDX-License-Identifier: GPL-3.0-or-later
// Media that an object carries along: rest rays, and the bounds of programs over all times of the shutter.
#include <gtest/gtest.h>

#include "bounds_fixtures.h"
#include "media/program_medium.h"
#include "media/segment.h"

namespace nephele::test {
namespace {

/// Turned about z by an angle, stretched along x before, moved after.
std::array<double, 16> posed(double angle, double stretch, double x, double z) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * stretch, -s, 0, x, s * stretch, c, 0, 0, 0, 0, 1, z, 0, 0, 0, 1};
}

Instance moving_instance() {
    Instance instance;
    const std::array<double, 16> steps[] = {posed(0.2, 1, -1, 0), posed(0.8, 2, 1, 0.5), posed(1, 1.5, 3, 1)};
    instance.motion = Motion(steps);
    double now[16];
    std::copy(steps[0].begin(), steps[0].end(), now);
    instance.world_from_object = transform_of(now);
    instance.object_from_world = inverse_of(now);
    return instance;
}

float distance_of(Vec3f a, Vec3f b) {
    return length(a - b);
}

TEST(RestRay, SeesTheObjectWhereItStandsAtTheFrame) {
    const Instance instance = moving_instance();
    Random random(1);
    for (int k = 0; k < 200; ++k) {
        const Ray ray{random.vector(-5, 5), normalize(random.vector(-1, 1) + Vec3f(1e-3f)), 0.5f, 7,
                      random.unit()};
        const RestRay rest(instance, ray);
        EXPECT_EQ(rest.ray.t_min, ray.t_min);
        EXPECT_EQ(rest.ray.t_max, ray.t_max);
        // A point of the object, seen on the ray at its time, is the same point of it at rest.
        const float t = random.between(0, 7);
        const Vec3f in_object = inverse_of(instance.motion.at(ray.time)).point(ray.at(t));
        EXPECT_LT(distance_of(rest.ray.at(t), instance.world_from_object.point(in_object)), 2e-5f);
        EXPECT_LT(distance_of(rest.rest_from_world.point(ray.at(t)), rest.ray.at(t)), 2e-5f);
    }
}

/// A medium that absorbs by the size of what an operation gives.
Program absorbing(std::vector<Instruction> code) {
    const auto op = [](Op o) { return static_cast<std::int32_t>(o); };
    Program program;
    program.registers = {Vec3f(0), Vec3f(1), {}, {}, Vec3f(0.3f)};
    program.code = std::move(code);
    program.code.push_back({op(Op::absolute), 2, 2});
    ClosureRow row;
    row.kind = ClosureKind::medium;
    row.weight = 1;
    row.inputs = {0, 2, 0, 0, 0};
    program.closures = {row};
    return program;
}

/// One grid at rest: a ramp, and its filter's bounds.
VolumeField ramp_of_8() {
    std::vector<float> voxels;
    for (int z = 0; z < 8; ++z) {
        for (int y = 0; y < 8; ++y) {
            for (int x = 0; x < 8; ++x)
                voxels.push_back(static_cast<float>(x + 2 * y + 3 * z));
        }
    }
    VolumeField field;
    field.components[0] = brick_grid_of_dense({-4, -4, -4}, {8, 8, 8}, voxels.data());
    field.bounds[0] = std::make_shared<CellBounds>(CellBounds::of_grid(*field.components[0], field.filter));
    return field;
}

TEST(MovingMedium, BoundsHoldAtAllTimes) {
    const auto op = [](Op o) { return static_cast<std::int32_t>(o); };
    const std::vector<std::vector<Instruction>> programs = {
        {{op(Op::position), 2}},
        {{op(Op::object_coordinate), 2}},
        {{op(Op::generated), 2}},
        {{op(Op::camera_coordinate), 2}},
        {{op(Op::object_location), 2}},
        {{op(Op::position), 3}, {op(Op::grid), 2, 3}},
        {{op(Op::position), 3}, {op(Op::add), 3, 3, 4}, {op(Op::grid), 2, 3}},  // read elsewhere
    };
    const Instance instance = moving_instance();
    Volume volume;  // a camera and images
    ShadingPoint place;
    place.instance = &instance;
    place.mesh = &volume.mesh;
    Random random(2);
    for (const auto& code : programs) {
        const ProgramMedium medium(absorbing(code), nullptr, VolumeFields({ramp_of_8()}), 1, place,
                                   volume.context, volume.image_bounds);
        for (int k = 0; k < 200; ++k) {
            const Vec3f lo = random.vector(-4, 3), hi = lo + random.vector(0, 1);
            const MediumRange range = medium.range(lo, hi);
            for (int sample = 0; sample < 20; ++sample) {
                const float time = random.unit();
                const Transform rest_from_world =
                    instance.world_from_object * inverse_of(instance.motion.at(time));
                const Vec3f at_rest = lo + (hi - lo) * random.vector(0.01f, 0.99f);
                const Vec3f p = inverse_of(rest_from_world).point(at_rest);
                const Rgb sigma_t =
                    medium.coefficients({p, Vec3f(0, 0, 1), kCameraRay, time, &rest_from_world}).sigma_t;
                ASSERT_LE(max_component(sigma_t), range.sigma_t_max + 1e-4f) << kOpNames[code.back().op];
                ASSERT_GE(min_component(sigma_t), range.sigma_t_min - 1e-4f) << kOpNames[code.back().op];
            }
        }
    }
}

/// A grid moves with its box: its bounds do not know of the way.
TEST(MovingMedium, BoundsOfAGridAreAsTightAsAtRest) {
    const auto op = [](Op o) { return static_cast<std::int32_t>(o); };
    const Program program = absorbing({{op(Op::position), 3}, {op(Op::grid), 2, 3}});
    const Instance moving = moving_instance();
    Instance still = moving;
    still.motion = {};
    Volume volume;
    const auto range_of = [&](const Instance& instance) {
        ShadingPoint place;
        place.instance = &instance;
        const ProgramMedium medium(program, nullptr, VolumeFields({ramp_of_8()}), 1, place, volume.context,
                                   volume.image_bounds);
        return medium.range({-2, -2, -2}, {-1, -1, -1});
    };
    EXPECT_EQ(range_of(moving).sigma_t_max, range_of(still).sigma_t_max);
    EXPECT_EQ(range_of(moving).sigma_t_min, range_of(still).sigma_t_min);
    EXPECT_LT(range_of(still).sigma_t_max, 30);  // of 42 in the whole grid
}

}  // namespace
}  // namespace nephele::test
