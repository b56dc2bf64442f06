// SPDX-License-Identifier: GPL-3.0-or-later
// Ray queries: nearest hits of meshes and instances, faces seen from the front or back however they were
// placed, and filters that see every hit once.
#include "scene/intersector.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>

#include "math/sampler.h"
#include "math/warp.h"
#include "scene/crossings.h"
#include "scene_fixtures.h"

namespace nephele::test {
namespace {

/// Notes all hits and accepts none, or all from `accepted` on.
struct Collector final : HitFilter {
    std::vector<std::pair<Hit, bool>> hits;
    float accepted = kInfinity;

    bool accept(const Hit& hit, bool front) override {
        hits.emplace_back(hit, front);
        return hit.t >= accepted;
    }
};

struct World {
    std::vector<Mesh> meshes;
    std::vector<Instance> instances;

    Intersector build() const {
        std::vector<std::uint32_t> used;
        for (std::uint32_t i = 0; i < instances.size(); ++i)
            used.push_back(i);
        return {meshes, instances, used};
    }
};

TEST(Intersector, TestsItself) {
    EXPECT_NO_THROW(Intersector::self_test());
}

TEST(Intersector, ThatIsEmptyHitsNothing) {
    const Intersector nothing = World{}.build();
    EXPECT_TRUE(nothing.empty());
    EXPECT_FALSE(nothing.intersect({{0, 0, 0}, {0, 0, 1}}).valid());
    EXPECT_FALSE(nothing.occluded({{0, 0, 0}, {0, 0, 1}}));
}

TEST(Intersector, FindsTheNearestPointWithinTheRay) {
    World world{{box_mesh(Vec3f(-1), Vec3f(1))}, {instance_of(0)}};
    const Intersector scene = world.build();
    const Hit hit = scene.intersect({{0.3f, 0.2f, 5}, {0, 0, -1}});
    ASSERT_TRUE(hit.valid());
    EXPECT_NEAR(hit.t, 4, 1e-6);
    EXPECT_EQ(hit.instance, 0u);
    const Mesh& mesh = world.meshes[0];
    const Vec3f p = mesh.vertex(hit.triangle, 0) * (1 - hit.u - hit.v) +
                    mesh.vertex(hit.triangle, 1) * hit.u + mesh.vertex(hit.triangle, 2) * hit.v;
    EXPECT_NEAR(length(p - Vec3f(0.3f, 0.2f, 1)), 0, 1e-6);
    EXPECT_NEAR(scene.intersect({{0.3f, 0.2f, 5}, {0, 0, -1}, 4.5f}).t, 6, 1e-6);
    EXPECT_FALSE(scene.intersect({{0.3f, 0.2f, 5}, {0, 0, -1}, 0, 3.9f}).valid());
    EXPECT_TRUE(scene.occluded({{0.3f, 0.2f, 5}, {0, 0, -1}}));
    EXPECT_FALSE(scene.occluded({{0.3f, 0.2f, 5}, {0, 0, -1}, 4.5f, 5.5f}));
    EXPECT_GT(scene.bytes(), 0u);
}

TEST(Intersector, MeetsNothingAlongRaysThatAreNone) {
    World world{{box_mesh(Vec3f(-1), Vec3f(1))}, {instance_of(0)}};
    const Intersector scene = world.build();
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    for (const float bad : {kNan, kInfinity, -kInfinity, 1e30f, -1e19f}) {
        for (const Ray& ray : {Ray{{bad, 0, 0}, {0, 0, 1}}, Ray{{0, bad, 0}, {0, 0, 1}},
                               Ray{{0, 0, 0}, {0, 0, bad}}, Ray{{0, 0, 0}, {bad, 0, 1}}}) {
            EXPECT_FALSE(scene.intersect(ray).valid());
            EXPECT_FALSE(scene.occluded(ray));
        }
    }
    EXPECT_FALSE(scene.intersect({{0, 0, 0}, {0, 0, 1}, kNan}).valid());
    EXPECT_FALSE(scene.intersect({{0, 0, 0}, {0, 0, 1}, 0, kNan}).valid());
}

TEST(Intersector, WithWatertightFacesLeavesAClosedMeshAsOftenAsItEnters) {
    // Rays aimed at vertices, along edges and at points of edges, to the last bit, from near and far.
    for (const Vec3f scale : {Vec3f(1), Vec3f(-3, 1, 0.2f)}) {
        World world{{ball_mesh(12, 24)}, {instance_of(0, scale, {0.3f, -20, 7})}};
        const Intersector scene(world.meshes, world.instances, std::vector<std::uint32_t>{0},
                                Intersector::Faces::watertight);
        const Mesh& mesh = world.meshes[0];
        const Transform& place = world.instances[0].world_from_object;
        Rng rng(12);
        int wrong = 0, met = 0;
        for (int n = 0; n < 40000; ++n) {
            const auto face =
                static_cast<std::uint32_t>(rng.next() * static_cast<float>(mesh.triangle_count()));
            const Vec3f v = place.point(mesh.vertex(face, 0)), w = place.point(mesh.vertex(face, 1));
            const Vec3f target = n % 3 == 0 ? v : lerp(v, w, rng.next());
            const Vec3f away = n % 3 == 2 ? normalize(w - v) : sample_sphere(rng.next2());
            const Vec3f o = target + away * (n % 5 == 0 ? 1e5f : 10.0f);
            std::vector<Crossing> all;
            find_crossings(scene, world.instances, {o, normalize(target - o)}, kCameraRay, all);
            int net = 0;
            for (const Crossing& c : all)
                net += c.sign;
            wrong += net != 0;
            met += !all.empty();
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_GT(met, 10000);
    }
}

TEST(Intersector, PlacesInstancesThatShareAMeshAsItPlacesMeshesOfTheirOwn) {
    const Vec3f scales[] = {Vec3f(1), {-1, 1, 1}, {2, 0.5f, -1}, {-1, -2, -0.5f}};
    World shared{{box_mesh(Vec3f(-1), Vec3f(1))}, {}}, single;
    for (int i = 0; i < 4; ++i) {
        const Vec3f move(5.0f * static_cast<float>(i), 1, 0);
        shared.instances.push_back(instance_of(0, scales[i], move));
        single.meshes.push_back(shared.meshes[0]);
        single.instances.push_back(instance_of(static_cast<std::uint32_t>(i), scales[i], move));
    }
    const Intersector a = shared.build(), b = single.build();
    Rng rng(7);
    int hits = 0;
    for (int n = 0; n < 20000; ++n) {
        const Ray ray{{20 * rng.next() - 3, 8 * rng.next() - 3, 6},
                      normalize(sample_sphere(rng.next2()) + Vec3f(0, 0, -1.1f))};
        Collector x, y;
        const Hit one = a.intersect(ray), other = b.intersect(ray);
        ASSERT_EQ(one.valid(), other.valid());
        a.intersect(ray, &x);
        b.intersect(ray, &y);
        ASSERT_EQ(x.hits.size(), y.hits.size());
        if (!one.valid())
            continue;
        ++hits;
        ASSERT_EQ(one.instance, other.instance);
        ASSERT_NEAR(one.t, other.t, 1e-4);
        std::map<float, bool> fronts;  // by distance
        for (const auto& [hit, front] : x.hits)
            fronts[hit.t] = front;
        ASSERT_TRUE(fronts.begin()->second)
            << "the nearest face of a closed mesh seen from outside is a front";
        ASSERT_FALSE(fronts.rbegin()->second);
        for (const auto& [hit, front] : y.hits) {
            const auto at = fronts.lower_bound(hit.t - 1e-4f);
            ASSERT_TRUE(at != fronts.end() && std::fabs(at->first - hit.t) < 2e-4f && at->second == front);
        }
    }
    EXPECT_GT(hits, 1000);
}

TEST(Intersector, FiltersSeeEachHitOnce) {
    std::vector<float> positions;
    std::vector<std::int32_t> triangles;
    constexpr int kSheets = 500;
    for (int i = 0; i < kSheets; ++i) {
        const auto z = static_cast<float>(i);
        positions.insert(positions.end(), {-1, -1, z, 3, -1, z, -1, 3, z});
        triangles.insert(triangles.end(), {3 * i, 3 * i + 1, 3 * i + 2});
    }
    const World world{{mesh_of("sheets", positions, triangles)}, {instance_of(0)}};
    const Intersector scene = world.build();
    for (const bool shadow : {false, true}) {
        Collector all;
        const Ray ray{{0, 0, -1}, {0, 0, 1}};
        if (shadow) {
            EXPECT_FALSE(scene.occluded(ray, &all));
        } else {
            EXPECT_FALSE(scene.intersect(ray, &all).valid());
        }
        std::map<std::uint32_t, int> seen;
        for (const auto& [hit, front] : all.hits) {
            ++seen[hit.triangle];
            EXPECT_FALSE(front);  // from below
            EXPECT_NEAR(hit.t, static_cast<float>(hit.triangle) + 1, 1e-3);
        }
        EXPECT_EQ(seen.size(), std::size_t{kSheets});
        EXPECT_EQ(all.hits.size(), std::size_t{kSheets});
    }
    Collector some;
    some.accepted = 100.5f;
    EXPECT_NEAR(scene.intersect({{0, 0, -1}, {0, 0, 1}}, &some).t, 101, 1e-3);
}

TEST(Intersector, HoldsManyInstancesOfOneMesh) {
    World world{{box_mesh(Vec3f(-0.4f), Vec3f(0.4f))}, {}};
    for (int i = 0; i < 20000; ++i) {
        world.instances.push_back(instance_of(
            0, Vec3f(1),
            {static_cast<float>(i % 100), static_cast<float>(i / 100 % 100), static_cast<float>(i / 10000)}));
    }
    const Intersector scene = world.build();
    for (int i = 0; i < 10000; ++i) {
        const Hit hit = scene.intersect(
            {{static_cast<float>(i % 100) + 0.1f, static_cast<float>(i / 100) - 0.2f, -5}, {0, 0, 1}});
        ASSERT_EQ(hit.instance, static_cast<std::uint32_t>(i));
    }
}

}  // namespace
}  // namespace nephele::test
