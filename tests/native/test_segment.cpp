// SPDX-License-Identifier: GPL-3.0-or-later
// Which media are where along a ray: the rule for crossings of meshes, and whole scenes asked through
// find_media.
#include <gtest/gtest.h>

#include <array>

#include "math/sampler.h"
#include "math/warp.h"
#include "scene_fixtures.h"

namespace nephele::test {
namespace {

constexpr float kEnd = 100;

/// Intervals of one medium for crossings (t, sign) along [t_min, t_max].
std::vector<std::pair<float, float>> intervals(std::vector<Crossing> crossings, float t_min = 0,
                                               float t_max = kEnd) {
    const Medium medium;
    Segment segment;
    segment.ray = {{0, 0, 0}, {0, 0, 1}, t_min, t_max};
    for_each_stay(crossings.data(), crossings.data() + crossings.size(),
                  [&](const Crossing* entry, const Crossing* exit) {
                      add_intervals(&medium, &medium + 1, entry ? entry->t : t_min,
                                    exit ? exit->t : kInfinity, segment);
                  });
    std::vector<std::pair<float, float>> out;
    for (const Interval& i : segment.intervals)
        out.emplace_back(i.t0, i.t1);
    return out;
}

using Spans = std::vector<std::pair<float, float>>;
Crossing in(float t) {
    return {t, 0, 1};
}
Crossing out(float t) {
    return {t, 0, -1};
}

TEST(MeshIntervals, OfAClosedMeshSeenFromOutsideAndInside) {
    EXPECT_EQ(intervals({}), Spans{});
    EXPECT_EQ(intervals({in(2), out(5)}), (Spans{{2, 5}}));
    EXPECT_EQ(intervals({out(5)}), (Spans{{0, 5}}));
    EXPECT_EQ(intervals({out(5), in(7), out(9)}), (Spans{{0, 5}, {7, 9}}));
}

TEST(MeshIntervals, EndWithTheRay) {
    EXPECT_EQ(intervals({in(2), out(5)}, 0, 3), (Spans{{2, 3}}));
    EXPECT_EQ(intervals({in(2), out(5)}, 0, 1), Spans{});
    EXPECT_EQ(intervals({out(50)}, 3, 20), (Spans{{3, 20}}));
    EXPECT_EQ(intervals({out(50)}, 3, kInfinity), (Spans{{3, 50}}));
}

TEST(MeshIntervals, CountNestedShellsAsOneMedium) {
    EXPECT_EQ(intervals({in(1), in(2), out(3), out(4)}), (Spans{{1, 4}}));
    EXPECT_EQ(intervals({out(3), out(4)}), (Spans{{0, 4}}));
    EXPECT_EQ(intervals({in(1), out(2), in(3), out(4)}), (Spans{{1, 2}, {3, 4}}));  // a hollow shell
    EXPECT_EQ(intervals({out(2), in(3), out(4)}), (Spans{{0, 2}, {3, 4}}));         // seen from its wall
}

TEST(MeshIntervals, OfOpenMeshesStartAtFrontsAndEndAtBacks) {
    EXPECT_EQ(intervals({in(2)}), (Spans{{2, kEnd}}));
    EXPECT_EQ(intervals({out(2)}), (Spans{{0, 2}}));
}

TEST(MeshIntervals, CountPartsOfAMeshThatOverlap) {
    EXPECT_EQ(intervals({in(2), in(2), out(5), out(7)}), (Spans{{2, 7}}));  // two parts share a face
    EXPECT_EQ(intervals({in(2), in(2), out(5), out(5)}), (Spans{{2, 5}}));
    EXPECT_EQ(intervals({out(5), out(5)}), (Spans{{0, 5}}));
    EXPECT_EQ(intervals({in(2), out(2), out(4)}), (Spans{{0, 4}}));  // parts that abut
    EXPECT_EQ(intervals({in(1), in(2), out(2), out(4)}), (Spans{{1, 4}}));
    EXPECT_EQ(intervals({in(2), out(2)}), Spans{});
}

/// Length of the media along a ray, and their number.
struct Found {
    double length = 0;
    std::size_t count = 0;
};
Found media_along(const Scene& scene, Vec3f o, Vec3f d, float t_max = kInfinity) {
    Segment segment;
    scene.find_media({o, d, 0, t_max}, kCameraRay, segment);
    Found found;
    for (const Interval& i : segment.intervals)
        found.length += double{i.t1} - double{i.t0};
    found.count = segment.intervals.size();
    return found;
}

/// Length of a ray inside a box.
double chord(Vec3f o, Vec3f d, double half) {
    double t0 = 0, t1 = 1e30;
    for (int a = 0; a < 3; ++a) {
        if (d[a] == 0 && std::fabs(double{o[a]}) > half)
            return 0;
        if (d[a] == 0)
            continue;
        const double x = (-half - double{o[a]}) / double{d[a]}, y = (half - double{o[a]}) / double{d[a]};
        t0 = std::max(t0, std::min(x, y));
        t1 = std::min(t1, std::max(x, y));
    }
    return std::max(0.0, t1 - t0);
}

TEST(FindMedia, InABoxMatchesItsChordFromInsideAndOutside) {
    for (const Vec3f scale : {Vec3f(1), Vec3f(-1, 1, 1), Vec3f(-1, -1, -1)}) {  // mirrored, too
        const Scene scene(fog_in(box_mesh(Vec3f(-1), Vec3f(1)), scale));
        Rng rng(3);
        for (int n = 0; n < 20000; ++n) {
            const Vec3f o = (rng.next3() - Vec3f(0.5f)) * 5.0f;
            const Vec3f d = normalize(sample_sphere(rng.next2()));
            const Found found = media_along(scene, o, d);
            ASSERT_NEAR(found.length, chord(o, d, 1), 1e-4) << o.x << ' ' << o.y << ' ' << o.z;
            ASSERT_LE(found.count, 1u);
        }
    }
}

/// Whether the media along the ray are those of a ray no further away than kAside, in a box.
constexpr double kAside = 2e-6;
bool right_in_box(const Scene& scene, Vec3f o, Vec3f d) {
    const Found found = media_along(scene, o, d);
    return found.count <= 1 && found.length >= chord(o, d, 1 - kAside) - kAside &&
           found.length <= chord(o, d, 1 + kAside) + kAside;
}

TEST(FindMedia, SurvivesRaysThroughEdgesCornersAndDiagonals) {
    const Scene scene(fog_in(box_mesh(Vec3f(-1), Vec3f(1))));
    enum { diagonal, edge, corner, kinds };
    int wrong[kinds] = {};
    Rng rng(5);
    for (int n = 0; n < 60000; ++n) {
        const float s = 2 * rng.next() - 1;
        const Vec3f target = n % kinds == diagonal ? Vec3f(s, -s, 1)
                             : n % kinds == edge   ? Vec3f(1, s, 1)
                                                   : Vec3f(1, -1, 1);
        const Vec3f o = target + sample_sphere(rng.next2()) * 3.0f;
        wrong[n % kinds] += !right_in_box(scene, o, normalize(target - o));
    }
    for (const int n : wrong)
        EXPECT_EQ(n, 0);
    for (float s = -0.9f; s < 1; s += 0.1f)  // exactly parallel to an axis
        EXPECT_NEAR(media_along(scene, {s, -s, 5}, {0, 0, -1}).length, 2, 1e-4);
}

/// Length of a ray inside a convex body of triangles whose planes are moved outwards.
double convex_chord(const Mesh& mesh, const Transform& world_from_object, Vec3f o, Vec3f d, double outwards) {
    using D3 = std::array<double, 3>;
    const auto minus = [](Vec3f a, Vec3f b) {
        return D3{double{a.x} - double{b.x}, double{a.y} - double{b.y}, double{a.z} - double{b.z}};
    };
    const auto product = [](const D3& a, const D3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    double t0 = 0, t1 = 1e30;
    for (std::uint32_t k = 0; k < mesh.triangle_count(); ++k) {
        Vec3f v[3];
        for (int i = 0; i < 3; ++i)
            v[i] = world_from_object.point(mesh.vertex(k, i));
        const D3 e = minus(v[1], v[0]), f = minus(v[2], v[0]);
        D3 n{e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
        const double scale = std::copysign(1 / std::sqrt(product(n, n)), world_from_object.determinant());
        const double height = product(n, minus(v[0], o)) * scale + outwards,
                     slope = product(n, minus(d, Vec3f(0))) * scale;
        if (slope == 0 && height < 0)
            return 0;
        if (slope > 0)
            t1 = std::min(t1, height / slope);
        if (slope < 0)
            t0 = std::max(t0, height / slope);
    }
    return std::max(0.0, t1 - t0);
}

TEST(FindMedia, SurvivesRaysThroughTheVerticesOfABallHoweverItIsPlaced) {
    for (const Vec3f scale : {Vec3f(1), Vec3f(-2, 1, 0.5f)}) {
        for (const bool shared : {false, true}) {
            SceneSource source = fog_in(ball_mesh(12, 24), scale);
            if (shared) {  // a second instance, out of the way, makes both of them Embree's
                source.instances.push_back(instance_of(0, Vec3f(1), {0, 0, 100}));
                source.instances.back().materials = {0};
            }
            const Mesh mesh = source.meshes[0];
            const Transform place = source.instances[0].world_from_object;
            const Scene scene(std::move(source));
            Rng rng(6);
            int wrong = 0;
            for (int n = 0; n < 10000; ++n) {
                const auto triangle =
                    static_cast<std::uint32_t>(rng.next() * static_cast<float>(mesh.triangle_count()));
                const Vec3f v = place.point(mesh.vertex(triangle, 0)),
                            w = place.point(mesh.vertex(triangle, 1));
                const Vec3f target = n % 2 == 0 ? v : lerp(v, w, rng.next());
                const Vec3f o = target + sample_sphere(rng.next2()) * 3.0f, d = normalize(target - o);
                const Found found = media_along(scene, o, d, 50);
                wrong +=
                    !(found.count <= 1 && found.length >= convex_chord(mesh, place, o, d, -kAside) - kAside &&
                      found.length <= convex_chord(mesh, place, o, d, kAside) + kAside);
            }
            EXPECT_EQ(wrong, 0) << scale.x << ' ' << shared;
        }
    }
}

TEST(FindMedia, OfCoincidentFacesAbutsAndOfOpenMeshesEndsAtBacks) {
    // Two boxes side by side, of one mesh and of two: no gap, nothing twice.
    const Mesh left = box_mesh(Vec3f(-1), Vec3f(0.1f, 1, 1)), right = box_mesh({0.1f, -1, -1}, Vec3f(1));
    SceneSource two = fog_in(left);
    two.meshes.push_back(right);
    two.instances.push_back(instance_of(1));
    two.instances.back().materials = {0};
    const Scene apart(std::move(two)), one(fog_in(joined(left, right)));
    Rng rng(8);
    for (int n = 0; n < 10000; ++n) {
        const Vec3f o = (rng.next3() - Vec3f(0.5f)) * 5.0f, d = sample_sphere(rng.next2());
        ASSERT_NEAR(media_along(apart, o, d).length, chord(o, d, 1), 1e-4);
        ASSERT_NEAR(media_along(one, o, d).length, chord(o, d, 1), 1e-4);
    }
    // A mesh twice in the same place is one region; two objects there are two media.
    const Mesh box = box_mesh(Vec3f(-1), Vec3f(1));
    const Scene twice(fog_in(joined(box, box)));
    EXPECT_NEAR(media_along(twice, {0.3f, 0.2f, 5}, {0, 0, -1}).length, 2, 1e-5);
    EXPECT_NEAR(media_along(twice, {0.3f, 0.2f, 0}, {0, 0, -1}).length, 1, 1e-5);
    // Parts of a mesh that overlap are one region.
    const Scene crossed(fog_in(joined(box, box_mesh(Vec3f(-0.5f), Vec3f(2)))));
    EXPECT_NEAR(media_along(crossed, {0.3f, 0.2f, 5}, {0, 0, -1}).length, 3, 1e-5);
    EXPECT_NEAR(media_along(crossed, {0.3f, 0.2f, 0}, {0, 0, -1}).length, 1, 1e-5);
    // A box without its lid, which faces z: from below it goes on, from above it is not entered.
    std::vector<std::int32_t> open(box.triangles.begin(), box.triangles.end());
    open.resize(open.size() - 6);
    const Scene bowl(fog_in(mesh_of("bowl", {box.positions.begin(), box.positions.end()}, open)));
    EXPECT_NEAR(media_along(bowl, {0.3f, 0.2f, -5}, {0, 0, 1}, 50).length, 46, 1e-4);
    EXPECT_NEAR(media_along(bowl, {0.3f, 0.2f, 5}, {0, 0, -1}, 50).length, 6, 1e-4);
    EXPECT_NEAR(media_along(bowl, {0.3f, 0.2f, -5}, {1, 0, 0}, 50).length, 0, 1e-5);
    EXPECT_NEAR(media_along(bowl, {-5, 0.2f, 0.3f}, {1, 0, 0}, 50).length, 2, 1e-5);
}

TEST(FindMedia, AddsUpInAnyNumber) {
    // Twenty balls of different size and place around a camera, and the world: optical depth in closed form,
    // up to the tessellation.
    SceneSource source = fog_in(ball_mesh(96, 192));
    source.world.volume.emplace_back().sigma_s = Rgb(0.01f);
    source.instances.clear();
    source.materials.clear();
    Rng rng(10);
    struct Ball {
        Vec3f c;
        float r, sigma;
    };
    std::vector<Ball> balls;
    for (int i = 0; i < 20; ++i) {
        const Ball ball{(rng.next3() - Vec3f(0.5f)) * 2.0f, 0.3f + 2 * rng.next(), 0.1f + rng.next()};
        balls.push_back(ball);
        source.instances.push_back(instance_of(0, Vec3f(i % 2 == 0 ? ball.r : -ball.r), ball.c));
        source.instances.back().materials = {i};
        Material fog;
        fog.name = "fog";
        fog.volume.emplace_back().sigma_s = Rgb(ball.sigma);
        source.materials.push_back(fog);
    }
    const Scene scene(std::move(source));
    for (int n = 0; n < 5000; ++n) {
        const Vec3f o = (rng.next3() - Vec3f(0.5f)) * 4.0f, d = normalize(sample_sphere(rng.next2()));
        const float end = 1 + 4 * rng.next();
        double expected = 0.01 * double{end}, found = 0;
        for (const Ball& b : balls) {
            const double m = -double{dot(o - b.c, d)},
                         h = double{b.r} * double{b.r} - double{dot(o - b.c, o - b.c)} + m * m;
            if (h > 0) {
                const double t0 = std::max(0.0, m - std::sqrt(h)),
                             t1 = std::min(double{end}, m + std::sqrt(h));
                expected += double{b.sigma} * std::max(0.0, t1 - t0);
            }
        }
        Segment segment;
        scene.find_media({o, d, 0, end}, kShadowRay, segment);
        for (const Interval& i : segment.intervals)
            found += double{i.medium->sigma_t.x} * (double{i.t1} - double{i.t0});
        ASSERT_NEAR(found, expected, 0.02 * expected + 0.05);
    }
}

TEST(FindMedia, OfNestedShellsLeavesTheHollowOut) {
    const Scene hollow(fog_in(joined(box_mesh(Vec3f(-2), Vec3f(2)), box_mesh(Vec3f(-1), Vec3f(1), true))));
    EXPECT_NEAR(media_along(hollow, {0.1f, 0.2f, 5}, {0, 0, -1}).length, 2, 1e-5);
    EXPECT_NEAR(media_along(hollow, {0.1f, 0.2f, 0}, {0, 0, -1}).length, 1, 1e-5);
    EXPECT_NEAR(media_along(hollow, {0.1f, 0.2f, 1.5f}, {0, 0, -1}).length, 1.5, 1e-5);
    const Scene doubled(fog_in(joined(box_mesh(Vec3f(-2), Vec3f(2)), box_mesh(Vec3f(-1), Vec3f(1)))));
    EXPECT_NEAR(media_along(doubled, {0.1f, 0.2f, 5}, {0, 0, -1}).length, 4, 1e-5);
}

TEST(FindMedia, SeesEachInstanceTheWorldAndWhatTheirVisibilityAllows) {
    SceneSource source = fog_in(box_mesh(Vec3f(-1), Vec3f(1)));
    source.instances.push_back(instance_of(0, {-1, 1, 1}, {0, 0, 1}));  // mirrored, overlapping
    source.instances.back().materials = {0};
    source.instances.back().visibility = kShadowRay;
    source.world.volume.emplace_back().sigma_s = Rgb(0.1f);
    const Scene scene(std::move(source));
    Segment segment;
    const Ray ray{{0.1f, 0.2f, 5}, {0, 0, -1}, 0, 10};
    scene.find_media(ray, kShadowRay, segment);
    ASSERT_EQ(segment.intervals.size(), 3u);  // the world and both boxes
    scene.find_media(ray, kCameraRay, segment);
    ASSERT_EQ(segment.intervals.size(), 2u);
    EXPECT_EQ(segment.intervals[0].t1, 10);
    EXPECT_NEAR(segment.intervals[1].t1 - segment.intervals[1].t0, 2, 1e-5);
}

}  // namespace
}  // namespace nephele::test
