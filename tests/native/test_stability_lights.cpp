// SPDX-License-Identifier: GPL-3.0-or-later
// Lamps, emissive triangles, the world, and the choice among them.
#include "light_fixtures.h"
#include "lights/environment.h"
#include "lights/light_set.h"
#include "lights/spherical_triangle.h"
#include "math/warp.h"
#include "stability.h"

namespace nephele::stability {
namespace {

Exact exact(float x) {
    return static_cast<Exact>(x);
}
Exact squared(Exact x) {
    return x * x;
}

TEST(StabilityLights, BallDensity) {
    Worst worst({"lights", "ball.h", "solid angle of a sphere, as a density",
                 "1 - cos of a far one has no digits; sqrt(1 - sin^2) of a near one few",
                 "sin^2 / (1 + cos); below a sine of 1e-7 it is a point",
                 "distances from 1 + 1e-6 to 1e6 radii, radii 1e-4 to 1e4 m", "the density", 7e-5});
    Rng rng(1);
    for (const float above : logarithmic(1e-6, 1e6, 3000)) {
        const float r = std::pow(10.0f, 8 * rng.next() - 4);
        const Ball ball{Vec3f(0), r, true};
        const Vec3f p = random_direction(rng) * (r * (1 + above));
        const Exact d = length(Exact3(p)), sin2 = squared(exact(r) / d);
        if (ball.contains(p) || !(sin2 < 1))
            continue;
        const auto s = ball.sample(p, rng.next2());
        ASSERT_TRUE(s && !s->point);
        const Exact cosine = std::sqrt((d - exact(r)) * (d + exact(r))) / d;
        worst.relative(double{s->pdf}, (1 + cosine) / (2 * kExactPi * sin2), {above, r});
    }
}

TEST(StabilityLights, BallMisses) {
    Worst worst({"lights", "ball.h", "sampled directions that miss the ball",
                 "d^2 - (d cos)^2 cancels for far balls", "the vector across the ray, by subtraction",
                 "sines 1e-5 to 1, the inner 90 % of the cone", "1, of the directions", 1e-9});
    Rng rng(2);
    for (const float far : logarithmic(1.01, 1e5, 3000)) {
        const Ball ball{Vec3f(1, 2, 3), 1, true};
        const Vec3f p = Vec3f(1, 2, 3) + random_direction(rng) * far;
        for (int i = 0; i < 4; ++i) {
            const auto s = ball.sample(p, {0.9f * rng.next(), rng.next()});
            const auto hit = ball.hit(p, s->wi);
            worst.error(hit.has_value() ? 0 : 1, {far});
            if (hit) {
                EXPECT_NEAR(double{hit->pdf} / double{s->pdf}, 1, 1e-6) << far;
            }
        }
    }
}

TEST(StabilityLights, DiscDensity) {
    Worst worst({"lights", "ball.h", "density of the disc that faces the point",
                 "area to solid angle by a cosine that is lost", "distance^3 / (d pi r^2)",
                 "distances 1e-3 to 1e6 radii", "the density", 5e-7});
    Rng rng(3);
    for (const float far : logarithmic(1e-3, 1e6, 3000)) {
        const Ball ball{Vec3f(0), 2, false};
        const Vec3f p = random_direction(rng) * (2 * far);
        const auto s = ball.sample(p, rng.next2());
        ASSERT_TRUE(s);
        const Exact d = length(Exact3(p)), distance = exact(s->distance);
        worst.relative(double{s->pdf}, squared(distance) * distance / (d * kExactPi * 4), {far});
    }
}

TEST(StabilityLights, SpotFalloff) {
    Worst worst({"lights", "spot.h", "soft edge of a spot's cone",
                 "cos - cos(edge) of a narrow cone has no digits", "differences of 1 - cosine, by the sine",
                 "cones 1e-4 rad to pi, blend 0.1 to 1", "1, of the falloff", 5e-6});
    Rng rng(4);
    for (const float size : logarithmic(1e-4, 3.1, 2000)) {
        for (const float blend : {0.1f, 0.5f, 1.0f}) {
            LampDescription d = test::lamp_of(test::Kind::spot);
            d.spot_size = size;
            d.spot_blend = blend;
            const SpotLight spot = SpotLight::prepare(d);
            const Vec3f down =
                at_angle(0.5 * double{size} * 1.1 * double{rng.next()}, 6 * double{rng.next()});
            const Vec3f w(down.x, down.y, -down.z);
            const auto one_minus_cos = [](Exact theta) { return 2 * squared(std::sin(theta / 2)); };
            const Exact edge = one_minus_cos(exact(size) / 2);
            const Exact inside = edge - one_minus_cos(angle(Exact3(w), {0, 0, -1}));
            const Exact x = std::fmin(std::fmax(inside / (edge * exact(blend)), 0.0L), 1.0L);
            worst.error(exact(spot.falloff(w)) - x * x * (3 - 2 * x), {size, blend});
        }
    }
}

TEST(StabilityLights, SunDisc) {
    Worst worst({"lights", "sun.h", "solid angle and radiance of a sun's disc",
                 "1 - cos(angle / 2) of a small disc; sin^2 beyond a hemisphere",
                 "2 sin^2(angle / 4); below 1e-7 rad a direction, at most a hemisphere",
                 "angles 2e-7 rad to pi", "the value", 5e-7});
    for (const float size : logarithmic(2.1e-7, M_PI, 3000)) {
        LampDescription d = test::lamp_of(test::Kind::sun, 3);
        d.angle = size;
        const SunLight sun = SunLight::prepare(d);
        const Exact half = exact(size) / 2;
        worst.relative(double{sun.one_minus_cos}, 2 * squared(std::sin(half / 2)), {size});
        worst.relative(double{sun.emission.x}, 3 / (kExactPi * squared(std::sin(half))), {size});
    }
}

/// Solid angle of a rectangle from below its corner (0, 0) to (x, y), signed.
Exact corner(Exact x, Exact y, Exact h) {
    return std::atan2(x * y, h * std::sqrt(x * x + y * y + h * h));
}
Exact rectangle(Exact x0, Exact x1, Exact y0, Exact y1, Exact h) {
    return corner(x1, y1, h) - corner(x0, y1, h) - corner(x1, y0, h) + corner(x0, y0, h);
}

TEST(StabilityLights, RectangleSolidAngle) {
    Worst worst({"lights", "spherical_rectangle.h", "solid angle of a rectangle",
                 "arc sines near 1 lose half of their digits at a grazing height; four angles cancel",
                 "arc tangents of the corners, in double; below 1e-6 sr the area is sampled",
                 "sizes 1e-3 to 10, heights 1e-9 to 1e3, feet in and out of it", "the solid angle", 7e-10});
    Worst uniform({"lights", "spherical_rectangle.h", "point of a rectangle, uniform in solid angle",
                   "the same", "the same; the point as an offset from the foot",
                   "the same, solid angles from 1e-4", "1, of the solid angle on one side", 5e-7});
    Rng rng(5);
    for (int i = 0; i < 100000; ++i) {
        const double w = std::pow(10, 4 * double{rng.next()} - 3),
                     v = std::pow(10, 4 * double{rng.next()} - 3);
        const double x0 = w * (3 * double{rng.next()} - 2), y0 = v * (3 * double{rng.next()} - 2);
        const double height = std::pow(10, 12 * double{rng.next()} - 9);
        const SphericalRectangle r(x0, x0 + w, y0, y0 + v, height);
        if (!(r.solid_angle() > 0))
            continue;
        const auto left = static_cast<Exact>(x0), right = static_cast<Exact>(x0 + w),
                   low = static_cast<Exact>(y0), high = static_cast<Exact>(y0 + v),
                   h = static_cast<Exact>(height);
        const Exact want = rectangle(left, right, low, high, h);
        worst.relative(r.solid_angle(), want, {x0, w, y0, v, height});
        if (want < 1e-4L)
            continue;
        const Vec2f u = rng.next2(), on = r.sample(u);
        EXPECT_TRUE(double{on.x} >= x0 - 1e-6 * w && double{on.x} <= x0 + w * (1 + 1e-6));
        // The point as a float moves the share by the density there.
        const Exact share = rectangle(left, exact(on.x), low, high, h) / want;
        const Exact next = rectangle(left, exact(std::nextafter(on.x, 1e9f)), low, high, h) / want;
        uniform.error(std::fmax(0.0L, std::fabs(share - exact(u.x)) - std::fabs(next - share)),
                      {x0, w, y0, v, height, u.x});
    }
}

/// Solid angle of a spherical triangle of unit vectors (Van Oosterom and Strackee).
Exact triangle(Exact3 a, Exact3 b, Exact3 c) {
    return 2 * std::atan2(std::fabs(dot(a, cross(b, c))), 1 + dot(a, b) + dot(b, c) + dot(c, a));
}

TEST(StabilityLights, TriangleSolidAngle) {
    Worst worst({"lights", "spherical_triangle.h", "solid angle of a triangle", "angles less pi cancel",
                 "the arc tangent of Van Oosterom and Strackee, in double; below 1e-4 sr the area is sampled",
                 "triangles of 1e-3 to 1e3 m from 0.01 to 5 sizes away, slivers too", "the solid angle",
                 1e-7});
    Worst uniform({"lights", "spherical_triangle.h", "point of a triangle, uniform in solid angle",
                   "the same", "the same; barycentric weights", "the same",
                   "1, of the solid angle on one side", 1.5e-4});
    Rng rng(6);
    for (int i = 0; i < 100000; ++i) {
        const float size = std::pow(10.0f, 6 * rng.next() - 3),
                    thin = i % 3 == 0 ? std::pow(10.0f, -4 * rng.next()) : 1.0f;
        const Vec3f from = random_direction(rng) * (size * std::pow(10.0f, 2.7f * rng.next() - 2));
        const Vec3f a = from + random_direction(rng) * size, b = from + random_direction(rng) * size,
                    c = a + random_direction(rng) * (size * thin);
        const SphericalTriangle t(a, b, c);
        if (!t.usable())
            continue;
        const Exact3 ea = unit(Exact3(a)), eb = unit(Exact3(b)), ec = unit(Exact3(c));
        const Exact want = triangle(ea, eb, ec);
        worst.relative(double{t.solid_angle()}, want, {size, thin});
        const Vec2f u = rng.next2();
        const Vec3f w = t.sample(u);
        EXPECT_TRUE(w.x >= 0 && w.y >= 0 && w.z >= 0);
        // The great circle from b through the point meets the side from a to c.
        const Exact3 d = Exact3(a) * exact(w.x) + Exact3(b) * exact(w.y) + Exact3(c) * exact(w.z);
        const Exact3 on = cross(cross(eb, d), cross(ea, ec));
        const Exact3 meets = unit(dot(on, ea + ec) < 0 ? on * -1 : on);
        if (exact(w.x) + exact(w.z) > 1e-2L)
            uniform.error(triangle(ea, eb, meets) / want - exact(u.x), {size, thin, u.x, u.y});
    }
}

TEST(StabilityLights, Distribution) {
    Worst worst({"lights", "distribution.cpp", "probability of one of a million, and where u lies in it",
                 "sums in single precision stop to grow; a u of 24 bits is coarser than the probabilities",
                 "running sums in double, u of 32 bits",
                 "a million weights of 1e-6 to 1, and the same beside one of 1e6", "the probability and 1e-9",
                 2e-7});
    Rng rng(7);
    const auto off = [&](float got, Exact want, std::initializer_list<double> at) {
        worst.scaled(double{got}, want, want + 1e-9L, at);
    };
    for (const float huge : {1.0f, 1e6f}) {
        std::vector<float> weights(1000000);
        Exact total = 0;
        for (float& w : weights)
            w = std::pow(10.0f, -6 * rng.next());
        weights[500000] = huge;
        for (const float w : weights)
            total += exact(w);
        const DiscreteDistribution d(weights);
        for (std::size_t i = 0; i < weights.size(); i += 97)
            off(d.probability(i), exact(weights[i]) / total, {huge, double(i)});
        for (int i = 0; i < 100000; ++i) {
            const auto choice = d.sample(rng.next_uint() * 0x1p-32);
            off(choice.probability, exact(weights[choice.index]) / total, {huge});
            EXPECT_TRUE(choice.u >= 0 && choice.u < 1);
        }
    }
}

TEST(StabilityLights, Selection) {
    Worst worst({"lights", "light_tree.h, light_set.cpp",
                 "probability of the light chosen, against the probability asked for",
                 "products of many branches; weights that are no floats",
                 "in double; a branch of no weight at all is even",
                 "1000 lamps of 1e-20 to 1e20 W in 1 km, near and 1e6 m away", "the probability", 3e-8});
    Rng rng(8);
    for (const float spread : {0.0f, 5.0f, 20.0f}) {
        std::vector<Lamp> lamps;
        for (int i = 0; i < 1000; ++i) {
            auto d = test::lamp_of(test::Kind::point, std::pow(10.0f, spread * (2 * rng.next() - 1)));
            test::place(d, random_direction(rng) * (1000 * rng.next()));
            d.radius = rng.next();
            lamps.push_back(prepare_lamp(d));
        }
        const LightSet lights(lamps, {}, nullptr);
        for (const float far : logarithmic(1, 1e6, 200)) {
            const Vec3f p = random_direction(rng) * far;
            Exact sum = 0;
            for (std::uint32_t i = 0; i < 1000; ++i)
                sum += exact(lights.selection_pdf(p, i));
            worst.error(sum - 1, {spread, far});
            for (int i = 0; i < 20; ++i) {
                float probability = 0;
                const auto light = lights.select(p, rng.next_uint() * 0x1p-32, probability);
                if (light)
                    worst.relative(double{probability}, exact(lights.selection_pdf(p, *light)),
                                   {spread, far});
            }
        }
    }
}

TEST(StabilityLights, FaintLampsKeepAProbability) {
    std::vector<Lamp> lamps;
    Rng rng(9);
    for (int i = 0; i < 100; ++i) {
        auto d = test::lamp_of(test::Kind::point, 1e-36f);
        test::place(d, random_direction(rng) * 100);
        lamps.push_back(prepare_lamp(d));
    }
    const LightSet lights(lamps, {}, nullptr);
    float probability = 0;
    const Vec3f p(1e6f, 0, 0);
    if (const auto light = lights.select(p, 0.3, probability)) {
        EXPECT_TRUE(probability > 0 && probability <= 1);
        EXPECT_NEAR(double{lights.selection_pdf(p, *light)}, double{probability}, 1e-6);
    }
}

TEST(StabilityLights, Environment) {
    Worst worst({"lights", "environment.cpp", "cell of the world in which a sampled direction lies",
                 "acos has half of its digits at the poles; the uppermost rows are 1e-7 high",
                 "atan2 in double; rows by their cosines", "2048 x 1024 cells, a million directions",
                 "1, of the directions in the neighbouring cell", 1.5e-5});
    Rng rng(10);
    const EnvironmentLight world([&](Vec3f) { return Rgb(rng.next() + 0.01f); }, 2048, 1024);
    int other = 0;
    constexpr int kDraws = 1000000;
    Exact integral = 0;
    for (int i = 0; i < kDraws; ++i) {
        const auto s = world.sample(Vec2d{rng.next_uint() * 0x1p-32, rng.next_uint() * 0x1p-32});
        EXPECT_GT(s.pdf, 0);
        other += std::fabs(world.pdf(s.wi) / s.pdf - 1) > 1e-5f;
        integral += 1 / (4 * kExactPi * exact(s.pdf));
    }
    worst.error(static_cast<Exact>(other) / kDraws);
    EXPECT_NEAR(static_cast<double>(integral) / kDraws, 1, 0.01);
}

}  // namespace
}  // namespace nephele::stability
