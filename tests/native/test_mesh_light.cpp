// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/mesh_light.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "cell_counts.h"
#include "math/sampler.h"
#include "math/warp.h"

namespace nephele::test {
namespace {

constexpr double kPid = 3.14159265358979323846;

Mesh mesh_of(std::vector<float> positions, std::vector<std::int32_t> triangles) {
    Mesh m;
    m.name = "mesh";
    m.positions = Buffer<float>(std::move(positions));
    m.triangles = Buffer<std::int32_t>(std::move(triangles));
    return m;
}
Instance instance_of(const double (&world_from_object)[16]) {
    Instance i;
    i.name = "lamp shade";
    i.world_from_object = transform_of(world_from_object);
    i.object_from_world = inverse_of(world_from_object);
    i.materials = {0};
    return i;
}
constexpr double kIdentity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr double kShearedMirror[16] = {-2, 0.5, 0, 0.3, 0, 1, 0.2, 0, 0, 0, 1.5, 0.5, 0, 0, 0, 1};

/// A tetrahedron, its corners in no special position.
Mesh tetrahedron() {
    return mesh_of({0, 0, 2, 1, 0.1f, 2.2f, 0.2f, 0.9f, 1.8f, 0.3f, 0.4f, 3},
                   {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3});
}

/// Irradiance by light samples of a light of radiance 1, which nothing occludes.
struct Estimate {
    double mean, error;
};
Estimate irradiance(const MeshLight& light, Vec3f p, Vec3f n, int draws, std::uint64_t seed) {
    Rng rng(seed);
    double sum = 0, sum2 = 0;
    for (int i = 0; i < draws; ++i) {
        const float u = rng.next();
        const auto s = light.sample(p, u, rng.next2());
        const double value = s ? std::max(0.0, double{dot(n, s->light.wi)}) / double{s->light.pdf} : 0;
        sum += value;
        sum2 += value * value;
    }
    const double mean = sum / draws;
    return {mean, std::sqrt(std::max(0.0, sum2 / draws - mean * mean) / draws)};
}

/// Of a triangle of radiance 1 above the horizon (Lambert 1760), in double.
double triangle_irradiance(Vec3f p, Vec3f n, Vec3f a, Vec3f b, Vec3f c) {
    const Vec3f v[3] = {a - p, b - p, c - p};
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
        const Vec3f e = v[i], f = v[(i + 1) % 3];
        const double x = double{e.y} * f.z - double{e.z} * f.y, y = double{e.z} * f.x - double{e.x} * f.z,
                     z = double{e.x} * f.y - double{e.y} * f.x;
        const double l = std::sqrt(x * x + y * y + z * z),
                     cosine = double{e.x} * f.x + double{e.y} * f.y + double{e.z} * f.z;
        sum += std::atan2(l, cosine) * (x * double{n.x} + y * double{n.y} + z * double{n.z}) / l;
    }
    return std::fabs(sum) / 2;
}
double mesh_irradiance(const Mesh& mesh, const Instance& instance, Vec3f p, Vec3f n) {
    double sum = 0;
    const Transform& m = instance.world_from_object;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        sum += triangle_irradiance(p, n, m.point(mesh.vertex(t, 0)), m.point(mesh.vertex(t, 1)),
                                   m.point(mesh.vertex(t, 2)));
    }
    return sum;
}

TEST(MeshLight, IrradianceOfATetrahedron) {  // both sides of every face count
    const Mesh mesh = tetrahedron();
    for (const Instance& instance : {instance_of(kIdentity), instance_of(kShearedMirror)}) {
        const MeshLight light(mesh, instance, std::vector<float>{1, 2, 0.5f, 3});
        for (const Vec3f p : {Vec3f(0.3f, 0.3f, 0), Vec3f(-0.2f, 0.4f, 1.5f), Vec3f(3, -5, -40)}) {
            const Vec3f n = normalize(Vec3f(0.1f, 0.2f, 1));
            const Estimate e = irradiance(light, p, n, 100000, 1);
            EXPECT_NEAR(e.mean, mesh_irradiance(mesh, instance, p, n), 6 * e.error + 1e-4 * e.mean);
        }
    }
}

TEST(MeshLight, SampleAndPdfAgree) {
    const Mesh mesh = tetrahedron();
    const Instance instance = instance_of(kShearedMirror);
    const MeshLight light(mesh, instance, std::vector<float>{1, 0, 0.5f, 3});
    Rng rng(2);
    for (int i = 0; i < 20000; ++i) {
        const Vec3f p = sample_sphere(rng.next2()) * std::pow(10.0f, 3 * rng.next() - 1) + Vec3f(0, 0, 2);
        const auto s = light.sample(p, rng.next(), rng.next2());
        if (!s)
            continue;
        EXPECT_NE(s->triangle, 1u) << "it does not emit";
        EXPECT_NEAR(light.pdf(s->triangle, p, s->p), s->light.pdf, 2e-3f * s->light.pdf);
        EXPECT_LT(length(p + s->light.wi * s->light.distance - s->p),
                  1e-5f * length(s->p) + 1e-5f * length(p));
        const Transform& m = instance.world_from_object;
        const Vec3f a = m.point(mesh.vertex(s->triangle, 0)), b = m.point(mesh.vertex(s->triangle, 1)),
                    c = m.point(mesh.vertex(s->triangle, 2));
        EXPECT_LT(length(a * s->barycentric.x + b * s->barycentric.y + c * s->barycentric.z - s->p), 1e-4f);
        EXPECT_NEAR(length(s->ng), 1, 1e-5);
        EXPECT_NEAR(dot(s->ng, b - a), 0, 1e-5);
        EXPECT_GT(light.importance(p), 0);
    }
    EXPECT_EQ(light.pdf(1, {}, {0.1f, 0.1f, 2}), 0);
}

TEST(MeshLight, NormalsFollowTheObjectsOrder) {
    // Counterclockwise from above; the mirror turns the order of corners in the world but not the face's
    // outside.
    const Mesh mesh = mesh_of({0, 0, 0, 1, 0, 0, 0, 1, 0}, {0, 1, 2});
    const double mirror[16] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const Instance plain = instance_of(kIdentity), mirrored = instance_of(mirror);
    EXPECT_EQ(MeshLight(mesh, plain, std::vector<float>{1}).sample({0, 0, 3}, 0.5f, {0.5f, 0.5f})->ng,
              Vec3f(0, 0, 1));
    EXPECT_EQ(MeshLight(mesh, mirrored, std::vector<float>{1}).sample({0, 0, 3}, 0.5f, {0.5f, 0.5f})->ng,
              Vec3f(0, 0, 1));
}

/// Cells over a triangle: s = b1 + b2, t = b2 / s; the area per unit of (s, t) is 2 s times the triangle's.
double triangle_agreement(Vec3f p, std::uint64_t seed) {
    const Mesh mesh = mesh_of({0, 0, 2, 1, 0.2f, 2.1f, 0.1f, 1.5f, 1.7f}, {0, 1, 2});
    const Instance instance = instance_of(kIdentity);
    const MeshLight light(mesh, instance, std::vector<float>{1});
    const Vec3f a = mesh.vertex(0, 0), b = mesh.vertex(0, 1), c = mesh.vertex(0, 2), n = cross(b - a, c - a);
    constexpr int kCells = 10, kSub = 24, kDraws = 300000;
    std::vector<double> expected(kCells * kCells);
    for (int i = 0; i < kCells * kSub; ++i) {
        for (int j = 0; j < kCells * kSub; ++j) {
            constexpr float h = 1.0f / (kCells * kSub);
            const float s = (static_cast<float>(i) + 0.5f) * h, t = (static_cast<float>(j) + 0.5f) * h;
            const Vec3f q = a + (b - a) * (s * (1 - t)) + (c - a) * (s * t), v = q - p;
            const double to_angle = std::fabs(double{dot(n, v)}) / std::pow(double{length(v)}, 3);
            expected[static_cast<std::size_t>(i / kSub * kCells + j / kSub)] +=
                double{h * h * s} * to_angle * double{light.pdf(0, p, q)};
        }
    }
    std::vector<std::uint64_t> counts(expected.size());
    Rng rng(seed);
    for (int i = 0; i < kDraws; ++i) {
        const auto sample = light.sample(p, rng.next(), rng.next2());
        if (!sample)
            continue;
        const float s = 1 - sample->barycentric.x, t = s > 0 ? sample->barycentric.z / s : 0;
        const auto cell = [](float x) {
            return static_cast<std::size_t>(std::clamp(static_cast<int>(x * kCells), 0, kCells - 1));
        };
        ++counts[cell(s) * kCells + cell(t)];
    }
    return chi_square_p(counts, expected, kDraws);
}
TEST(MeshLight, NearTriangleBySolidAngle) {
    EXPECT_GT(triangle_agreement({0.2f, 0.3f, 1.5f}, 3), kFalseAlarm);
}
TEST(MeshLight, VeryNearTriangle) {
    EXPECT_GT(triangle_agreement({0.3f, 0.5f, 1.9f}, 4), kFalseAlarm);
}
TEST(MeshLight, TriangleFromAside) {
    EXPECT_GT(triangle_agreement({2, -1, 1.5f}, 5), kFalseAlarm);
}
TEST(MeshLight, FarTriangleByArea) {
    EXPECT_GT(triangle_agreement({5, 20, -30}, 6), kFalseAlarm);
}

TEST(MeshLight, SolidAngleOfASphereOctant) {  // p inside a closed mesh: the faces fill 4 pi, and pdf is 1/(4
                                              // pi) for equal weights
    const Mesh mesh = mesh_of({1, 0, 0, 0, 1, 0, 0, 0, 1, -1, 0, 0, 0, -1, 0, 0, 0, -1},
                              {0, 1, 2, 1, 3, 2, 3, 4, 2, 4, 0, 2, 1, 0, 5, 3, 1, 5, 4, 3, 5, 0, 4, 5});
    const Instance instance = instance_of(kIdentity);
    const MeshLight light(mesh, instance, std::vector<float>(8, 1.0f));
    Rng rng(7);
    for (int i = 0; i < 1000; ++i) {
        const auto s = light.sample({0, 0, 0}, rng.next(), rng.next2());
        ASSERT_TRUE(s);
        EXPECT_NEAR(s->light.pdf, kInv4Pi, 1e-6);
    }
    EXPECT_NEAR(light.importance({0, 0, 0}), 4 * kPid, 1e-3);
    EXPECT_NEAR(light.area(), 4 * std::sqrt(3.0), 1e-5);
}

TEST(MeshLight, ExtremeSizesStayFinite) {
    Rng rng(8);
    for (const float size : {1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f}) {
        const Mesh mesh = mesh_of({0, 0, 0, size, 0, 0, 0, size, 0}, {0, 1, 2});
        const Instance instance = instance_of(kIdentity);
        const MeshLight light(mesh, instance, std::vector<float>{1});
        for (const float ratio : {1e-6f, 1e-3f, 1.0f, 1e3f, 1e6f}) {
            const Vec3f p(0.2f * size, 0.3f * size, -ratio * size), n(0, 0, 1);
            const Estimate e = irradiance(light, p, n, 20000, 9);
            const double exact = ratio < 100
                                     ? triangle_irradiance(p, n, {0, 0, 0}, {size, 0, 0}, {0, size, 0})
                                     : 0.5 / sqr(ratio);
            EXPECT_NEAR(e.mean, exact, 6 * e.error + 3e-3 * exact) << size << ' ' << ratio;
        }
        // In the triangle's plane it is seen edge-on; in its corner, from no distance.
        for (const Vec3f p : {Vec3f(2 * size, 2 * size, 0), Vec3f(0), Vec3f(0.2f * size, 0.2f * size, 0)}) {
            for (int i = 0; i < 100; ++i) {
                const auto s = light.sample(p, rng.next(), rng.next2());
                EXPECT_TRUE(!s || (std::isfinite(s->light.pdf) && is_finite(s->light.wi)));
            }
        }
    }
}

TEST(MeshLight, ManyTrianglesByAreaTimesRadiance) {
    std::vector<float> positions;
    std::vector<std::int32_t> triangles;
    std::vector<float> radiance;
    for (int i = 0; i < 500; ++i) {
        const auto x = static_cast<float>(i), size = 1 + 0.01f * static_cast<float>(i % 37);
        positions.insert(positions.end(), {x, 0, 0, x + size, 0, 0, x, size, 0});
        triangles.insert(triangles.end(), {3 * i, 3 * i + 1, 3 * i + 2});
        radiance.push_back(i % 3 == 0 ? 0 : static_cast<float>(i % 7));
    }
    const Mesh mesh = mesh_of(positions, triangles);
    const Instance instance = instance_of(kIdentity);
    const MeshLight light(mesh, instance, radiance);
    double total = 0;
    std::vector<double> expected(500);
    for (std::uint32_t i = 0; i < 500; ++i) {
        const float size = 1 + 0.01f * static_cast<float>(i % 37);
        expected[i] = 0.5 * double{size * size * radiance[i]};
        total += expected[i];
    }
    for (double& e : expected)
        e /= total;
    std::vector<std::uint64_t> counts(500);
    Rng rng(10);
    for (int i = 0; i < 200000; ++i) {
        const auto s = light.sample({0, 0, 50}, rng.next(), rng.next2());
        ASSERT_TRUE(s);
        ++counts[s->triangle];
    }
    EXPECT_GT(chi_square_p(counts, expected, 200000), kFalseAlarm);
}

TEST(MeshLight, EmptyAndFaulty) {
    const Mesh mesh = tetrahedron();
    const Instance instance = instance_of(kIdentity);
    const MeshLight dark(mesh, instance, std::vector<float>(4, 0.0f));
    EXPECT_TRUE(dark.empty());
    EXPECT_FALSE(dark.sample({}, 0.5f, {0.5f, 0.5f}));
    EXPECT_EQ(dark.importance({}), 0);
    EXPECT_EQ(dark.pdf(0, {}, {0, 0, 2}), 0);
    const Mesh line = mesh_of({0, 0, 0, 1, 0, 0, 2, 0, 0}, {0, 1, 2});
    EXPECT_TRUE(MeshLight(line, instance, std::vector<float>{1}).empty())
        << "triangles without area emit nothing";
    EXPECT_THROW(MeshLight(mesh, instance, std::vector<float>(3, 1.0f)), std::invalid_argument);
    try {
        MeshLight(mesh, instance, std::vector<float>{1, 1, NAN, 1});
        ADD_FAILURE();
    } catch (const std::invalid_argument& e) {
        EXPECT_NE(std::string(e.what()).find("'lamp shade'"), std::string::npos);
    }
}

}  // namespace
}  // namespace nephele::test
