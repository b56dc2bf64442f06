// SPDX-License-Identifier: GPL-3.0-or-later
// Irradiance of lamps against closed forms, up to extreme distances.
#include <gtest/gtest.h>

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

// --- Closed forms
// -------------------------------------------------------------------------------------------

double radiance_of_sphere(double r) {
    return 1000 / (4 * kPid * kPid * r * r);
}

TEST(LampIrradiance, Sphere) {  // pi L (r/d)^2 cos, while the whole sphere is above the horizon
    const Vec3f n = normalize(Vec3f(0.3f, 0, 1));
    const Estimate e = irradiance(sphere_lamp(0.5f), {0, 0, 0}, n, 100000, 31);
    EXPECT_NEAR(e.mean, kPid * radiance_of_sphere(0.5) / 16 * double{n.z}, six_sigma(e));
}

TEST(LampIrradiance, InsideASphere) {  // radiance L from everywhere: pi L, whatever the place and the normal
    for (const Vec3f p : {Vec3f(0, 0, 2), Vec3f(1, 0.5f, 0), Vec3f(0, 0, -0.999f)}) {
        const Estimate e = irradiance(sphere_lamp(3), p, normalize(Vec3f(1, 2, -0.5f)), 200000, 32);
        EXPECT_NEAR(e.mean, kPid * radiance_of_sphere(3), six_sigma(e));
        const Estimate fluence = irradiance(sphere_lamp(3), p, {}, 1000, 33);
        EXPECT_NEAR(fluence.mean, 4 * kPid * radiance_of_sphere(3), six_sigma(fluence));
    }
}

/// Irradiance of a polygon of radiance L (Lambert 1760); corners relative to the receiver, above its horizon.
double polygon_irradiance(const std::vector<Vec3f>& corners, Vec3f n, double L) {
    double sum = 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vec3f a = corners[i], b = corners[(i + 1) % corners.size()], c = cross(a, b);
        sum += std::atan2(double{length(c)}, double{dot(a, b)}) * double{dot(normalize(c), n)};
    }
    return std::fabs(L / 2 * sum);
}

TEST(LampIrradiance, Rectangle) {
    for (const Vec3f p :
         {Vec3f(0, 0, 0), Vec3f(0.3f, -0.8f, 1.2f), Vec3f(4, 3, 1.5f), Vec3f(0.1f, 0.1f, 1.99f)}) {
        const std::vector<Vec3f> corners{Vec3f(-0.5f, -1, 2) - p, Vec3f(0.5f, -1, 2) - p,
                                         Vec3f(0.5f, 1, 2) - p, Vec3f(-0.5f, 1, 2) - p};
        const Estimate e = irradiance(area_lamp(1, 2), p, kUp, 200000, 34);
        EXPECT_NEAR(e.mean, polygon_irradiance(corners, kUp, 1000 / (2 * kPid)), six_sigma(e, 1e-4));
    }
}

TEST(LampIrradiance, DiscOnItsAxis) {  // pi L sin^2
    for (const double h : {0.01, 0.5, 2.0, 40.0}) {
        const Estimate e =
            irradiance(area_lamp(1, 1, true), {0, 0, static_cast<float>(2 - h)}, kUp, 100000, 35);
        const double L = 1000 / (kPid * kPid / 4);
        EXPECT_NEAR(e.mean, kPid * L * 0.25 / (0.25 + h * h), six_sigma(e, 1e-4)) << h;
    }
}

TEST(LampIrradiance, SpreadKeepsTheFlux) {  // irradiance over a wide plane adds up to the power
    for (const float spread : {20.0f, 90.0f, 140.0f}) {
        const Lamp lamp = area_lamp(0.5f, 0.5f, false, spread);
        // Rings of the plane one metre below, out to where the spread ends, by the midpoint rule in the
        // tangent.
        const double reach = std::tan(0.5 * spread * kDegree) + 0.5;
        constexpr int kRings = 400;
        double flux = 0, variance = 0;
        for (int i = 0; i < kRings; ++i) {
            const double r = reach * (i + 0.5) / kRings;
            const float turn = 2.399963f * static_cast<float>(i);  // golden angle: the lamp is square
            const Estimate e = irradiance(
                lamp, {static_cast<float>(r) * std::cos(turn), static_cast<float>(r) * std::sin(turn), 1},
                kUp, 4000, 36 + static_cast<std::uint64_t>(i));
            const double ring = 2 * kPid * r * reach / kRings;
            flux += e.mean * ring;
            variance += sqr(static_cast<float>(e.error * ring));
        }
        EXPECT_NEAR(flux, 1000, 6 * std::sqrt(variance) + 5) << spread;
    }
}

// --- Extremes
// ------------------------------------------------------------------------------------------------

TEST(LampExtremes, SphereAtAnyDistance) {
    for (const double ratio : {1 + 1e-6, 1.001, 10.0, 1e3, 1e6, 1e9, 1e12}) {  // distance / radius
        for (const double r : {1e-6, 1.0, 1e6}) {
            const double d = ratio * r;
            const Lamp lamp = sphere_lamp(static_cast<float>(r), {0, 0, static_cast<float>(d)});
            const Estimate e = irradiance(lamp, {}, kUp, 20000, 41);
            const double exact = 1000 / (4 * kPid * d * d);
            EXPECT_NEAR(e.mean, exact, six_sigma(e, 1e-3)) << ratio << ' ' << r;
        }
    }
}

TEST(LampExtremes, RectangleAtAnyDistance) {
    for (const double ratio : {1e-6, 1e-3, 1.0, 9.9, 10.1, 1e3, 1e6, 1e9}) {  // distance / side, on the axis
        for (const double side : {1e-6, 1.0, 1e6}) {
            LampDescription d = lamp_of(Kind::area);
            d.size_x = d.size_y = static_cast<float>(side);
            place(d, {0, 0, static_cast<float>(ratio * side)});
            const Estimate e = irradiance(prepare_lamp(d), {}, kUp, 20000, 42);
            const auto h = static_cast<float>(0.5 / ratio);  // half side over distance
            const double form = polygon_irradiance({{-h, -h, 1}, {h, -h, 1}, {h, h, 1}, {-h, h, 1}}, kUp, 1);
            const double exact = 1000 / (kPid * side * side) * (ratio < 1e3 ? form : 1 / (ratio * ratio));
            EXPECT_NEAR(e.mean, exact, six_sigma(e, 1e-3)) << ratio << ' ' << side;
        }
    }
}

TEST(LampExtremes, RectangleSeenNearlyEdgeOn) {
    for (const float height : {1e-6f, 1e-4f, 1e-2f}) {
        const Vec3f p(2, 0.2f, 2 - height);  // height rounds to the spacing of floats near 2
        const float h = 2 - p.z;
        const Vec3f toward = normalize(Vec3f(-1, 0, 0.2f));
        const std::vector<Vec3f> corners{
            {-2.5f, -1.2f, h}, {-1.5f, -1.2f, h}, {-1.5f, 0.8f, h}, {-2.5f, 0.8f, h}};
        const Estimate e = irradiance(area_lamp(1, 2), p, toward, 100000, 43);
        const double n_z_part = double{toward.z};
        // By Lambert's formula in double: the corners nearly lie in one plane with p.
        double sum = 0;
        for (std::size_t i = 0; i < 4; ++i) {
            const Vec3f a = corners[i], b = corners[(i + 1) % 4];
            const double c[3] = {double{a.y} * b.z - double{a.z} * b.y, double{a.z} * b.x - double{a.x} * b.z,
                                 double{a.x} * b.y - double{a.y} * b.x};
            const double l = std::sqrt(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
            const double ab = double{a.x} * b.x + double{a.y} * b.y + double{a.z} * b.z;
            sum +=
                std::atan2(l, ab) * (c[0] * double{toward.x} + c[1] * double{toward.y} + c[2] * n_z_part) / l;
        }
        EXPECT_NEAR(e.mean, std::fabs(1000 / (2 * kPid) / 2 * sum), six_sigma(e, 1e-3)) << height;
    }
}

}  // namespace
}  // namespace nephele::test
