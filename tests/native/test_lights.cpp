// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps: samples against densities and hits, importance, preparation.
#include <gtest/gtest.h>

#include <functional>

#include "cell_counts.h"
#include "light_fixtures.h"

namespace nephele::test {
namespace {

constexpr double kPid = 3.14159265358979323846;
constexpr Vec3f kUp(0, 0, 1);

Lamp sphere_lamp(float radius, Vec3f center = {0, 0, 2}) {
    LampDescription d = lamp_of(Kind::point);
    d.radius = radius;
    place(d, center);
    return prepare_lamp(d);
}
Lamp area_lamp(float x, float y, bool ellipse = false, float spread = 180) {
    return hanging(Kind::area, area(x, y, ellipse, spread));
}

// --- Samples against densities
// -------------------------------------------------------------------------------

/// A piece of the sphere of directions over the unit square.
struct Chart {
    std::function<Vec3f(double, double)> direction;
    std::function<double(double, double)> jacobian;  ///< solid angle per unit of the square
    std::function<Vec2f(Vec3f)> coordinates;         ///< inverse of direction
};

/// Tangents in [x0, x1] x [y0, y1] around the unit vector z.
Chart tangent_chart(Vec3f x, Vec3f y, Vec3f z, double x0, double x1, double y0, double y1) {
    const auto at = [=](double u, double v) { return std::pair(x0 + (x1 - x0) * u, y0 + (y1 - y0) * v); };
    return {[=](double u, double v) {
                const auto [a, b] = at(u, v);
                return normalize(x * static_cast<float>(a) + y * static_cast<float>(b) + z);
            },
            [=](double u, double v) {
                const auto [a, b] = at(u, v);
                return (x1 - x0) * (y1 - y0) / std::pow(1 + a * a + b * b, 1.5);
            },
            [=](Vec3f wi) {
                const double c = dot(wi, z);
                return Vec2f{static_cast<float>((dot(wi, x) / c - x0) / (x1 - x0)),
                             static_cast<float>((dot(wi, y) / c - y0) / (y1 - y0))};
            }};
}

/// The cone of half angle acos(1 - height) around the axis; height 2: all directions.
Chart cone_chart(Vec3f axis, double height) {
    const Frame f(normalize(axis));
    return {[=](double u, double v) {
                const double z = 1 - height * u, s = std::sqrt(std::max(0.0, 1 - z * z)), phi = 2 * kPid * v;
                return f.to_world({static_cast<float>(s * std::cos(phi)),
                                   static_cast<float>(s * std::sin(phi)), static_cast<float>(z)});
            },
            [=](double, double) { return 2 * kPid * height; },
            [=](Vec3f wi) {
                const Vec3f l = f.to_local(wi);
                const double phi = std::atan2(double{l.y}, double{l.x}) / (2 * kPid),
                             turn = phi < 0 ? phi + 1 : phi;
                // 1 - z by the sine where it is small: z alone has no digits left there.
                const double s2 = double{l.x} * l.x + double{l.y} * l.y,
                             drop = l.z > 0 ? s2 / (1 + double{l.z}) : 1 - double{l.z};
                return Vec2f{static_cast<float>(drop / height), static_cast<float>(turn)};
            }};
}

/// p-value of 400000 samples over 12 x 12 cells; a cell's probability is pdf() integrated by sub x sub
/// midpoints: many where the edge of what the lamp lights runs through cells.
double agreement(const Lamp& lamp, Vec3f p, const Chart& chart, std::uint64_t seed, int sub = 16) {
    constexpr int kCells = 12, kDraws = 400000;
    const double h = 1.0 / (kCells * sub);
    std::vector<double> expected(kCells * kCells);
    for (int i = 0; i < kCells * sub; ++i) {
        for (int j = 0; j < kCells * sub; ++j) {
            const double u = (i + 0.5) * h, v = (j + 0.5) * h;
            expected[static_cast<std::size_t>(i / sub * kCells + j / sub)] +=
                h * h * chart.jacobian(u, v) * double{lamp.pdf(p, chart.direction(u, v))};
        }
    }
    Rng rng(seed);
    std::vector<std::uint64_t> counts(expected.size());
    for (int k = 0; k < kDraws; ++k) {
        const auto s = lamp.sample(p, rng.next2());
        if (!s)
            continue;
        const Vec2f c = chart.coordinates(s->wi);
        const auto cell = [](float x) {
            return static_cast<std::size_t>(std::clamp(static_cast<int>(x * kCells), 0, kCells - 1));
        };
        ++counts[cell(c.x) * kCells + cell(c.y)];
    }
    return chi_square_p(counts, expected, kDraws);
}

/// Chart over the bounding rectangle of area_lamp(x, y), which lies in z = 2 and shines down.
Chart rectangle_chart(float x, float y, Vec3f p) {
    const double h = 2 - double{p.z};
    return tangent_chart({1, 0, 0}, {0, 1, 0}, kUp, (-0.5 * x - p.x) / h, (0.5 * x - p.x) / h,
                         (-0.5 * y - p.y) / h, (0.5 * y - p.y) / h);
}
double rectangle_agreement(float x, float y, Vec3f p, bool ellipse, float spread, std::uint64_t seed) {
    return agreement(area_lamp(x, y, ellipse, spread), p, rectangle_chart(x, y, p), seed,
                     ellipse || spread < 180 ? 96 : 16);
}

TEST(LampDensity, RectangleNear) {
    EXPECT_GT(rectangle_agreement(2, 3, {0.3f, 0.2f, 1}, false, 180, 1), kFalseAlarm);
}
TEST(LampDensity, RectangleGrazing) {
    EXPECT_GT(rectangle_agreement(2, 3, {1.5f, 0.2f, 1.9f}, false, 180, 2), kFalseAlarm);
}
TEST(LampDensity, RectangleFar) {
    EXPECT_GT(rectangle_agreement(0.1f, 0.2f, {1, 2, -3}, false, 180, 3), kFalseAlarm);
}
TEST(LampDensity, RectangleLong) {
    EXPECT_GT(rectangle_agreement(0.05f, 5, {0.3f, 1, 1.5f}, false, 180, 4), kFalseAlarm);
}
TEST(LampDensity, EllipseFar) {
    EXPECT_GT(rectangle_agreement(0.1f, 0.2f, {1, 2, -3}, true, 180, 5), kFalseAlarm);
}

// With a spread, and for near ellipses, part of the window gives no light: those draws return nothing, and
// pdf() is 0.
TEST(LampDensity, EllipseNear) {
    EXPECT_GT(rectangle_agreement(2, 3, {0.3f, 0.2f, 1}, true, 180, 6), kFalseAlarm);
}
TEST(LampDensity, RectangleSpread) {
    EXPECT_GT(rectangle_agreement(2, 3, {0.8f, 1, 1.4f}, false, 60, 7), kFalseAlarm);
}
TEST(LampDensity, EllipseSpread) {
    EXPECT_GT(rectangle_agreement(2, 3, {0.4f, 0.6f, 1.2f}, true, 40, 8), kFalseAlarm);
}

TEST(LampDensity, SphereOutside) {
    const Lamp lamp = sphere_lamp(0.5f);
    EXPECT_GT(
        agreement(lamp, {1, 0.2f, 0.5f}, cone_chart({-1, -0.2f, 1.5f}, 1 - std::sqrt(1 - 0.25 / 3.29)), 11),
        kFalseAlarm);
}
TEST(LampDensity, SphereJustOutside) {
    const Lamp lamp = sphere_lamp(0.5f);
    EXPECT_GT(
        agreement(lamp, {0, 0, 1.4999f}, cone_chart(kUp, 1 - std::sqrt(1 - std::pow(0.5 / 0.5001, 2))), 12),
        kFalseAlarm);
}
TEST(LampDensity, SphereInside) {
    EXPECT_GT(agreement(sphere_lamp(3), {1, 0.2f, 0.5f}, cone_chart(kUp, 2), 13), kFalseAlarm);
}
TEST(LampDensity, SoftDisc) {
    LampDescription d = lamp_of(Kind::point);
    d.radius = 1.2f;
    d.soft_falloff = true;
    place(d, {0, 0, 2});
    const Lamp lamp = prepare_lamp(d);
    const Vec3f p(1, 0.2f, 0.5f), axis = Vec3f(0, 0, 2) - p;
    const double cosine = 1 / std::sqrt(1 + sqr(1.2f / length(axis)));
    EXPECT_GT(agreement(lamp, p, cone_chart(axis, 1 - cosine), 14), kFalseAlarm);
}
TEST(LampDensity, Sun) {
    for (const float degrees : {0.5f, 60.0f, 175.0f}) {
        LampDescription d = lamp_of(Kind::sun);
        sun(degrees, true, 0.4f)(d);
        const Lamp lamp = prepare_lamp(d);
        const double height = 2 * std::pow(std::sin(0.25 * degrees * kDegree), 2);
        EXPECT_GT(agreement(lamp, {}, cone_chart(d.axis(2), height * 1.1), 15), kFalseAlarm) << degrees;
    }
}

// --- sample, pdf and intersect tell the same story
// ----------------------------------------------------------

std::vector<Lamp> all_sorts() {
    std::vector<Lamp> lamps{sphere_lamp(0.5f), area_lamp(1, 2), area_lamp(1, 2, true),
                            area_lamp(1, 2, false, 70), area_lamp(1, 2, true, 70)};
    for (const auto& [kind, set] :
         {std::pair(Kind::sun, sun(3)), std::pair(Kind::sun, sun(170)), std::pair(Kind::spot, spot(0.3f)),
          std::pair(Kind::spot, spot(0.3f, 0.2f, 90, true)), std::pair(Kind::point, ball(0.7f, true)),
          std::pair(Kind::area, tilted_area())}) {
        lamps.push_back(hanging(kind, set));
    }
    return lamps;
}

TEST(LampConsistency, HitsWhatItSamples) {
    Rng rng(21);
    int compared = 0, missed = 0;
    for (const Lamp& lamp : all_sorts()) {
        for (int i = 0; i < 4000; ++i) {
            const Vec3f p(3 * rng.next() - 1.5f, 3 * rng.next() - 1.5f, 4 * rng.next() - 1);
            const auto s = lamp.sample(p, rng.next2());
            if (!s)
                continue;
            ASSERT_NEAR(length(s->wi), 1, 1e-5);
            ++compared;
            const auto h = lamp.intersect({p, s->wi});
            if (!h) {  // rounding at the lamp's rim
                ++missed;
                continue;
            }
            const float pdf = lamp.pdf(p, s->wi);
            EXPECT_NEAR(pdf, s->pdf, 2e-3f * s->pdf);
            EXPECT_EQ(h->pdf, pdf);
            EXPECT_NEAR(mean(h->Le), mean(s->Li), 2e-3f * mean(s->Li) + 1e-3f);
            if (std::isfinite(s->distance)) {
                // A ray that grazes a sphere amplifies the rounding of its direction to the root.
                EXPECT_NEAR(h->distance, s->distance, 2e-3f * s->distance);
            } else {
                EXPECT_EQ(h->distance, kInfinity);
            }
        }
    }
    EXPECT_GT(compared, 20000);
    EXPECT_LT(missed, compared / 1000);
}

TEST(LampConsistency, SamplesLieOnTheLamp) {
    Rng rng(24);
    const Vec3f center(0, 0, 2);
    for (int i = 0; i < 4000; ++i) {
        const Vec3f p(3 * rng.next() - 1.5f, 3 * rng.next() - 1.5f, 4 * rng.next() - 1);
        const auto reached = [&](const Lamp& lamp) {
            const auto s = lamp.sample(p, rng.next2());
            return s ? std::optional(p + s->wi * s->distance) : std::nullopt;
        };
        for (const float radius : {0.2f, 1.5f}) {
            const auto on_sphere = reached(sphere_lamp(radius));
            ASSERT_TRUE(on_sphere);
            EXPECT_NEAR(length(*on_sphere - center), radius, 1e-3f * radius);
            const auto on_disc = reached(hanging(Kind::point, ball(radius, true)));
            ASSERT_TRUE(on_disc);
            EXPECT_NEAR(dot(*on_disc - center, normalize(center - p)), 0, 1e-5f);
            EXPECT_LE(length(*on_disc - center), radius * (1 + 1e-5f));
        }
        const auto on_area = reached(area_lamp(1, 2, true));
        EXPECT_TRUE(p.z < 2 || !on_area);  // near ellipses may draw nothing, too
        if (!on_area)
            continue;
        EXPECT_NEAR(on_area->z, 2, 1e-5f);
        EXPECT_LE(sqr(on_area->x / 0.5f) + sqr(on_area->y), 1 + 1e-5f);
    }
}

TEST(LampConsistency, RaysElsewhereMiss) {
    Rng rng(22);
    for (const Lamp& lamp : all_sorts()) {
        int hits = 0;
        double fluence = 0;
        constexpr int kRays = 200000;
        const Vec3f p(0.4f, 0.3f, -0.5f);
        for (int i = 0; i < kRays; ++i) {
            const Vec3f wi = sample_sphere(rng.next2());
            const auto h = lamp.intersect({p, wi});
            EXPECT_EQ(h.has_value(), lamp.pdf(p, wi) > 0);
            if (!h)
                continue;
            ++hits;
            fluence += double{h->Le.x} * 4 * kPid / kRays;
        }
        // Blind rays find as much light as light samples: six standard errors of the hits' count, bounded
        // from above by the share of the brightest; false alarm 2e-9.
        const Estimate e = irradiance(lamp, p, {}, 100000, 23);
        EXPECT_NEAR(fluence, e.mean, fluence * 8 / std::sqrt(std::max(hits, 1)) + six_sigma(e))
            << lamp.light.index();
    }
}

TEST(LampConsistency, IntersectKeepsToTheSegment) {
    for (const Lamp& lamp : {sphere_lamp(0.5f), area_lamp(1, 1)}) {
        const auto h = lamp.intersect({{0, 0, 0}, kUp});
        ASSERT_TRUE(h);
        EXPECT_TRUE(lamp.intersect({{0, 0, 0}, kUp, 0, h->distance}));
        EXPECT_FALSE(lamp.intersect({{0, 0, 0}, kUp, 0, h->distance * 0.999f}));
        EXPECT_FALSE(lamp.intersect({{0, 0, 0}, kUp, h->distance * 1.001f, 1000}));
        EXPECT_FALSE(lamp.intersect({{0, 0, 0}, -kUp}));
    }
    LampDescription d = lamp_of(Kind::sun);
    d.angle = 0.1f;
    EXPECT_TRUE(prepare_lamp(d).intersect({{0, 0, 0}, kUp}));
    EXPECT_FALSE(prepare_lamp(d).intersect({{0, 0, 0}, kUp, 0, 1e30f})) << "a sun lies beyond every surface";
}

TEST(LampConsistency, DeltaLampsCannotBeHit) {
    for (const Kind kind : {Kind::point, Kind::spot, Kind::sun, Kind::area}) {
        LampDescription d = lamp_of(kind);
        if (kind == Kind::area)
            d.spread = 0;
        place(d, {0, 0, 2});
        const Lamp lamp = prepare_lamp(d);
        EXPECT_TRUE(lamp.delta());
        EXPECT_FALSE(lamp.intersect({{0, 0, 0}, kUp}));
        const auto s = lamp.sample(Vec3f{0, 0, 0}, {0.3f, 0.7f});
        ASSERT_TRUE(s);
        EXPECT_TRUE(s->delta);
        EXPECT_EQ(s->pdf, 1);
    }
}

// --- Numbers -----------------------------------------------------------------------------------------------

TEST(LampNumbers, NothingIsEverNonFinite) {
    Rng rng(44);
    for (const Lamp& lamp : all_sorts()) {
        for (int i = 0; i < 20000; ++i) {
            const float scale = std::pow(10.0f, 24 * rng.next() - 12);
            const Vec3f p = Vec3f(0, 0, 2) + sample_sphere(rng.next2()) * scale;
            const float weight = lamp.importance(p);
            ASSERT_TRUE(std::isfinite(weight) && weight >= 0);
            const auto s = lamp.sample(p, rng.next2());
            if (!s)
                continue;
            ASSERT_TRUE(is_finite(s->wi) && is_finite(s->Li) && std::isfinite(s->pdf) && s->pdf > 0) << scale;
            ASSERT_TRUE(is_finite(s->Li / s->pdf));
            ASSERT_GT(weight, 0) << "a lamp that contributes has importance";
        }
        const auto at_center = lamp.sample(Vec3f{0, 0, 2}, {0.5f, 0.5f});
        EXPECT_TRUE(!at_center || (is_finite(at_center->wi) && is_finite(at_center->Li / at_center->pdf)));
    }
}

// --- Importance and preparation
// ------------------------------------------------------------------------------

TEST(LampImportance, IsCloseToTheFluence) {
    Rng rng(51);
    for (const Lamp& lamp : all_sorts()) {
        for (int i = 0; i < 40; ++i) {
            const Vec3f p = Vec3f(0, 0, 2) + sample_sphere(rng.next2()) * (1.5f + 10 * rng.next());
            const Estimate e = irradiance(lamp, p, {}, 4000, 52);
            if (e.mean == 0)
                continue;
            EXPECT_GT(lamp.importance(p), 0.3 * e.mean) << lamp.light.index() << ' ' << i;
            // Balls half in a cone's edge and points at a narrow beam's rim may be overrated.
            const bool soft_edges = std::holds_alternative<SpotLight>(lamp.light) ||
                                    std::holds_alternative<AreaLight>(lamp.light);
            EXPECT_TRUE(soft_edges || lamp.importance(p) < 3 * e.mean) << lamp.light.index() << ' ' << i;
        }
    }
}

TEST(LampPreparation, LampsWithoutExtentAreDark) {
    LampDescription d = lamp_of(Kind::area);
    d.size_y = 0;
    EXPECT_TRUE(is_zero(prepare_lamp(d).power()));
    d = lamp_of(Kind::spot);
    place(d, {}, {}, {1, 0, 1});
    EXPECT_TRUE(is_zero(prepare_lamp(d).power()));
}

TEST(LampPreparation, MirroredAreaLampsStillShineAlongMinusZ) {
    LampDescription d = lamp_of(Kind::area);
    place(d, {0, 0, 2}, {}, {-1, 1, 1});
    EXPECT_TRUE(prepare_lamp(d).sample(Vec3f{0, 0, 0}, {0.5f, 0.5f}));
    place(d, {0, 0, 2}, {}, {1, 1, -1});
    EXPECT_FALSE(prepare_lamp(d).sample(Vec3f{0, 0, 0}, {0.5f, 0.5f}));
}

TEST(LampPreparation, FaultsNameTheLamp) {
    for (const auto& spoil : std::vector<std::function<void(LampDescription&)>>{
             [](LampDescription& d) { d.power.y = -1; }, [](LampDescription& d) { d.power.x = NAN; },
             [](LampDescription& d) { d.radius = -1; },
             [](LampDescription& d) { d.world_from_light[3] = INFINITY; }}) {
        LampDescription d = lamp_of(Kind::point);
        d.name = "Key";
        spoil(d);
        try {
            prepare_lamp(d);
            ADD_FAILURE() << "accepted";
        } catch (const std::invalid_argument& e) {
            EXPECT_NE(std::string(e.what()).find("'Key'"), std::string::npos) << e.what();
        }
    }
}

}  // namespace
}  // namespace nephele::test
