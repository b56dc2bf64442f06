// SPDX-License-Identifier: GPL-3.0-or-later
// The choice among lights: probabilities that add up, that select() keeps to, and that leave no contributing
// light out.
#include "lights/light_set.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "cell_counts.h"
#include "light_fixtures.h"
#include "math/warp.h"

namespace nephele::test {
namespace {

/// Lamps of every kind, scattered over a box of this half width.
std::vector<Lamp> scattered(int count, float half_width, std::uint64_t seed) {
    Rng rng(seed);
    std::vector<Lamp> lamps;
    for (int i = 0; i < count; ++i) {
        LampDescription d = lamp_of(i % 4 == 0   ? Kind::point
                                    : i % 4 == 1 ? Kind::spot
                                    : i % 4 == 2 ? Kind::area
                                                 : Kind::point);
        d.name = "lamp " + std::to_string(i);
        d.power = Rgb(std::pow(10.0f, 3 * rng.next()));
        d.radius = i % 4 == 3 ? 0.3f * rng.next() : 0;
        d.spread = i % 8 == 2 ? 1.0f : kPi;
        const Vec3f place_of(half_width * (2 * rng.next() - 1), half_width * (2 * rng.next() - 1),
                             half_width * (2 * rng.next() - 1));
        place(d, place_of, {6 * rng.next(), 6 * rng.next(), 6 * rng.next()});
        lamps.push_back(prepare_lamp(d));
    }
    return lamps;
}

struct MeshAndInstance {
    Mesh mesh;
    Instance instance;
};

std::shared_ptr<MeshAndInstance> emissive_square() {
    auto m = std::make_shared<MeshAndInstance>();
    m->mesh.positions = Buffer<float>(std::vector<float>{-1, -1, 4, 1, -1, 4, 1, 1, 4, -1, 1, 4});
    m->mesh.triangles = Buffer<std::int32_t>(std::vector<std::int32_t>{0, 1, 2, 0, 2, 3});
    m->instance.materials = {0};
    return m;
}

LightSet mixed_set(int lamps, float half_width, const MeshAndInstance& mesh) {
    std::vector<Lamp> all = scattered(lamps, half_width, 1);
    all.push_back(hanging(Kind::sun, sun(2)));
    std::vector<MeshLight> meshes;
    meshes.emplace_back(mesh.mesh, mesh.instance, std::vector<float>{5, 5});
    const auto world =
        std::make_shared<EnvironmentLight>([](Vec3f d) { return Rgb(0.1f + std::max(0.0f, d.z)); }, 32, 16);
    return LightSet(std::move(all), std::move(meshes), world);
}

class LightSetOfSize : public ::testing::TestWithParam<int> {};

TEST_P(LightSetOfSize, ProbabilitiesAddUpAndAreKept) {
    const auto mesh = emissive_square();
    const LightSet lights = mixed_set(GetParam(), 5, *mesh);
    Rng rng(2);
    for (int place_number = 0; place_number < 6; ++place_number) {
        const Vec3f p(12 * rng.next() - 6, 12 * rng.next() - 6, 12 * rng.next() - 6);
        std::vector<double> expected;
        double total = 0;
        for (std::uint32_t i = 0; i < lights.size(); ++i) {
            expected.push_back(lights.selection_pdf(p, i));
            total += expected.back();
        }
        EXPECT_LE(total, 1 + 1e-5);  // less only where a leaf of the tree has no light that reaches p
        EXPECT_GT(total, 0.5);
        std::vector<std::uint64_t> counts(lights.size());
        constexpr int kDraws = 100000;
        for (int i = 0; i < kDraws; ++i) {
            float probability = 0;
            const auto chosen = lights.select(p, rng.next(), probability);
            if (!chosen)
                continue;
            ++counts[*chosen];
            ASSERT_NEAR(probability, expected[*chosen], 1e-4 * expected[*chosen]);
        }
        EXPECT_GT(chi_square_p(counts, expected, kDraws), kFalseAlarm);
    }
}

TEST_P(LightSetOfSize, EveryContributingLightCanBeChosen) {
    const auto mesh = emissive_square();
    const LightSet lights = mixed_set(GetParam(), 5, *mesh);
    Rng rng(3);
    for (int k = 0; k < 300; ++k) {
        const Vec3f p = sample_sphere(rng.next2()) * std::pow(10.0f, 4 * rng.next() - 1);
        for (std::uint32_t i = 0; i < lights.lamps().size(); ++i) {
            if (!lights.lamp(i).sample(p, rng.next2()))
                continue;
            ASSERT_GT(lights.selection_pdf(p, i), 0) << lights.lamp(i).name;
        }
        EXPECT_GT(lights.selection_pdf(p, lights.mesh_number(0)), 0);
        EXPECT_GT(lights.selection_pdf(p, lights.world_number()), 0);
    }
}

TEST_P(LightSetOfSize, OneSampleEstimatesAllTheLight) {
    const auto mesh = emissive_square();
    const LightSet lights(scattered(GetParam(), 5, 4), {}, nullptr);
    for (const Vec3f p : {Vec3f(0.3f, 0.2f, 0.1f), Vec3f(4, -4, 2), Vec3f(30, 10, 0)}) {
        double exact = 0, exact_error = 0;
        for (const Lamp& lamp : lights.lamps()) {
            const Estimate e = irradiance(lamp, p, {}, 4000, 5);
            exact += e.mean;
            exact_error += e.error * e.error;
        }
        Rng rng(6);
        double sum = 0, sum2 = 0;
        constexpr int kDraws = 200000;
        for (int i = 0; i < kDraws; ++i) {
            float probability = 0;
            const auto chosen = lights.select(p, rng.next(), probability);
            const auto s = chosen ? lights.lamp(*chosen).sample(p, rng.next2()) : std::nullopt;
            const double value = s ? double{s->Li.x} / double{s->pdf} / double{probability} : 0;
            sum += value;
            sum2 += value * value;
        }
        const double mean = sum / kDraws, variance = std::max(0.0, sum2 / kDraws - mean * mean);
        EXPECT_NEAR(mean, exact, 6 * std::sqrt(variance / kDraws + exact_error) + 1e-4 * exact);
        // Drawn uniformly, the relative deviation of one sample would be near sqrt(lamps) here, 30 for 1000.
        EXPECT_LT(std::sqrt(variance), 4 * mean) << "the choice follows what arrives";
    }
}

TEST_P(LightSetOfSize, RaysFindTheLampsThatTheyMeet) {
    const LightSet lights(scattered(GetParam(), 3, 7), {}, nullptr);
    Rng rng(8);
    int found = 0;
    for (int i = 0; i < 20000; ++i) {
        const Vec3f o(6 * rng.next() - 3, 6 * rng.next() - 3, 6 * rng.next() - 3);
        const float t_max = rng.next() < 0.3f ? 2.0f : kInfinity;
        // Some rays along an axis, in the plane of boxes' sides.
        const Ray ray{o, i % 10 == 0 ? Vec3f(0, 0, 1) : sample_sphere(rng.next2()), 0, t_max};
        std::map<std::uint32_t, float> expected, got;
        for (std::uint32_t l = 0; l < lights.lamps().size(); ++l) {
            if (const auto h = lights.lamp(l).intersect(ray))
                expected[l] = h->distance;
        }
        lights.for_each_lamp_hit(ray, [&](std::uint32_t l, const LightHit& h) {
            EXPECT_TRUE(got.emplace(l, h.distance).second) << "told twice";
        });
        ASSERT_EQ(got, expected);
        found += static_cast<int>(got.size());
    }
    EXPECT_TRUE(found > 50 || GetParam() == 2) << found;  // the two are a bare point and a bare spot
}

INSTANTIATE_TEST_SUITE_P(Lamps, LightSetOfSize, ::testing::Values(2, 15, 16, 17, 40, 1000));

TEST(LightSet, FewLightsAreChosenByImportance) {
    const auto mesh = emissive_square();
    const LightSet lights = mixed_set(5, 5, *mesh);
    const Vec3f p(0.5f, 1, -1);
    double sum = lights.mesh(lights.mesh_number(0)).importance(p) + lights.world()->importance();
    for (const Lamp& lamp : lights.lamps())
        sum += lamp.importance(p);
    for (std::uint32_t i = 0; i < lights.lamps().size(); ++i) {
        EXPECT_NEAR(lights.selection_pdf(p, i), lights.lamp(i).importance(p) / sum, 1e-6);
    }
    EXPECT_NEAR(lights.selection_pdf(p, lights.world_number()), lights.world()->importance() / sum, 1e-6);
}

TEST(LightSet, NumbersAndKinds) {
    const auto mesh = emissive_square();
    const LightSet lights = mixed_set(3, 5, *mesh);
    EXPECT_EQ(lights.size(), 6u);
    EXPECT_EQ(lights.kind(3), LightSet::Kind::lamp);  // the sun
    EXPECT_EQ(lights.mesh_number(0), 4u);
    EXPECT_EQ(lights.kind(4), LightSet::Kind::mesh);
    EXPECT_EQ(lights.world_number(), 5u);
    EXPECT_EQ(lights.kind(5), LightSet::Kind::world);
}

TEST(LightSet, DarkOnesAreNeverChosen) {
    float probability = 0;
    EXPECT_TRUE(LightSet().empty());
    EXPECT_FALSE(LightSet().select(Vec3f{}, 0.5f, probability));
    const auto black = std::make_shared<EnvironmentLight>([](Vec3f) { return Rgb(0); }, 4, 2);
    const LightSet dark({prepare_lamp(lamp_of(Kind::point, 0))}, {}, black);
    EXPECT_TRUE(dark.empty());
    EXPECT_FALSE(dark.select(Vec3f{0, 0, 1}, 0.5f, probability));
    EXPECT_EQ(dark.selection_pdf(Vec3f{0, 0, 1}, 0), 0);
    EXPECT_EQ(dark.selection_pdf(Vec3f{0, 0, 1}, dark.world_number()), 0);
}

TEST(LightSet, SurvivesCoincidencesAndHugeRanges) {
    std::vector<Lamp> lamps;
    for (int i = 0; i < 40; ++i) {  // all in one place, powers over 24 decades
        LampDescription d = lamp_of(Kind::point, std::pow(10.0f, static_cast<float>(i % 25) - 12));
        place(d, {1, 2, 3});
        lamps.push_back(prepare_lamp(d));
    }
    const LightSet lights(std::move(lamps), {}, nullptr);
    Rng rng(9);
    for (const Vec3f p : {Vec3f(1, 2, 3), Vec3f(1, 2, 3.000001f), Vec3f(1e9f, 0, 0), Vec3f(0)}) {
        double total = 0;
        for (std::uint32_t i = 0; i < 40; ++i) {
            const float pdf = lights.selection_pdf(p, i);
            EXPECT_TRUE(std::isfinite(pdf) && pdf > 0);
            total += double{pdf};
        }
        EXPECT_NEAR(total, 1, 1e-5);
        for (int i = 0; i < 1000; ++i) {
            float probability = 0;
            ASSERT_TRUE(lights.select(p, rng.next(), probability));
            ASSERT_TRUE(probability > 0 && probability <= 1);
        }
        float probability = 0;
        EXPECT_TRUE(lights.select(p, kOneMinusEpsilon, probability));
    }
}

TEST(LightSet, ParallelBeamsReachFar) {  // a beam does not thin out, so a tree must not weigh it by distance
    std::vector<Lamp> lamps = scattered(40, 5, 10);
    lamps.push_back(hanging(Kind::area, area(1, 1, false, 0)));
    const LightSet lights(std::move(lamps), {}, nullptr);
    EXPECT_GT(lights.selection_pdf(Vec3f{0.1f, 0.1f, -1e5f}, 40), 0.9f);
    EXPECT_EQ(lights.selection_pdf(Vec3f{3, 0, -10}, 40), 0);
}

}  // namespace
}  // namespace nephele::test
