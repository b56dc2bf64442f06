// SPDX-License-Identifier: GPL-3.0-or-later
// The majorants' optical depth along a camera ray, against sums by hand and fine quadrature.
#include <gtest/gtest.h>

#include "integrators/primary.h"
#include "media_fixtures.h"

namespace nephele::test {
namespace {

constexpr int kVoxels = 40;

/// Nearly nothing but for one thin wall.
float wall(int i, int, int) {
    return i == 20 ? 1.0f : 0.0005f;
}
float noisy(int i, int j, int k) {
    return Rng(static_cast<std::uint64_t>((i * 64 + j) * 64 + k)).next();
}

TEST(MajorantOpticalDepth, AddsConstantMediaWhereverTheyOverlap) {
    Line line({{}, {1, 0, 0}, 0, 50});
    EXPECT_EQ(majorant_optical_depth(line.segment, false), 0);
    line.add({0.25f, 0, 0}, {0.5f, 1, 0}, 2, 10);  // its largest channel, the second, counts: 8
    line.add({}, {2, 0, 0}, 9, 12);                // absorbs alone: 6
    line.add({}, {}, 0, kInfinity);                // nothing, for ever
    EXPECT_FLOAT_EQ(majorant_optical_depth(line.segment, false), 14);
    EXPECT_FLOAT_EQ(majorant_optical_depth(line.segment, true), 14);
}

TEST(MajorantOpticalDepth, StaysFiniteWhereMediaNeverEnd) {
    Line line({{}, {1, 0, 0}, 0, kInfinity});
    line.add({1e-3f, 0, 0}, {}, 0, kInfinity);
    line.add({1e-3f, 0, 0}, {}, 0, 10);
    EXPECT_EQ(majorant_optical_depth(line.segment, false), 1e6f);
}

TEST(MajorantOpticalDepth, FollowsTheLocalMajorantsOrTheGlobalOne) {
    for (const Accelerator accelerator : {Accelerator::grid, Accelerator::kdtree}) {
        Line line({{-3, 7, 30}, normalize(Vec3f(1, 0.45f, -0.3f)), 0, 50});
        const Medium& m = line.add(Rgb(0.6f), Rgb(0.2f), 0, 50, field_of(kVoxels, wall, accelerator));
        const float local = majorant_optical_depth(line.segment, false),
                    global = majorant_optical_depth(line.segment, true);
        EXPECT_GT(double{local}, Profile(line, 0, 50, 0).tau.back());
        EXPECT_LT(local, 0.6f * global);  // the wall is in a few of the cells
        EXPECT_FLOAT_EQ(global, 50 * 0.8f * m.bounds->majorants.global_majorant());
    }
}

TEST(MajorantOpticalDepth, BoundsTheDepthOfOverlappingFields) {
    Line line({{-3, 7, 30}, normalize(Vec3f(1, 0.45f, -0.3f)), 0, 50});
    line.add(Rgb(0.6f), Rgb(0.2f), 0, 50, field_of(kVoxels, noisy));
    const float one = majorant_optical_depth(line.segment, false);
    line.add_program(squared_grid(Rgb(0.3f), Rgb(0.1f), {}), 5, 45, kVoxels, noisy);
    const float both = majorant_optical_depth(line.segment, false);
    EXPECT_GT(double{both}, Profile(line, 0, 50, 0).tau.back());
    Line other({{-3, 7, 30}, normalize(Vec3f(1, 0.45f, -0.3f)), 0, 50});
    other.add_program(squared_grid(Rgb(0.3f), Rgb(0.1f), {}), 5, 45, kVoxels, noisy);
    EXPECT_NEAR(both, one + majorant_optical_depth(other.segment, false), 1e-4f * both);
}

}  // namespace
}  // namespace nephele::test
