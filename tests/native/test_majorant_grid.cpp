// SPDX-License-Identifier: GPL-3.0-or-later
// Majorant grids: bounds against brute force, and walks of rays against the grid they bound.
#include "grids/majorant_grid.h"

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "math/sampler.h"
#include "math/warp.h"

namespace nephele {
namespace {

using GridPtr = std::shared_ptr<const BrickGrid>;

int pick(Rng& rng, int n) {
    return static_cast<int>(rng.next() * static_cast<float>(n));
}

/// Bricks, cells, blocks and voids at random, around the origin of index space.
GridPtr random_grid(std::uint64_t seed) {
    Rng rng(seed);
    const float background = seed % 3 == 0 ? 0.125f : 0.0f;
    const VoxelType type = seed % 2 ? VoxelType::half_float : VoxelType::single_float;
    const auto value = [&] { return half_to_float(imath_float_to_half(rng.next() * rng.next() * 4)); };
    IndexBox extent;
    for (std::size_t a = 0; a < 3; ++a) {
        extent.min[a] = -8 * pick(rng, 40);
        extent.max[a] = extent.min[a] + 8 * (1 + pick(rng, 50)) - 1;
    }
    BrickGridBuilder builder(extent, background, type, 400);
    const auto corner = [&](int step) {
        std::array<int, 3> c;
        for (std::size_t a = 0; a < 3; ++a) {
            const int cells = (extent.max[a] - extent.min[a] + 1) / 8;
            c[a] = (extent.min[a] + 8 * pick(rng, cells)) & -step;
        }
        return c;
    };
    for (int n = pick(rng, 3); n > 0; --n)
        builder.set_tile(corner(128), 128, value());
    for (int n = pick(rng, 60); n > 0; --n)
        builder.set_tile(corner(8), 8, n % 4 ? value() : 0.0f);
    for (int n = pick(rng, 400); n > 0; --n) {
        float voxels[BrickGrid::kBrickVoxels];
        for (float& v : voxels)
            v = rng.next() < 0.7f ? 0.0f : value();
        builder.set_brick(corner(8), voxels);
    }
    return builder.finish(0, {});
}

struct TestRay {
    Vec3f o, d;
    float t_min = 0, t_max = kInfinity;
};

/// Rays that start inside, outside, far away, on faces and edges; oblique, axis-parallel, nearly so, along
/// faces.
TestRay random_ray(Rng& rng, const MajorantGrid& grid) {
    TestRay ray;
    const int kind = pick(rng, 8);
    const Vec3f lo = grid.support_min(), size = grid.support_max() - lo + Vec3f(1);
    const auto inside = [&] { return lo + size * Vec3f(rng.next(), rng.next(), rng.next()); };
    Vec3f target = inside();
    ray.o = kind & 1 ? inside() : lo + size * (Vec3f(rng.next(), rng.next(), rng.next()) * 4 - Vec3f(1.5f));
    if (kind & 2) {  // on the corners of cells
        for (int a = 0; a < 3; ++a) {
            if (rng.next() < 0.7f)
                ray.o[a] = 8 * std::floor(ray.o[a] / 8);
            if (rng.next() < 0.7f)
                target[a] = 8 * std::floor(target[a] / 8);
        }
    }
    if (kind == 0)
        ray.o = target + (ray.o - target) * 1e5f;  // positions are good to about a voxel only
    ray.d = safe_normalize(target - ray.o);
    if (kind & 4) {
        for (int a = 0; a < 3; ++a) {
            if (rng.next() < 0.5f)
                ray.d[a] = rng.next() < 0.5f ? 0 : 1e-30f;
        }
    }
    if (is_zero(ray.d))
        ray.d = {0, 0, -1};
    if (rng.next() < 0.3f)
        ray.d *= rng.next() < 0.5f ? 1e-3f : 40.0f;  // of any length
    if (rng.next() < 0.5f)
        ray.t_max = rng.next() * 2 * length(size) / length(ray.d);
    if (rng.next() < 0.3f)
        ray.t_min = std::min(ray.t_max, 300.0f) * rng.next();
    return ray;
}

/// Checks that nothing interpolation can return at p exceeds the bounds.
void expect_bounded(const BrickGrid& grid, Vec3f p, float minorant, float majorant,
                    const std::string& where) {
    const float trilinear = grid.trilinear(p);
    ASSERT_LE(trilinear, majorant) << where;
    ASSERT_GE(trilinear, minorant) << where;
    const Vec3f f(p.x - std::floor(p.x), p.y - std::floor(p.y), p.z - std::floor(p.z));
    for (int c = 0; c < 8; ++c) {
        const float v = grid.stochastic(p, Vec3f(c & 1 ? 0 : f.x, c & 2 ? 0 : f.y, c & 4 ? 0 : f.z));
        ASSERT_LE(v, majorant) << where;
        ASSERT_GE(v, minorant) << where;
    }
}

std::string describe(const TestRay& r, float t) {
    std::ostringstream s;
    s.precision(9);
    s << "o " << r.o.x << ' ' << r.o.y << ' ' << r.o.z << " d " << r.d.x << ' ' << r.d.y << ' ' << r.d.z
      << " in [" << r.t_min << ", " << r.t_max << "] at " << t;
    return s.str();
}

TEST(MajorantWalk, PiecesCoverTheRayAndBoundEveryLookup) {
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
        const GridPtr grid = random_grid(seed);
        const float sigma_scale = std::array{1e-4f, 0.01f, 1.0f, 1e3f}[seed / 2 % 4];
        const MajorantGrid majorants(*grid, sigma_scale, seed % 5 != 0);
        Rng rng(seed + 1000);
        for (int n = 0; n < 200; ++n) {
            const TestRay ray = random_ray(rng, majorants);
            MajorantWalk walk(majorants, ray.o, ray.d, ray.t_min, ray.t_max);
            MajorantPiece piece;
            float t = ray.t_min;
            int pieces = 0;
            while (walk.next(piece)) {
                ASSERT_GT(piece.t_end, t) << describe(ray, t);
                ASSERT_LE(piece.t_end, ray.t_max) << describe(ray, t);
                ASSERT_LT(++pieces, 1000) << describe(ray, t);
                const float end = std::min(piece.t_end, t + 1000);  // a finite part of infinite pieces
                for (int s = 0; s < 8; ++s) {
                    float at = t + rng.next() * (end - t);
                    if (s == 0)
                        at = t;
                    if (s == 1)
                        at = end;
                    if (s == 2)
                        at = std::nextafter(t, end);
                    if (s == 3)
                        at = std::nextafter(end, t);
                    const Vec3f p = walk.point(at);
                    expect_bounded(*grid, p, walk.minorant(), piece.majorant, describe(ray, at));
                    if (HasFatalFailure())
                        return;
                }
                t = piece.t_end;
            }
            ASSERT_EQ(t, ray.t_min < ray.t_max ? ray.t_max : ray.t_min) << describe(ray, t);
        }
    }
}

TEST(MajorantWalk, LookupPointsStayOnTheRayButForRounding) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const GridPtr grid = random_grid(seed);
        const MajorantGrid majorants(*grid, 0.05f);
        Rng rng(seed + 2000);
        for (int n = 0; n < 200; ++n) {
            const TestRay ray = random_ray(rng, majorants);
            MajorantWalk walk(majorants, ray.o, ray.d, ray.t_min, ray.t_max);
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

TEST(MajorantGrid, UnmergedBoundsAreThoseOfTheNineCubedVoxels) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const GridPtr grid = random_grid(seed);
        const MajorantGrid majorants(*grid, 1e9f, true);  // so dense that no step is worth saving
        for (int x = 0; x < majorants.cells()[0]; ++x) {
            for (int y = 0; y < majorants.cells()[1]; ++y) {
                for (int z = 0; z < majorants.cells()[2]; ++z) {
                    float most = 0, least = kInfinity;
                    for (int v = 0; v < 729; ++v) {
                        const auto& o = majorants.origin();
                        const float value = grid->lookup(o[0] + 8 * x + v / 81, o[1] + 8 * y + v / 9 % 9,
                                                         o[2] + 8 * z + v % 9);
                        most = std::max(most, value);
                        least = std::min(least, value);
                    }
                    const auto bound = majorants.bound_at(x, y, z);
                    ASSERT_GE(bound.majorant, most);
                    ASSERT_LE(bound.minorant, least);
                    // Where equal values were merged, the bounds are as good; otherwise only rounding is
                    // added.
                    ASSERT_LE(bound.majorant, most * (1 + 0x1p-19f));
                    ASSERT_GE(bound.minorant, least - most * 0x1p-19f);
                    if (most == least) {
                        ASSERT_EQ(bound.majorant, bound.minorant);  // values here are halves: no rounding up
                    }
                }
            }
        }
    }
}

TEST(MajorantGrid, MergesInThinMediaOnly) {
    const GridPtr grid = random_grid(4);
    const MajorantGrid thin(*grid, 1e-9f), dense(*grid, 1e9f);
    bool coarse = false, fine = false;
    for (int x = 0; x < thin.cells()[0]; ++x) {
        for (int y = 0; y < thin.cells()[1]; ++y) {
            for (int z = 0; z < thin.cells()[2]; ++z) {
                ASSERT_EQ(thin.bound_at(x, y, z).level, 4);
                ASSERT_GE(thin.bound_at(x, y, z).majorant, dense.bound_at(x, y, z).majorant);
                coarse |= thin.bound_at(x, y, z).majorant > dense.bound_at(x, y, z).majorant;
                fine |= dense.bound_at(x, y, z).level == 0;
            }
        }
    }
    EXPECT_TRUE(coarse);
    EXPECT_TRUE(fine);
    EXPECT_LT(thin.bytes(), dense.bytes());
}

TEST(MajorantGrid, GlobalBoundsAreThoseOfAllVoxels) {
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        const GridPtr grid = random_grid(seed);
        const MajorantGrid majorants(*grid, 1, true);
        float most = grid->background(), least = grid->background();
        const IndexBox& b = grid->bounds();
        for (int i = b.min[0]; i <= b.max[0]; ++i) {
            for (int j = b.min[1]; j <= b.max[1]; ++j) {
                for (int k = b.min[2]; k <= b.max[2]; ++k) {
                    most = std::max(most, grid->lookup(i, j, k));
                    least = std::min(least, grid->lookup(i, j, k));
                }
            }
        }
        EXPECT_GE(majorants.global_majorant(), most);
        EXPECT_LE(majorants.global_majorant(), most * (1 + 0x1p-19f));
        EXPECT_LE(majorants.global_minorant(), least);
        GlobalMajorantWalk walk(majorants, Vec3f(0), Vec3f(1, 0, 0), 2, 7);
        MajorantPiece piece;
        ASSERT_TRUE(walk.next(piece));
        EXPECT_EQ(piece.t_end, 7.0f);
        EXPECT_EQ(piece.majorant, majorants.global_majorant());
        EXPECT_EQ(walk.point(3).x, 3.0f);
        EXPECT_FALSE(walk.next(piece));
        EXPECT_FALSE(GlobalMajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 7, 7).next(piece));
    }
}

TEST(MajorantWalk, SkipsEmptySpaceInOnePiece) {
    // Two bricks 8000 voxels apart along x.
    BrickGridBuilder builder({{0, 0, 0}, {8007, 7, 7}}, 0, VoxelType::single_float, 2);
    builder.set_tile({0, 0, 0}, 8, 1.0f);
    builder.set_tile({8000, 0, 0}, 8, 2.0f);
    const GridPtr grid = builder.finish(0, {});
    const MajorantGrid majorants(*grid, 100, true);
    for (const bool reversed : {false, true}) {
        MajorantWalk walk(majorants, Vec3f(reversed ? 9000.0f : -1000.0f, 3.5f, 3.5f),
                          Vec3f(reversed ? -1.0f : 1.0f, 0, 0), 0, kInfinity);
        std::vector<MajorantPiece> pieces;
        for (MajorantPiece piece; walk.next(piece);)
            pieces.push_back(piece);
        // Emptiness, the cube of 16 that sees the first brick, emptiness, that of the second, emptiness.
        ASSERT_EQ(pieces.size(), 5u);
        for (const std::size_t empty : {0u, 2u, 4u})
            EXPECT_EQ(pieces[empty].majorant, 0.0f);
        EXPECT_NEAR(pieces[1].majorant, reversed ? 2.0f : 1.0f, 1e-5f);
        EXPECT_NEAR(pieces[3].majorant, reversed ? 1.0f : 2.0f, 1e-5f);
        EXPECT_EQ(pieces.back().t_end, kInfinity);
        EXPECT_NEAR(pieces[2].t_end - pieces[1].t_end, 8000.0f - 16.0f, 1.0f);
    }
}

TEST(MajorantWalk, GridsWithoutContentAreOnePieceOfBackground) {
    for (const float background : {0.0f, 0.3f}) {
        const GridPtr grid = BrickGridBuilder({}, background, VoxelType::single_float, 0).finish(0, {});
        const MajorantGrid majorants(*grid, 1, true);
        MajorantWalk walk(majorants, Vec3f(-5), Vec3f(0, 1, 0), 1, kInfinity);
        MajorantPiece piece;
        ASSERT_TRUE(walk.next(piece));
        EXPECT_EQ(piece.t_end, kInfinity);
        EXPECT_EQ(piece.majorant, background);
        EXPECT_EQ(walk.minorant(), background);
        EXPECT_EQ(grid->trilinear(walk.point(3)), background);
        EXPECT_FALSE(walk.next(piece));
    }
}

TEST(MajorantWalk, EmptyIntervalsHaveNoPieces) {
    const MajorantGrid majorants(*random_grid(1), 1);
    MajorantPiece piece;
    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    EXPECT_FALSE(MajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 2, 2).next(piece));
    EXPECT_FALSE(MajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 3, 2).next(piece));
    EXPECT_FALSE(MajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), kNan, 2).next(piece));
    EXPECT_FALSE(MajorantWalk(majorants, Vec3f(0), Vec3f(1, 0, 0), 0, kNan).next(piece));
}

TEST(MajorantWalk, EndsAndStaysInTheTableWhateverTheRay) {
    const GridPtr grid = random_grid(1);
    const MajorantGrid majorants(*grid, 1);
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
        MajorantWalk walk(majorants, ray.o, ray.d, ray.t_min, ray.t_max);
        int pieces = 0;
        for (MajorantPiece piece; walk.next(piece);) {
            ASSERT_LT(++pieces, 1000);
            const float t = std::min(piece.t_end, 1000.0f);
            expect_bounded(*grid, walk.point(t), 0, piece.majorant, describe(ray, t));
            if (HasFatalFailure())
                return;
        }
        ASSERT_TRUE(pieces > 0 || !(ray.t_min < ray.t_max)) << describe(ray, 0);
    }
}

}  // namespace
}  // namespace nephele
