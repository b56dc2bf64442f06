// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/environment.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "cell_counts.h"
#include "math/sampler.h"
#include "math/warp.h"

namespace nephele::test {
namespace {

constexpr double kPid = 3.14159265358979323846;

/// A sky: dark below, a gradient above, a narrow bright sun.
Rgb sky(Vec3f d) {
    const float sun = dot(d, normalize(Vec3f(1, -2, 0.7f))) > 0.999f ? 500.0f : 0.0f;
    return d.z < 0 ? Rgb(0) : Rgb(0.1f + d.z, 0.2f, 0.4f - 0.3f * d.z) + Rgb(sun);
}

TEST(Environment, SamplesFollowThePdf) {
    constexpr int kWidth = 32, kHeight = 16, kDraws = 400000;
    const EnvironmentLight light(sky, kWidth, kHeight);
    // The density is constant over the cells of the grid, whose solid angles are known.
    std::vector<double> expected(kWidth * kHeight);
    for (int y = 0; y < kHeight; ++y) {
        const double solid_angle =
            2 * kPid / kWidth * (std::cos(kPid * y / kHeight) - std::cos(kPid * (y + 1) / kHeight));
        for (int x = 0; x < kWidth; ++x) {
            const Vec3f wi = direction_from_equirectangular(
                {(static_cast<float>(x) + 0.5f) / kWidth, (static_cast<float>(y) + 0.5f) / kHeight});
            expected[static_cast<std::size_t>(y * kWidth + x)] = solid_angle * double{light.pdf(wi)};
        }
    }
    double total = 0;
    for (const double e : expected)
        total += e;
    EXPECT_NEAR(total, 1, 1e-5) << "the density integrates to one";
    Rng rng(1);
    std::vector<std::uint64_t> counts(expected.size());
    for (int i = 0; i < kDraws; ++i) {
        const Vec2f uv = equirectangular_from_direction(light.sample(rng.next2()).wi);
        const int x = std::clamp(static_cast<int>(uv.x * kWidth), 0, kWidth - 1),
                  y = std::clamp(static_cast<int>(uv.y * kHeight), 0, kHeight - 1);
        ++counts[static_cast<std::size_t>(y * kWidth + x)];
    }
    EXPECT_GT(chi_square_p(counts, expected, kDraws), kFalseAlarm);
}

TEST(Environment, SampleAndPdfAgree) {
    for (const auto& [width, height] :
         {std::pair(1, 1), std::pair(7, 3), std::pair(512, 256), std::pair(2048, 1024)}) {
        const EnvironmentLight light(sky, width, height);
        Rng rng(2);
        int astray = 0;
        for (int i = 0; i < 20000; ++i) {
            const auto s = light.sample(rng.next2());
            ASSERT_NEAR(length(s.wi), 1, 1e-5);
            ASSERT_GT(s.pdf, 0);
            if (std::fabs(light.pdf(s.wi) - s.pdf) > 1e-3f * s.pdf)
                ++astray;  // rounded across a cell's edge
        }
        EXPECT_LT(astray, 40) << width;
    }
}

TEST(Environment, FindsAllTheLight) {
    // Fluence rate by light sampling against the closed form of the sky: gradient and sun (half angle acos
    // 0.999).
    const EnvironmentLight light(sky, 256, 128);
    Rng rng(3);
    double sum = 0, sum2 = 0;
    constexpr int kDraws = 400000;
    for (int i = 0; i < kDraws; ++i) {
        const auto s = light.sample(rng.next2());
        const double value = double{sky(s.wi).x} / double{s.pdf};
        sum += value;
        sum2 += value * value;
    }
    const double mean = sum / kDraws, error = std::sqrt((sum2 / kDraws - mean * mean) / kDraws);
    const double exact = 2 * kPid * (0.1 + 0.5) + 500 * 2 * kPid * 0.001;
    EXPECT_NEAR(mean, exact, 6 * error);
    EXPECT_LT(error, 0.002 * exact) << "uniform directions would give 0.02";
    // The grid of 256 x 128 sees the sun's edge with some coarseness.
    EXPECT_NEAR(double{light.mean_radiance().x} * 4 * kPid, exact, 0.05 * exact);
}

TEST(Environment, OneBrightPixelIsFound) {
    constexpr int kWidth = 2048, kHeight = 1024;
    const Vec3f bright = direction_from_equirectangular({(1000 + 0.5f) / kWidth, (600 + 0.5f) / kHeight});
    const EnvironmentLight light([&](Vec3f d) { return Rgb(dot(d, bright) > 0.999999f ? 1e6f : 1e-3f); },
                                 kWidth, kHeight);
    EXPECT_GT(light.pdf(bright), 1e4f);
    int near = 0;
    Rng rng(4);
    for (int i = 0; i < 1000; ++i)
        near += dot(light.sample(rng.next2()).wi, bright) > 0.9999f;
    EXPECT_GT(near, 900);
}

TEST(Environment, DarkDirectionsKeepAChance) {
    const EnvironmentLight light(sky, 64, 32);
    EXPECT_FLOAT_EQ(light.pdf(Vec3f(0, 0, -1)), EnvironmentLight::kUniformShare * kInv4Pi);
}

TEST(Environment, ConstantWorldsAreDrawnUniformly) {
    const EnvironmentLight light([](Vec3f) { return Rgb(0.2f, 0.3f, 0.4f); }, 64, 32);
    EXPECT_TRUE(light.constant());
    EXPECT_FALSE(light.black());
    Rng rng(5);
    Vec3f sum;
    for (int i = 0; i < 100000; ++i) {
        const auto s = light.sample(rng.next2());
        EXPECT_EQ(s.pdf, kInv4Pi);
        sum += s.wi * 1e-5f;
    }
    EXPECT_LT(length(sum), 6 / std::sqrt(100000.0));  // mean direction: false alarm below 1e-6
    EXPECT_NEAR(light.mean_radiance().y, 0.3f, 1e-6);
    EXPECT_NEAR(light.importance(), 4 * kPi * 0.3f, 1e-5);
    EXPECT_TRUE(EnvironmentLight([](Vec3f) { return Rgb(0); }, 8, 4).black());
    EXPECT_FALSE(EnvironmentLight(sky, 8, 4).constant());
}

TEST(Environment, PolesAndSeam) {
    const EnvironmentLight light(sky, 4096, 16);
    for (const Vec3f d :
         {Vec3f(0, 0, 1), Vec3f(0, 0, -1), Vec3f(-1, 0, 0), Vec3f(-1, -1e-9f, 0), Vec3f(1e-7f, 0, 1)}) {
        EXPECT_TRUE(std::isfinite(light.pdf(d)) && light.pdf(d) > 0);
    }
}

TEST(Environment, FaultyRadianceIsNamed) {
    EXPECT_THROW(EnvironmentLight([](Vec3f) { return Rgb(NAN); }, 4, 2), std::invalid_argument);
    EXPECT_THROW(EnvironmentLight([](Vec3f d) { return Rgb(d.x); }, 4, 2), std::invalid_argument);
    EXPECT_THROW(EnvironmentLight(sky, 0, 2), std::invalid_argument);
}

}  // namespace
}  // namespace nephele::test
