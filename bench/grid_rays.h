// SPDX-License-Identifier: GPL-3.0-or-later
// What the native benchmarks of grids share: a clock, a cloud, rays.
#pragma once

#include <chrono>
#include <memory>
#include <vector>

#include "grids/brick_grid.h"
#include "math/sampler.h"
#include "thread_time.h"

namespace nephele::bench {

struct IndexRay {
    Vec3f o, d;
    float length;
};

/// Processor time that f() takes, s.
template <typename F>
double seconds(const F& f) {
    const double start = thread_seconds();
    f();
    return thread_seconds() - start;
}

/// Elapsed time, for what runs on many threads.
template <typename F>
double wall_seconds(const F& f) {
    const auto start = std::chrono::steady_clock::now();
    f();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// 512^3 voxels: a rippled ball.
inline std::shared_ptr<const BrickGrid> procedural_cloud(VoxelType type) {
    constexpr int kSize = 512;
    BrickGridBuilder builder({{0, 0, 0}, {kSize - 1, kSize - 1, kSize - 1}}, 0, type,
                             (kSize / 8) * (kSize / 8) * (kSize / 8));
    float brick[BrickGrid::kBrickVoxels];
    std::int64_t active = 0;
    for (int x = 0; x < kSize; x += 8) {
        for (int y = 0; y < kSize; y += 8) {
            for (int z = 0; z < kSize; z += 8) {
                for (int v = 0; v < BrickGrid::kBrickVoxels; ++v) {
                    const Vec3f p =
                        Vec3f(static_cast<float>(x + (v >> 6)), static_cast<float>(y + (v >> 3 & 7)),
                              static_cast<float>(z + (v & 7))) *
                        (1.0f / kSize);
                    const float r = length(p - Vec3f(0.5f));
                    const float ripple = std::sin(40 * p.x) * std::sin(37 * p.y) * std::sin(43 * p.z);
                    brick[v] = std::max(0.0f, 0.45f - r + 0.2f * ripple);
                    active += brick[v] > 0;
                }
                builder.set_brick({x, y, z}, brick);
            }
        }
    }
    return builder.finish(active, {{0, 0, 0}, {kSize - 1, kSize - 1, kSize - 1}});
}

/// Rays through two uniformly random points of the box, from outside to outside.
inline std::vector<IndexRay> random_rays(const IndexBox& box, int count) {
    Rng rng(1);
    std::vector<IndexRay> rays;
    Vec3f lo, size;
    for (int a = 0; a < 3; ++a) {
        lo[a] = static_cast<float>(box.min[static_cast<std::size_t>(a)]);
        size[a] =
            static_cast<float>(box.max[static_cast<std::size_t>(a)] - box.min[static_cast<std::size_t>(a)]);
    }
    for (int n = 0; n < count; ++n) {
        const auto inside = [&] { return lo + size * Vec3f(rng.next(), rng.next(), rng.next()); };
        const Vec3f a = inside(), b = inside(), d = normalize(b - a);
        rays.push_back({a - d * length(size), d, 2 * length(size)});
    }
    return rays;
}

}  // namespace nephele::bench
