// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/pixel_filter.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "cell_counts.h"
#include "math/sampler.h"

namespace nephele::test {
namespace {

using Kind = PixelFilter::Kind;

/// Share of the filter between a and b, by 2000 midpoints.
double share(const PixelFilter& filter, double a, double b) {
    constexpr int kSteps = 2000;
    double sum = 0;
    for (int i = 0; i < kSteps; ++i)
        sum += filter.density(static_cast<float>(a + (b - a) * (i + 0.5) / kSteps)) * (b - a) / kSteps;
    return sum;
}

struct Shape {
    Kind kind;
    float width;
};
const Shape kShapes[] = {{Kind::box, 3},       {Kind::gaussian, 1.5f},        {Kind::gaussian, 0.01f},
                         {Kind::gaussian, 10}, {Kind::blackman_harris, 1.5f}, {Kind::blackman_harris, 3}};

TEST(PixelFilter, OffsetsFollowTheFilter) {
    for (const auto& [kind, width] : kShapes) {
        const PixelFilter filter(kind, width);
        constexpr int kCells = 60, kDraws = 1000000;
        const double reach = filter.reach();
        std::vector<double> expected;
        for (int i = 0; i < kCells; ++i)
            expected.push_back(
                share(filter, reach * (2.0 * i / kCells - 1), reach * (2.0 * (i + 1) / kCells - 1)));
        std::vector<std::uint64_t> x(kCells), y(kCells);
        Rng rng(1);
        const auto cell = [&](float v) {
            return static_cast<std::size_t>(
                std::clamp(static_cast<int>((v / reach + 1) / 2 * kCells), 0, kCells - 1));
        };
        for (int i = 0; i < kDraws; ++i) {
            const Vec2f o = filter.sample(rng.next2());
            ++x[cell(o.x)];
            ++y[cell(o.y)];
        }
        EXPECT_GT(chi_square_p(x, expected, kDraws), kFalseAlarm) << width;
        EXPECT_GT(chi_square_p(y, expected, kDraws), kFalseAlarm) << width;
    }
}

TEST(PixelFilter, IsNormalisedAndSymmetric) {
    for (const auto& [kind, width] : kShapes) {
        const PixelFilter filter(kind, width);
        EXPECT_NEAR(share(filter, -filter.reach(), filter.reach()), 1, 1e-4);
        EXPECT_EQ(filter.density(0.3f * filter.reach()), filter.density(-0.3f * filter.reach()));
        EXPECT_EQ(filter.density(1.01f * filter.reach()), 0);
        EXPECT_NEAR(filter.sample({0.25f, 0.75f}).x, -filter.sample({0.25f, 0.75f}).y, 1e-6 * filter.reach());
        EXPECT_NEAR(filter.sample({0.5f, 0}).x, 0, 1e-6);
    }
}

TEST(PixelFilter, PeaksAreTheWindowsOwn) {
    // A Blackman-Harris window is 1 in its middle and integrates to 0.35875 of its full width 2 w; half way
    // to its end it is 0.35875 - 0.14128. The Gaussian exp(-8 (x/w)^2) integrates to w sqrt(pi / 8), its
    // tails beyond 1.5 w being 2e-9.
    EXPECT_NEAR(PixelFilter(Kind::blackman_harris, 3).density(0), 1 / (0.35875 * 6), 1e-5);
    EXPECT_NEAR(PixelFilter(Kind::blackman_harris, 3).density(1.5f), (0.35875 - 0.14128) / (0.35875 * 6),
                1e-5);
    EXPECT_NEAR(PixelFilter(Kind::gaussian, 3).density(0), 1 / (3 * std::sqrt(3.14159265358979 / 8)), 1e-5);
    EXPECT_EQ(PixelFilter(Kind::box, 3).density(0.4f), 1);
}

TEST(PixelFilter, EndsStayWithinReach) {
    for (const auto& [kind, width] : kShapes) {
        const PixelFilter filter(kind, width);
        for (const float u : {0.0f, 1e-7f, 0.5f, kOneMinusEpsilon}) {
            const float x = filter.sample({u, 0.5f}).x;
            EXPECT_LE(std::fabs(x), filter.reach()) << u;
        }
    }
}

// Recorded with bpy 5.0.1: an emitter half a pixel wide in the middle of a pixel, box of 65536 samples a
// pixel; values of its own pixel and of those 1, 2 and 3 pixels beside it. A pixel sees the product of the
// filter's shares in x and in y.
struct CyclesProfile {
    Shape shape;
    double value[4];
};
TEST(PixelFilter, HasTheShapeOfCycles) {
    for (const CyclesProfile& c :
         {CyclesProfile{{Kind::box, 3}, {0.250137, 0, 0, 0}},
          CyclesProfile{{Kind::gaussian, 1.5f}, {0.244476, 0.010818, 0.000275, 0}},
          CyclesProfile{{Kind::blackman_harris, 1.5f}, {0.194366, 0.015152, 0, 0}},
          CyclesProfile{{Kind::blackman_harris, 3}, {0.052460, 0.027771, 0.003189, 0.000099}}}) {
        const PixelFilter filter(c.shape.kind, c.shape.width);
        for (int i = 0; i < 4; ++i) {
            const double expected = share(filter, i - 0.25, i + 0.25) * share(filter, -0.25, 0.25);
            // Cycles' samples: six standard deviations of a binomial, halved in variance by the two sides.
            EXPECT_NEAR(expected, c.value[i], 6 * std::sqrt(c.value[i] / 65536) + 2e-5)
                << c.shape.width << ' ' << i;
        }
    }
}

TEST(PixelFilter, RejectsWidths) {
    EXPECT_THROW(PixelFilter(Kind::gaussian, 0), std::invalid_argument);
    EXPECT_THROW(PixelFilter(Kind::gaussian, NAN), std::invalid_argument);
}

}  // namespace
}  // namespace nephele::test
