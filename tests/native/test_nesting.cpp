// SPDX-License-Identifier: GPL-3.0-or-later
// Nested dielectrics: which walls count, refraction and reflectance through layers that overlap, against
// closed forms; media of overlapping objects; shadow rays; cameras inside.
#include <gtest/gtest.h>

#include "integrators/integrator.h"
#include "math/warp.h"
#include "media_fixtures.h"
#include "scene_fixtures.h"
#include "surface_fixtures.h"
#include "surfaces/fresnel.h"

namespace nephele::test {
namespace {

using testing::ConstantProgram;
using testing::kNoNormal;

constexpr float kGlass = 1.5f, kWater = 1.33f;

Program dielectric(float ior) {
    return ConstantProgram().add(ClosureKind::glass, {Vec3f(1), Vec3f(0), Vec3f(ior), kNoNormal}).program;
}

/// A scene of boxes, each with a material of its own.
class Boxes {
  public:
    Boxes& add(Vec3f low, Vec3f high, int priority, std::optional<Program> surface, float sigma_a = 0) {
        const auto n = static_cast<std::uint32_t>(source.meshes.size());
        source.meshes.push_back(box_mesh(low, high));
        source.instances.push_back(instance_of(n));
        source.instances.back().materials = {static_cast<std::int32_t>(n)};
        source.instances.back().dielectric_priority = priority;
        Material& m = source.materials.emplace_back();
        m.name = "material";
        m.surface = std::move(surface);
        if (sigma_a > 0)
            m.volume.emplace_back().sigma_a = Rgb(sigma_a);
        return *this;
    }
    /// A layer that is wide in x and y.
    Boxes& layer(float z0, float z1, int priority, float ior, float sigma_a = 0) {
        return add({-50, -50, z0}, {50, 50, z1}, priority, dielectric(ior), sigma_a);
    }

    SceneSource source;
};

/// Walls along a ray as intersect() tells them, each from a point just behind the last: distance and the
/// index beyond over the index before.
std::vector<std::pair<float, float>> walls(const Scene& scene, Ray ray, const std::vector<float>& iors) {
    std::vector<std::pair<float, float>> out;
    const Vec3f start = ray.o;
    for (int n = 0; n < 20; ++n) {
        const Hit hit = scene.intersect(ray, kCameraRay);
        if (!hit.valid())
            break;
        const ShadingPoint point = scene.shading_point(hit, ray, kCameraRay);
        const float ior = iors[hit.instance] / point.outside_ior;
        out.emplace_back(length(point.p - start), point.backfacing ? 1 / ior : ior);
        ray.o = offset_point(point.p, -point.ng);
    }
    return out;
}

void expect_walls(const std::vector<std::pair<float, float>>& found,
                  const std::vector<std::pair<float, float>>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
        EXPECT_NEAR(found[i].first, expected[i].first, 1e-4) << i;
        EXPECT_NEAR(found[i].second, expected[i].second, 1e-5) << i;
    }
}

TEST(Nesting, HidesWallsInsideAHigherPriority) {
    // Glass from 0 to 1, water from 0.9 or from 1 to 2: the glass prevails.
    for (const float begin : {0.9f, 1.0f}) {
        const Scene scene(Boxes().layer(0, 1, 2, kGlass).layer(begin, 2, 1, kWater).source);
        EXPECT_TRUE(scene.features().nested_dielectrics);
        expect_walls(walls(scene, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kWater}),
                     {{3, kGlass}, {4, kWater / kGlass}, {5, 1 / kWater}});
        expect_walls(walls(scene, {{0.1f, 0.2f, 5}, {0, 0, -1}}, {kGlass, kWater}),
                     {{3, kWater}, {4, kGlass / kWater}, {5, 1 / kGlass}});
        // From inside each of them.
        expect_walls(walls(scene, {{0.1f, 0.2f, 0.5f}, {0, 0, 1}}, {kGlass, kWater}),
                     {{0.5f, kWater / kGlass}, {1.5f, 1 / kWater}});
        expect_walls(walls(scene, {{0.1f, 0.2f, 1.5f}, {0, 0, -1}}, {kGlass, kWater}),
                     {{0.5f, kGlass / kWater}, {1.5f, 1 / kGlass}});
    }
    // The water prevails.
    const Scene other(Boxes().layer(0, 1, 1, kGlass).layer(0.9f, 2, 2, kWater).source);
    expect_walls(walls(other, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kWater}),
                 {{3, kGlass}, {3.9f, kWater / kGlass}, {5, 1 / kWater}});
    // A gap remains a gap.
    const Scene gap(Boxes().layer(0, 1, 2, kGlass).layer(1.001f, 2, 1, kWater).source);
    expect_walls(walls(gap, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kWater}),
                 {{3, kGlass}, {4, 1 / kGlass}, {4.001f, kWater}, {5, 1 / kWater}});
}

TEST(Nesting, OfNoPriorityBordersOnAir) {
    const Scene scene(Boxes().layer(0, 1, 0, kGlass).layer(0.9f, 2, 0, kWater).source);
    EXPECT_FALSE(scene.features().nested_dielectrics);
    expect_walls(walls(scene, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kWater}),
                 {{3, kGlass}, {3.9f, kWater}, {4, 1 / kGlass}, {5, 1 / kWater}});
    // One that takes no part inside one that does, and the other way round.
    const Scene mixed(Boxes().layer(0, 3, 1, kWater).layer(1, 2, 0, kGlass).source);
    expect_walls(walls(mixed, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kWater, kGlass}),
                 {{3, kWater}, {4, kGlass}, {5, 1 / kGlass}, {6, 1 / kWater}});
}

TEST(Nesting, MergesEqualPriorities) {
    const Scene scene(Boxes().layer(0, 1, 1, kGlass).layer(0.5f, 2, 1, kGlass).layer(2, 3, 1, kWater).source);
    expect_walls(walls(scene, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kGlass, kWater}),
                 {{3, kGlass}, {5, kWater / kGlass}, {6, 1 / kWater}});
    // The same object twice.
    const Scene twice(Boxes().layer(0, 1, 1, kGlass).layer(0, 1, 1, kGlass).source);
    expect_walls(walls(twice, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kGlass}),
                 {{3, kGlass}, {4, 1 / kGlass}});
}

TEST(Nesting, FollowsAnIndexThatVaries) {
    Boxes boxes;
    boxes.layer(0, 1, 2, kGlass).layer(0.9f, 2, 1, kWater);
    Program& p = *boxes.source.materials[1].surface;  // the same index, from an instruction
    const auto ior = p.closures[0].inputs[glass_input::ior];
    p.code.push_back({static_cast<std::int32_t>(Op::copy), ior, ior});
    const Scene scene(std::move(boxes.source));
    expect_walls(walls(scene, {{0.1f, 0.2f, -3}, {0, 0, 1}}, {kGlass, kWater}),
                 {{3, kGlass}, {4, kWater / kGlass}, {5, 1 / kWater}});
}

/// Follows refraction, or total reflection, through the scene; the ray that leaves.
Ray refracted(const Scene& scene, Ray ray) {
    for (int n = 0; n < 20; ++n) {
        const Hit hit = scene.intersect(ray, kCameraRay);
        if (!hit.valid())
            return ray;
        const ShadingPoint point = scene.shading_point(hit, ray, kCameraRay);
        const Bsdf bsdf = make_bsdf(scene.program_of(point), point, scene.textures());
        const auto sample = bsdf.sample(point.wo, 0.9999f, {0.9999f, 0.5f});
        if (!sample) {
            ADD_FAILURE() << "absorbed";
            return ray;
        }
        const bool total = dot(sample->wi, point.ng) > 0;
        ray = {offset_point(point.p, total ? point.ng : -point.ng), sample->wi};
    }
    return ray;
}

TEST(Nesting, RefractsByTheIndicesOnBothSides) {
    const Scene scene(
        Boxes().layer(0, 1, 3, kGlass).layer(0.95f, 2.05f, 1, kWater).layer(2, 3, 2, kGlass).source);
    for (const double angle : {0.0, 0.3, 0.7, 1.2}) {
        const Ray out = refracted(
            scene,
            {{0, 0, -1}, {static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle))}});
        const auto tangent = [&](double ior) {
            const double s = std::sin(angle) / ior;
            return s / std::sqrt(1 - s * s);
        };
        const double x = tangent(1) + 2 * tangent(double{kGlass}) + tangent(double{kWater});
        EXPECT_NEAR(out.d.x, std::sin(angle), 1e-5);
        EXPECT_NEAR(out.o.x - out.o.z * out.d.x / out.d.z + 3 * out.d.x / out.d.z, x, 1e-4 * (1 + x));
    }
}

/// Mean radiance along a ray, by the path tracer.
Mean radiance(const Scene& scene, const Ray& ray, int samples) {
    Settings settings;
    settings.max_bounces = settings.surface_bounces = settings.volume_bounces = 1000;
    settings.roulette_depth = 1000;
    const SampleFunction sample = choose_kernel(settings, scene.features()).sample;
    Workspace ws;
    Mean mean;
    for (int n = 0; n < samples; ++n) {
        PathSampler sampler(false, 5, 0, static_cast<std::uint32_t>(n));
        const PixelSample s = sample(scene, settings, {}, ray, sampler, ws);
        mean.add(double{s.surface.x} + double{s.volume.x});
    }
    return mean;
}

Program emission(float strength) {
    return ConstantProgram().add(ClosureKind::emission, {Vec3f(1), Vec3f(strength)}).program;
}

TEST(Nesting, LosesNoLightInAFurnace) {
    Boxes boxes;
    boxes.add(Vec3f(-1), Vec3f(0.5f), 3, dielectric(kGlass))
        .add(Vec3f(-0.7f), Vec3f(1), 2, dielectric(kWater))
        .add({-2, -0.2f, -0.2f}, {2, 0.2f, 0.2f}, 1, dielectric(2.4f))
        .add({-0.2f, -2, -0.2f}, {0.2f, 2, 0.2f}, 0, dielectric(1.2f));
    boxes.source.world.background = emission(1);
    const Scene scene(std::move(boxes.source));
    Rng rng(3);
    constexpr int kRays = 10000;
    double sum = 0;
    for (int n = 0; n < kRays; ++n) {
        // From outside: boxes hold what starts inside of them by total reflection, some of it for ever.
        const Vec3f target = (rng.next3() - Vec3f(0.5f)) * 2.0f,
                    o = target + sample_sphere(rng.next2()) * 6.0f;
        sum += radiance(scene, {o, normalize(target - o)}, 1).mean();
    }
    EXPECT_NEAR(sum / kRays, 1, 1e-4);
}

/// Transmittance of a stack of plane layers for unpolarised light without interference; iors: of each layer.
double stack_transmittance(const std::vector<double>& iors, double angle) {
    double T = 1, R = 0;  // of what was added so far
    double before = 1;
    for (std::size_t i = 0; i <= iors.size(); ++i) {
        const double after = i < iors.size() ? iors[i] : 1, s = std::sin(angle);
        const double cos_i = std::sqrt(1 - s * s / (before * before)),
                     cos_t = std::sqrt(1 - s * s / (after * after));
        const double rs = (before * cos_i - after * cos_t) / (before * cos_i + after * cos_t),
                     rp = (after * cos_i - before * cos_t) / (after * cos_i + before * cos_t);
        const double r = 0.5 * (rs * rs + rp * rp), t = 1 - r;
        const double trapped = 1 / (1 - R * r);
        R = r + t * t * R * trapped;  // seen from beyond
        T = T * t * trapped;
        before = after;
    }
    return T;
}

TEST(Nesting, TransmitsThroughThreeLayersWhatTheClosedFormSays) {
    for (const float begin : {0.9f, 1.0f}) {  // overlapping, and abutting
        for (const double angle : {0.0, 1.0, 1.4}) {
            Boxes boxes;
            boxes.layer(0, 1, 2, kGlass).layer(begin, 2, 1, kWater);
            boxes.add({-50, -50, 3}, {50, 50, 3.1f}, 0, emission(1));
            const Scene scene(std::move(boxes.source));
            const Mean seen = radiance(
                scene,
                {{0, 0, -1}, {static_cast<float>(std::sin(angle)), 0, static_cast<float>(std::cos(angle))}},
                40000);
            const double expected = stack_transmittance({double{kGlass}, double{kWater}}, angle);
            EXPECT_LT(seen.z(expected), kSigmas) << angle << ": " << seen.mean() << ' ' << expected;
        }
    }
}

TEST(Nesting, OfOneIndexIsAsOneMesh) {
    // Two overlapping halves of a box refract as the box does.
    const Scene halves(Boxes()
                           .add(Vec3f(-1), {0.2f, 1, 1}, 2, dielectric(kGlass))
                           .add({0, -1, -1}, Vec3f(1), 1, dielectric(kGlass))
                           .source);
    const Scene whole(Boxes().add(Vec3f(-1), Vec3f(1), 0, dielectric(kGlass)).source);
    for (float x = -0.93f; x < 1; x += 0.1f) {
        const Ray ray{{x, 0.3f, -4}, normalize(Vec3f(0.15f, -0.1f, 1))};
        const Ray a = refracted(halves, ray), b = refracted(whole, ray);
        EXPECT_NEAR(length(a.d - b.d), 0, 1e-5);
        EXPECT_NEAR(length(cross(a.o - b.o, b.d)), 0, 1e-4);
    }
}

TEST(Nesting, LeavesTheMediumOfALowerPriorityOut) {
    const auto depth = [](const Scene& scene, Vec3f o, Vec3f d) {
        Segment segment;
        scene.find_media({o, d, 0, 20}, kShadowRay, segment);
        double sum = 0;
        for (const Interval& i : segment.intervals)
            sum += double{i.medium->sigma_t.x} * (double{i.t1} - double{i.t0});
        return sum;
    };
    // Water of sigma 0.5 from 0 to 4, glass of sigma 3 from 1 to 2, and a bubble without medium from 3
    // to 3.5.
    for (const bool nested : {true, false}) {
        const int on = nested ? 1 : 0;
        Boxes boxes;
        boxes.layer(0, 4, 1 * on, kWater, 0.5f).layer(1, 2, 2 * on, kGlass, 3);
        boxes.layer(3, 3.5f, 3 * on, 1);
        boxes.source.world.volume.emplace_back().sigma_s = Rgb(0.01f);
        const Scene scene(std::move(boxes.source));
        const double water = nested ? 2.5 : 4;
        EXPECT_NEAR(depth(scene, {0.1f, 0.2f, -1}, {0, 0, 1}), 0.5 * water + 3 + 0.2, 1e-4);
        EXPECT_NEAR(depth(scene, {0.1f, 0.2f, 1.5f}, {0, 0, 1}),
                    0.5 * (water - (nested ? 1 : 1.5)) + 1.5 + 0.2, 1e-4);
        EXPECT_NEAR(depth(scene, {0.1f, 0.2f, 3.2f}, {0, 0, 1}), 0.5 * (nested ? 0.5 : 0.8) + 0.2, 1e-4);
    }
}

TEST(Nesting, LetsShadowRaysPassHiddenWalls) {
    const auto veil = [](float c) {
        return ConstantProgram().add(ClosureKind::transparent, {Vec3f(c)}).program;
    };
    const Program opaque =
        ConstantProgram().add(ClosureKind::diffuse, {Vec3f(1), Vec3f(0), kNoNormal}).program;
    const Ray ray{{0.1f, 0.2f, -5}, {0, 0, 1}, 0, 10};
    for (const int priority : {0, 1}) {
        Boxes boxes;
        boxes.add(Vec3f(-1), Vec3f(1), 2 * priority, veil(0.5f));
        boxes.add(Vec3f(-0.5f), Vec3f(0.5f), priority, opaque);
        const Scene scene(std::move(boxes.source));
        EXPECT_NEAR(scene.surface_transmittance(ray).x, priority > 0 ? 0.25f : 0.0f, 1e-6f);
    }
    const Scene seen(
        Boxes().add(Vec3f(-1), Vec3f(1), 2, veil(0.5f)).add({-1, -1, 0}, Vec3f(2), 1, opaque).source);
    EXPECT_EQ(seen.surface_transmittance(ray).x, 0);  // its far wall is outside
}

TEST(Nesting, IsNotForWhatEmits) {
    const Scene scene(Boxes().add(Vec3f(-1), Vec3f(1), 2, emission(1)).source);
    EXPECT_FALSE(scene.features().nested_dielectrics);
    ASSERT_EQ(scene.warnings().size(), 1u);
    EXPECT_NE(scene.warnings()[0].find("dielectric priority"), std::string::npos);
}

}  // namespace
}  // namespace nephele::test
