// SPDX-License-Identifier: GPL-3.0-or-later
#include "math/transform.h"
#include "math/warp.h"
#include "stability.h"

namespace nephele::stability {
namespace {

TEST(StabilityMath, Normalize) {
    Worst worst({"math", "vec.h", "a / |a|", "the square of a short or long vector is no float",
                 "squares outside [1e-30, 1e30] are taken of the vector over its largest component",
                 "|a| from 1e-37 to 1e38", "unit length", 3e-7});
    Rng rng(1);
    for (const float size : logarithmic(1e-37, 1e38, 2000)) {
        for (int i = 0; i < 5; ++i) {
            const Vec3f a = random_direction(rng) * size, got = normalize(a), safe = safe_normalize(a);
            const Exact3 want = unit(Exact3(a));
            worst.error(length(Exact3(got) - want), {size});
            worst.error(length(Exact3(safe) - want), {size});
        }
    }
    EXPECT_EQ(safe_normalize(Vec3f(0)), Vec3f(0));
}

TEST(StabilityMath, Length) {
    Worst worst({"math", "vec.h", "|a|", "the square of a short or long vector is no float", "the same",
                 "|a| from 1e-37 to 3e38", "the length", 2e-7});
    Rng rng(2);
    for (const float size : logarithmic(1e-37, 1.9e38, 5000)) {
        const Vec3f a = random_direction(rng) * size;
        worst.relative(double{length(a)}, length(Exact3(a)), {size});
    }
    EXPECT_EQ(length(Vec3f(0)), 0);
    EXPECT_EQ(length(Vec3f(kInfinity, 0, 0)), kInfinity);
}

TEST(StabilityMath, Frame) {
    Worst worst({"math", "transform.h", "orthonormal frame around n",
                 "1 / (1 + n.z) cancels where n is about -z", "the sign of n.z: the sum is never below 1",
                 "20000 directions, and as near to the poles as floats can tell", "1", 1.5e-7});
    Rng rng(3);
    const auto check = [&](Vec3f n) {
        const Frame f(n);
        const Exact3 x(f.x), y(f.y), z(f.z);
        for (const Exact e : {dot(x, y), dot(y, z), dot(z, x), dot(x, x) - 1, dot(y, y) - 1})
            worst.error(e, {n.x, n.y, n.z});
    };
    for (int i = 0; i < 20000; ++i)
        check(random_direction(rng));
    for (const float theta : logarithmic(1e-30, 1, 500)) {
        for (const double pole : {0.0, M_PI})
            check(at_angle(std::fabs(pole - double{theta}), double{rng.next()} * 6.28));
    }
    check({0, 0, 1});
    check({0, 0, -1});
    check({0, 0, -0.0f});
}

TEST(StabilityMath, RayOffset) {
    Worst worst({"math", "transform.h", "point off its surface (offset_point)",
                 "a fixed step is nothing far from the origin and much near it",
                 "a step of 256 units in the last place, fixed below 1/32 m", "|p| from 0 to 1e30 m",
                 "distance to the origin, at least 1/32 m", 7e-4});
    Rng rng(4);
    for (const float size : joined({0, 1e-40f}, logarithmic(1e-30, 1e30, 5000))) {
        const Vec3f n = random_direction(rng), p = random_direction(rng) * size, q = offset_point(p, n);
        const Exact3 step = Exact3(q) - Exact3(p);
        worst.scaled(double(length(step)), 0, std::fmax(static_cast<Exact>(size), 1.0L / 32), {size});
        EXPECT_GT(dot(step, Exact3(n)), 0) << size;
    }
}

TEST(StabilityMath, CosineHemisphere) {
    Worst worst({"math", "warp.h", "cosine of a cosine-weighted direction",
                 "1 - x^2 - y^2 cancels at the horizon", "(1 - r) (1 + r) of the disc's radius r", "all u",
                 "the cosine", 1.5e-7});
    Rng rng(5);
    const auto check = [&](Vec2f u) {
        const Exact a = std::fabs(2 * static_cast<Exact>(u.x) - 1),
                    b = std::fabs(2 * static_cast<Exact>(u.y) - 1);
        const Exact r = std::fmax(a, b);
        worst.relative(double{sample_cosine_hemisphere(u).z}, std::sqrt(1 - r * r), {u.x, u.y});
    };
    for (int i = 0; i < 20000; ++i)
        check(rng.next2());
    for (int i = 0; i < 200; ++i) {
        const float near = static_cast<float>(i) * 0x1p-24f;
        check({near, 0.4f});
        check({0.7f, near});
        check({1 - near, 0.3f});
    }
}

TEST(StabilityMath, Spherical) {
    Worst worst({"math", "warp.h", "direction of a cosine c (spherical)", "1 - c^2 cancels at the poles",
                 "(1 - c) (1 + c)", "all u, c to the last bit below 1", "the sine", 3e-7});
    Rng rng(6);
    const auto check = [&](float c) {
        const Vec3f w = spherical(c, rng.next());
        const Exact x = static_cast<Exact>(w.x), y = static_cast<Exact>(w.y), ec = static_cast<Exact>(c);
        worst.relative(double(std::sqrt(x * x + y * y)), std::sqrt((1 - ec) * (1 + ec)), {c});
    };
    for (int i = 0; i < 20000; ++i)
        check(1 - 2 * rng.next());
    for (int i = 0; i < 200; ++i) {
        check(1 - static_cast<float>(i) * 0x1p-24f);
        check(-1 + static_cast<float>(i) * 0x1p-24f);
    }
}

TEST(StabilityMath, Cone) {
    Worst worst({"math", "warp.h", "direction in a cone, and its density",
                 "1 - cosine of a narrow cone has no digits", "cones are kept as 1 - cosine",
                 "1 - cosine from 1e-14 to 2", "the sine; the density", 2e-7});
    Rng rng(7);
    for (const float one_minus_cos : logarithmic(1e-14, 2, 3000)) {
        const Vec2f u = rng.next2();
        const Vec3f w = sample_cone(u, one_minus_cos);
        const Exact t = static_cast<Exact>(u.x) * static_cast<Exact>(one_minus_cos);
        const Exact x = static_cast<Exact>(w.x), y = static_cast<Exact>(w.y);
        worst.relative(double(std::sqrt(x * x + y * y)), std::sqrt(t * (2 - t)), {u.x, one_minus_cos});
        worst.relative(double{cone_pdf(one_minus_cos)},
                       1 / (2 * kExactPi * static_cast<Exact>(one_minus_cos)), {one_minus_cos});
    }
}

TEST(StabilityMath, PowerHeuristic) {
    Worst worst({"math", "warp.h", "power heuristic p^2 / (p^2 + q^2)",
                 "squares of densities are no floats; 0 / 0", "1 / (1 + (q / p)^2)",
                 "densities of 0, and from 1e-38 to 1e38, infinite ratios", "1; the sum of both weights",
                 1e-7});
    const std::vector<float> densities = joined({0, 1e-45f}, logarithmic(1e-38, 1e38, 150));
    for (const float p : densities) {
        for (const float q : densities) {
            if (p == 0 && q == 0)
                continue;
            const Exact a = static_cast<Exact>(p), b = static_cast<Exact>(q);
            worst.scaled(double{power_heuristic(p, q)}, a * a / (a * a + b * b), 1, {p, q});
            worst.scaled(double{power_heuristic(p, q)} + double{power_heuristic(q, p)}, 1, 1, {p, q});
        }
    }
    EXPECT_EQ(power_heuristic(0, 0), 0);
}

TEST(StabilityMath, Equirectangular) {
    Worst worst({"math", "warp.h", "place of a direction on an equirectangular image",
                 "the arc cosine loses half of the digits at the poles", "atan2 of the sine and the cosine",
                 "20000 directions, and from 1e-20 rad to the poles", "pi rad, the image's height", 2e-7});
    Rng rng(8);
    const auto check = [&](Vec3f d) {
        const Exact x = static_cast<Exact>(d.x), y = static_cast<Exact>(d.y), z = static_cast<Exact>(d.z);
        const Vec2f uv = equirectangular_from_direction(d);
        worst.scaled(double{uv.y}, 1 - std::atan2(std::sqrt(x * x + y * y), z) / kExactPi, 1,
                     {d.x, d.y, d.z});
        worst.scaled(double{uv.x}, 0.5L - std::atan2(y, x) / (2 * kExactPi), 1, {d.x, d.y, d.z});
    };
    for (int i = 0; i < 20000; ++i)
        check(random_direction(rng));
    for (const float theta : logarithmic(1e-20, 1, 2000)) {
        for (const double pole : {0.0, M_PI})
            check(at_angle(std::fabs(pole - double{theta}), double{rng.next()} * 6.28));
    }
    check(Vec3f(1e-30f, 0, 2e-30f));
}

TEST(StabilityMath, TransformPoint) {
    Worst worst({"math", "transform.h", "A p + b of a point", "far from the origin A p and b cancel",
                 "matrices are made in double; beyond 4096 m the world is moved to the camera",
                 "scales 1e-6 to 1e6, |p| and |b| from 1e-3 to 1e6", "|A| |p| + |b|", 3e-7});
    Rng rng(9);
    for (int i = 0; i < 20000; ++i) {
        const double scale = std::pow(10, 12 * double{rng.next()} - 6);
        double m[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
        const Frame frame(random_direction(rng));
        const Vec3f rows[3] = {frame.x, frame.y, frame.z};
        const float far = std::pow(10.0f, 9 * rng.next() - 3);
        const Vec3f p = random_direction(rng) * std::pow(10.0f, 9 * rng.next() - 3);
        Exact largest = 0;
        Exact want[3];
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c)
                m[4 * r + c] = scale * double{rows[r][c]};
            m[4 * r + 3] = double{far} * (2 * double{rng.next()} - 1);
            want[r] = static_cast<Exact>(m[4 * r + 3]);
            for (int c = 0; c < 3; ++c)
                want[r] += static_cast<Exact>(m[4 * r + c]) * static_cast<Exact>(p[c]);
            largest = std::fmax(largest, std::fabs(static_cast<Exact>(m[4 * r + 3])));
        }
        const Exact size = static_cast<Exact>(scale) * length(Exact3(p)) + largest;
        const Vec3f got = transform_of(m).point(p);
        for (int r = 0; r < 3; ++r)
            worst.scaled(double{got[r]}, want[r], size, {scale, far});
    }
}

TEST(StabilityMath, Inverse) {
    Worst worst({"math", "transform.cpp", "inverse of a placement",
                 "the determinant is no float; cofactors cancel",
                 "in double where a scene is made; in float only for what moves",
                 "scales 1e-9 to 1e9, axes up to 1 : 100", "|A| |A^-1|, the condition", 5e-7});
    Rng rng(10);
    for (int i = 0; i < 20000; ++i) {
        const double scale = std::pow(10, 18 * double{rng.next()} - 9);
        const Frame a(random_direction(rng)), b(random_direction(rng));
        const Vec3f left[3] = {a.x, a.y, a.z}, right[3] = {b.x, b.y, b.z};
        const double stretch[3] = {scale, scale * std::pow(10, 2 * double{rng.next()}),
                                   scale * std::pow(10, 2 * double{rng.next()})};
        double m[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
        for (int r = 0; r < 3; ++r) {
            for (int c = 0; c < 3; ++c) {
                for (int k = 0; k < 3; ++k)
                    m[4 * r + c] += double{left[k][r]} * stretch[k] * double{right[k][c]};
            }
        }
        const Transform t = transform_of(m);
        const double condition =
            *std::max_element(stretch, stretch + 3) / *std::min_element(stretch, stretch + 3);
        for (const Transform& inverse : {inverse_of(m), inverse_of(t)}) {
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c) {
                    Exact sum = r == c ? -1 : 0;
                    for (int k = 0; k < 3; ++k) {
                        sum += static_cast<Exact>(inverse.row[static_cast<std::size_t>(r)][k]) *
                               static_cast<Exact>(t.row[static_cast<std::size_t>(k)][c]);
                    }
                    worst.error(sum / static_cast<Exact>(condition), {scale, condition});
                }
            }
        }
    }
}

TEST(StabilityMath, Exponential) {
    Worst worst({"math", "sampler.h", "free flight: -log(u)",
                 "log(0); a u of 24 bits ends at 17 mean free paths", "u of 32 bits, never 0, in double",
                 "all of the generator's numbers", "the distance", 1e-7});
    Rng rng(11), same(11);
    float least = 1, most = 0;
    for (int i = 0; i < 1000000; ++i) {
        const Exact u = (static_cast<Exact>(same.next_uint()) + 0.5L) * 0x1p-32L;
        const float x = rng.next_exponential();
        worst.relative(double{x}, -std::log(u), {double(u)});
        least = std::min(least, x);
        most = std::max(most, x);
    }
    EXPECT_GT(least, 0);
    EXPECT_LT(most, 24);
}

}  // namespace
}  // namespace nephele::stability
