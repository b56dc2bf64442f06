// SPDX-License-Identifier: GPL-3.0-or-later
// Random grids and rays for the tests of bounds and of walks through them.
#pragma once

#include <Imath/half.h>
#include <gtest/gtest.h>

#include <memory>
#include <sstream>
#include <string>

#include "grids/brick_grid.h"
#include "math/sampler.h"
#include "math/vec.h"

namespace nephele::test {

using GridPtr = std::shared_ptr<const BrickGrid>;

inline constexpr Filter kFilters[] = {Filter::nearest, Filter::trilinear, Filter::tricubic};

inline int pick(Rng& rng, int n) {
    return static_cast<int>(rng.next() * static_cast<float>(n));
}

/// Bricks, cells, blocks and voids at random, around the origin of index space.
inline GridPtr random_grid(std::uint64_t seed) {
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
template <class Source>
TestRay random_ray(Rng& rng, const Source& source) {
    TestRay ray;
    const int kind = pick(rng, 8);
    const Vec3f lo = source.support_min(), size = source.support_max() - lo + Vec3f(1);
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

/// Checks that nothing a filter can return at p exceeds the bounds: its value, the voxels at the ends of what
/// the stochastic lookup can pick, and some others.
inline void expect_bounded(const BrickGrid& grid, Filter filter, Vec3f p, float minorant, float majorant,
                           Rng& rng, const std::string& where) {
    const float value = grid.evaluate(filter, p);
    ASSERT_LE(value, majorant) << where;
    ASSERT_GE(value, minorant) << where;
    const Vec3f f(p.x - std::floor(p.x), p.y - std::floor(p.y), p.z - std::floor(p.z));
    for (int c = 0; c < 16; ++c) {
        Vec3f u(c & 1 ? 0 : kOneMinusEpsilon, c & 2 ? 0 : kOneMinusEpsilon, c & 4 ? 0 : kOneMinusEpsilon);
        if (c & 8)
            u = filter == Filter::trilinear ? Vec3f(c & 1 ? 0 : f.x, c & 2 ? 0 : f.y, c & 4 ? 0 : f.z)
                                            : Vec3f(rng.next(), rng.next(), rng.next());
        const float v = grid.stochastic(filter, p, u);
        ASSERT_LE(v, majorant) << where;
        ASSERT_GE(v, minorant) << where;
    }
}

inline std::string describe(const TestRay& r, float t) {
    std::ostringstream s;
    s.precision(9);
    s << "o " << r.o.x << ' ' << r.o.y << ' ' << r.o.z << " d " << r.d.x << ' ' << r.d.y << ' ' << r.d.z
      << " in [" << r.t_min << ", " << r.t_max << "] at " << t;
    return s.str();
}

}  // namespace nephele::test
