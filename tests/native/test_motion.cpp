// SPDX-License-Identifier: GPL-3.0-or-later
// Placements over the shutter: turns and stretches between matrices, and that hierarchies and shading points
// agree on where a moving mesh is.
#include "math/motion.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "math/sampler.h"
#include "math/warp.h"
#include "scene_fixtures.h"

namespace nephele::test {
namespace {

using Matrix = std::array<double, 16>;

/// Turned about z, stretched along its own axes before, moved after.
Matrix posed(double angle, Vec3f scale, Vec3f move) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * double{scale.x},
            -s * double{scale.y},
            0,
            double{move.x},
            s * double{scale.x},
            c * double{scale.y},
            0,
            double{move.y},
            0,
            0,
            double{scale.z},
            double{move.z},
            0,
            0,
            0,
            1};
}

float difference(const Transform& a, const Transform& b) {
    float most = length(a.translation - b.translation);
    for (std::size_t r = 0; r < 3; ++r)
        most = std::max(most, length(a.row[r] - b.row[r]));
    return most;
}

Transform expected(const Matrix& m) {
    double copy[16];
    std::copy(m.begin(), m.end(), copy);
    return transform_of(copy);
}

TEST(Motion, KeepsMatricesThatOnlyMove) {
    const Matrix matrices[] = {posed(0.3, Vec3f(1, 2, 3), {0, 0, 0}), posed(0.3, Vec3f(1, 2, 3), {4, 2, 0}),
                               posed(0.3, Vec3f(1, 2, 5), {4, 2, 8})};
    const Motion motion(matrices);
    EXPECT_EQ(motion.steps().size(), 3u);
    EXPECT_LT(difference(motion.at(0.25f), expected(posed(0.3, Vec3f(1, 2, 3), {2, 1, 0}))), 1e-6f);
    EXPECT_LT(difference(motion.at(0.75f), expected(posed(0.3, Vec3f(1, 2, 4), {4, 2, 4}))), 1e-6f);
    EXPECT_LT(difference(motion.at(1), expected(matrices[2])), 1e-6f);
    EXPECT_LT(difference(motion.at(2), expected(matrices[2])), 1e-6f);
    EXPECT_FALSE(Motion().moves());
}

TEST(Motion, TurnsEvenlyBetweenMatrices) {
    for (const float mirror : {1.0f, -1.0f}) {
        const Vec3f before(1, 2, mirror), after(3, 2, mirror);
        const Matrix matrices[] = {posed(-1.2, before, {0, 0, 0}), posed(1.4, after, {1, 0, 0})};
        const Motion motion(matrices);
        EXPECT_GT(motion.steps().size(), 50u);
        EXPECT_LE(motion.steps().size(), kMaxMotionSteps);
        for (const float t : {0.0f, 0.1f, 0.37f, 0.5f, 0.93f, 1.0f}) {
            const Matrix there = posed(-1.2 + 2.6 * double{t}, lerp(before, after, t), {t, 0, 0});
            EXPECT_LT(difference(motion.at(t), expected(there)), 1e-3f) << "at " << t;
        }
    }
}

TEST(Motion, RefusesWhatCannotBe) {
    const Matrix good = posed(0, Vec3f(1), Vec3f(0));
    Matrix flat = good;
    flat[0] = 0;
    EXPECT_THROW(Motion(std::vector<Matrix>{good}), std::invalid_argument);
    EXPECT_THROW(Motion(std::vector<Matrix>(200, good)), std::invalid_argument);
    EXPECT_THROW(Motion(std::vector<Matrix>{good, flat}), std::invalid_argument);
}

/// A box that deforms into a larger one, placed by matrices that turn, stretch and mirror.
SceneSource moving_box(int copies) {
    const Mesh small = box_mesh(Vec3f(-1), Vec3f(1)), large = box_mesh(Vec3f(-1.5f), {1, 1.2f, 2});
    SceneSource source;
    Mesh mesh = small;
    std::vector<float> both(small.positions.begin(), small.positions.end());
    both.insert(both.end(), large.positions.begin(), large.positions.end());
    mesh.motion_positions = Buffer(both);
    mesh.motion_steps = 2;
    source.meshes.push_back(mesh);
    for (int i = 0; i < copies; ++i) {
        const Vec3f scale(1, i % 2 == 0 ? 1.0f : -1.0f, 1);
        const auto x = 6.0f * static_cast<float>(i);
        const Matrix matrices[] = {posed(0, scale, {x, 0, 0}), posed(1.5, scale * 0.8f, {x, 2, 1})};
        source.instances.push_back(instance_of(0, scale, {x, 0, 0}));
        source.instances.back().motion = Motion(matrices);
    }
    return source;
}

TEST(Motion, HitsLieWhereShadingPointsAre) {
    for (const int copies : {1, 3}) {
        const Scene scene(moving_box(copies));
        EXPECT_TRUE(scene.features().motion);
        Rng rng(11);
        int hits = 0, late = 0;
        for (int k = 0; k < 4000; ++k) {
            Ray ray;
            ray.time = rng.next();
            const auto number =
                std::min(copies - 1, static_cast<int>(rng.next() * static_cast<float>(copies)));
            const Vec3f target(6.0f * static_cast<float>(number) + 2 * rng.next() - 1, 3 * rng.next() - 0.5f,
                               rng.next());
            ray.d = sample_sphere(rng.next2());
            ray.o = target - ray.d * 30;
            const Hit hit = scene.intersect(ray, kCameraRay);
            if (!hit.valid())
                continue;
            ++hits;
            const ShadingPoint point = scene.shading_point(hit, ray, kCameraRay);
            ASSERT_LT(length(point.p - ray.at(hit.t)), 2e-4f) << "time " << ray.time;
            EXPECT_FALSE(point.backfacing);
            Ray still = ray;
            still.time = 0;
            const Hit before = scene.intersect(still, kCameraRay);
            late += !before.valid() || std::fabs(before.t - hit.t) > 1e-3f;
        }
        EXPECT_GT(hits, 2000);
        EXPECT_GT(late, hits / 2);  // it does move
    }
}

TEST(Motion, OfAMediumsBoundsMovesItsCrossings) {
    SceneSource source = fog_in(box_mesh(Vec3f(-1), Vec3f(1)));
    const Matrix matrices[] = {posed(0, Vec3f(1), {0, 0, 0}), posed(0, Vec3f(1), {0, 0, 8})};
    source.instances.front().motion = Motion(matrices);
    const Scene scene(std::move(source));
    for (const float time : {0.0f, 0.25f, 1.0f}) {
        Segment segment;
        scene.find_media({{0.1f, 0.2f, -5}, {0, 0, 1}, 0, kInfinity, time}, kCameraRay, segment);
        ASSERT_EQ(segment.intervals.size(), 1u);
        EXPECT_NEAR(segment.intervals[0].t0, 4 + 8 * time, 1e-5);
        EXPECT_NEAR(segment.intervals[0].t1, 6 + 8 * time, 1e-5);
    }
}

/// The two hierarchies, of surfaces and of media's bounds, have their own triangles.
TEST(Motion, IsTheSameForSurfacesAndBounds) {
    for (const int copies : {1, 3}) {
        const Scene solid(moving_box(copies));
        SceneSource source = moving_box(copies);
        source.materials = fog_in(box_mesh(Vec3f(-1), Vec3f(1))).materials;
        for (Instance& instance : source.instances)
            instance.materials = {0};
        const Scene fog(std::move(source));
        Rng rng(12);
        int hits = 0;
        for (int k = 0; k < 4000; ++k) {
            Ray ray;
            ray.time = rng.next();
            ray.d = sample_sphere(rng.next2());
            ray.o = Vec3f(2 * rng.next() - 1, 2 * rng.next() - 1, rng.next()) - ray.d * 40;
            const Hit hit = solid.intersect(ray, kCameraRay);
            Segment segment;
            fog.find_media(ray, kCameraRay, segment);
            if (!hit.valid() || segment.intervals.empty())
                continue;
            ++hits;
            float first = kInfinity;
            for (const Interval& i : segment.intervals) {
                first = std::min(first, i.t0);
                EXPECT_LT(i.t1, 100);  // closed meshes are left again
            }
            EXPECT_NEAR(first, hit.t, 1e-3);
        }
        EXPECT_GT(hits, 1500);
    }
}

}  // namespace
}  // namespace nephele::test
