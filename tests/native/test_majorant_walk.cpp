// SPDX-License-Identifier: GPL-3.0-or-later
// Walks of rays through both accelerators, against the grids that they bound.
#include "grids/majorant_walk.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "grid_fixtures.h"
#include "grids/majorants.h"
#include "math/warp.h"

namespace nephele {
namespace {

using namespace test;

class WalkThrough : public testing::TestWithParam<Accelerator> {
  protected:
    Majorants majorants_of(const BrickGrid& grid, float sigma_scale, bool with_minorants = false,
                           Filter filter = Filter::trilinear) const {
        return {CellBounds::of_grid(grid, filter), GetParam(), sigma_scale, with_minorants};
    }
};
INSTANTIATE_TEST_SUITE_P(Accelerators, WalkThrough, testing::Values(Accelerator::grid, Accelerator::kdtree),
                         [](const auto& suite) {
                             return suite.param == Accelerator::grid ? "Grid" : "KdTree";
                         });

/// Points of a piece: its ends, next to them, and random ones.
float point_of_piece(int s, float t, float end, Rng& rng) {
    switch (s) {
        case 0:
            return t;
        case 1:
            return end;
        case 2:
            return std::nextafter(t, end);
        case 3:
            return std::nextafter(end, t);
        default:
            return t + rng.next() * (end - t);
    }
}

TEST_P(WalkThrough, PiecesCoverTheRayAndBoundEveryLookup) {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        const GridPtr grid = random_grid(seed);
        const Filter filter = kFilters[seed % 3];
        const float sigma_scale = std::array{1e-4f, 0.01f, 1.0f, 1e3f}[seed / 2 % 4];
        const Majorants majorants = majorants_of(*grid, sigma_scale, seed % 5 != 0, filter);
        Rng rng(seed + 1000);
        for (int n = 0; n < 120; ++n) {
            const TestRay ray = random_ray(rng, majorants);
            AnyMajorantWalk walk(majorants, ray.o, ray.d, ray.t_min, ray.t_max);
            MajorantPiece piece;
            float t = ray.t_min;
            int pieces = 0;
            while (walk.next(piece)) {
                ASSERT_GT(piece.t_end, t) << describe(ray, t);
                ASSERT_LE(piece.t_end, ray.t_max) << describe(ray, t);
                ASSERT_LT(++pieces, 1000) << describe(ray, t);
                const float end = std::min(piece.t_end, t + 1000);  // a finite part of infinite pieces
                for (int s = 0; s < 8; ++s) {
                    const float at = point_of_piece(s, t, end, rng);
                    expect_bounded(*grid, filter, walk.point(at), walk.minorant(), piece.majorant, rng,
                                   describe(ray, at));
                    if (HasFatalFailure())
                        return;
                }
                t = piece.t_end;
            }
            ASSERT_EQ(t, ray.t_min < ray.t_max ? ray.t_max : ray.t_min) << describe(ray, t);
        }
    }
}

TEST_P(WalkThrough, LookupPointsStayOnTheRayButForRounding) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const GridPtr grid = random_grid(seed);
        const Majorants majorants = majorants_of(*grid, 0.05f);
        Rng rng(seed + 2000);
        for (int n = 0; n < 200; ++n) {
            const TestRay ray = random_ray(rng, majorants);
            AnyMajorantWalk walk(majorants, ray.o, ray.d, ray.t_min, ray.t_max);
            MajorantPiece piece;
            float t = ray.t_min;
            while (walk.next(piece)) {
                const float end = std::min(piece.t_end, t + 1000);
                for (int s = 0; s < 4; ++s) {
                    const float at = t + rng.next() * (end - t);
                    const Vec3f on_ray = ray.o + ray.d * at, p = walk.point(at);
                    float rounding = 0;  // of o, d t, their sum, and of t at the ends of the piece
                    for (int a = 0; a < 3; ++a)
                        rounding = std::max({rounding, std::fabs(ray.o[a]), std::fabs(ray.d[a] * at)});
                    rounding = rounding * 0x1p-20f + 1e-5f;
                    if (length(p - on_ray) <= 2 * rounding)
                        continue;
                    // Otherwise p stands for the background: then there is nothing but background around the
                    // ray.
                    for (int c = 0; c < 8; ++c) {
                        const Vec3f q =
                            on_ray + Vec3f(c & 1 ? 1.0f : -1.0f, c & 2 ? 1.0f : -1.0f, c & 4 ? 1.0f : -1.0f) *
                                         rounding;
                        ASSERT_EQ(grid->trilinear(p), grid->background());
                        ASSERT_NEAR(grid->trilinear(q), grid->background(), 4 * 3 * 2 * rounding)
                            << describe(ray, at);
                    }
                }
                t = piece.t_end;
            }
        }
    }
}

TEST_P(WalkThrough, SkipsEmptySpaceInOnePiece) {
    // Two bricks 8000 voxels apart along x.
    BrickGridBuilder builder({{0, 0, 0}, {8007, 7, 7}}, 0, VoxelType::single_float, 2);
    builder.set_tile({0, 0, 0}, 8, 1.0f);
    builder.set_tile({8000, 0, 0}, 8, 2.0f);
    const GridPtr grid = builder.finish(0, {});
    const Majorants majorants = majorants_of(*grid, 100, true);
    for (const bool reversed : {false, true}) {
        AnyMajorantWalk walk(majorants, Vec3f(reversed ? 9000.0f : -1000.0f, 3.5f, 3.5f),
                             Vec3f(reversed ? -1.0f : 1.0f, 0, 0), 0, kInfinity);
        std::vector<MajorantPiece> pieces;
        for (MajorantPiece piece; walk.next(piece);)
            pieces.push_back(piece);
        // Emptiness, the cube of 16 that sees the first brick, emptiness, that of the second, emptiness.
        ASSERT_EQ(pieces.size(), 5u);
        for (const std::size_t empty : {0u, 2u, 4u})
            EXPECT_EQ(pieces[empty].majorant, 0.0f);
        const float rounding = GetParam() == Accelerator::grid ? 1e-5f : 2 * 0x1p-12f;
        EXPECT_NEAR(pieces[1].majorant, reversed ? 2.0f : 1.0f, rounding);
        EXPECT_NEAR(pieces[3].majorant, reversed ? 1.0f : 2.0f, rounding);
        EXPECT_EQ(pieces.back().t_end, kInfinity);
        EXPECT_NEAR(pieces[2].t_end - pieces[1].t_end, 8000.0f - 16.0f, 1.0f);
    }
}

TEST_P(WalkThrough, GridsWithoutContentAreOnePieceOfBackground) {
    for (const float background : {0.0f, 0.3f}) {
        const GridPtr grid = BrickGridBuilder({}, background, VoxelType::single_float, 0).finish(0, {});
        const Majorants majorants = majorants_of(*grid, 1, true);
        AnyMajorantWalk walk(majorants, Vec3f(-5), Vec3f(0, 1, 0), 1, kInfinity);
        MajorantPiece piece;
        ASSERT_TRUE(walk.next(piece));
        EXPECT_EQ(piece.t_end, kInfinity);
        EXPECT_EQ(piece.majorant, background);
        EXPECT_EQ(walk.minorant(), background);
        EXPECT_EQ(grid->trilinear(walk.point(3)), background);
        EXPECT_FALSE(walk.next(piece));
    }
}

TEST_P(WalkThrough, EmptyIntervalsHaveNoPieces) {
    const Majorants majorants = majorants_of(*random_grid(1), 1);
    MajorantPiece piece;
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(AnyMajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 2, 2).next(piece));
    EXPECT_FALSE(AnyMajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 3, 2).next(piece));
    EXPECT_FALSE(AnyMajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), kNan, 2).next(piece));
    EXPECT_FALSE(AnyMajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 0, kNan).next(piece));
}

TEST_P(WalkThrough, EndsAndStaysInTheTableWhateverTheRay) {
    const GridPtr grid = random_grid(1);
    const Majorants majorants = majorants_of(*grid, 1);
    const float odd[] = {
        0, -0.0f, 1e-38f, -1e-44f, 8, 1e20f, -3e38f, kInfinity, std::numeric_limits<float>::quiet_NaN()};
    Rng rng(9);
    for (int n = 0; n < 20000; ++n) {
        TestRay ray = random_ray(rng, majorants);
        for (int a = 0; a < 3; ++a) {
            if (rng.next() < 0.4f)
                ray.o[a] = odd[pick(rng, 9)];
            if (rng.next() < 0.4f)
                ray.d[a] = odd[pick(rng, 9)];
        }
        AnyMajorantWalk walk(majorants, ray.o, ray.d, ray.t_min, ray.t_max);
        int pieces = 0;
        for (MajorantPiece piece; walk.next(piece);) {
            ASSERT_LT(++pieces, 1000);
            const float t = std::min(piece.t_end, 1000.0f);
            expect_bounded(*grid, Filter::trilinear, walk.point(t), 0, piece.majorant, rng, describe(ray, t));
            if (HasFatalFailure())
                return;
        }
        ASSERT_TRUE(pieces > 0 || !(ray.t_min < ray.t_max)) << describe(ray, 0);
    }
}

}  // namespace
}  // namespace nephele
