// SPDX-License-Identifier: GPL-3.0-or-later
// Measures lookups in brick grids and steps through majorant grids, in nanoseconds, one thread.
//
//     grid_lookup FILE.vdb GRID [OPTICAL_THICKNESS]    a grid of a file
//     grid_lookup                                      a procedural cloud of 512^3 voxels
//
// Rays cross the grid's box in uniformly random directions; points lie in order along them, as a tracker
// visits them. OPTICAL_THICKNESS is that of the box's longest edge at the grid's largest value.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <vector>

#include "math/sampler.h"
#include "math/warp.h"
#include "grids/brick_grid.h"
#include "grids/majorant_grid.h"
#include "grids/vdb_file.h"

namespace {

using namespace nephele;

struct IndexRay {
    Vec3f o, d;
    float length;
};

/// Processor time of this thread: other programs disturb it least.
template <typename F>
double seconds(const F& f) {
    const auto now = [] {
        timespec t{};
        clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
        return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
    };
    const double start = now();
    f();
    return now() - start;
}

std::shared_ptr<const BrickGrid> procedural_cloud(VoxelType type) {
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

std::vector<IndexRay> random_rays(const IndexBox& box, int count) {
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

/// Points in order along rays, only those inside the box.
std::vector<Vec3f> points_along(const std::vector<IndexRay>& rays, const IndexBox& box, float spacing) {
    Rng rng(2);
    std::vector<Vec3f> points;
    for (const IndexRay& ray : rays) {
        for (float t = 0; t < ray.length; t += spacing * rng.next_exponential()) {
            const Vec3f p = ray.o + ray.d * t;
            bool in = true;
            for (int a = 0; a < 3; ++a) {
                in &= p[a] >= static_cast<float>(box.min[static_cast<std::size_t>(a)]) &&
                      p[a] <= static_cast<float>(box.max[static_cast<std::size_t>(a)]);
            }
            if (in)
                points.push_back(p);
        }
    }
    return points;
}

void measure_lookups(const BrickGrid& grid) {
    const std::vector<IndexRay> rays = random_rays(grid.bounds(), 20000);
    const std::vector<Vec3f> points = points_along(rays, grid.bounds(), 4);
    double sum = 0;
    const auto report = [&](const char* name, const auto& value_at) {
        double best = 1e9;
        for (int repeat = 0; repeat < 5; ++repeat) {
            best = std::min(best, seconds([&] {
                                float previous =
                                    0;  // each point waits for the value before it, as in a tracker
                                for (const Vec3f& p : points)
                                    previous = value_at(p + Vec3f(previous * 1e-30f));
                                sum += static_cast<double>(previous);
                            }));
        }
        std::printf("  %-24s %6.1f ns\n", name, best * 1e9 / static_cast<double>(points.size()));
    };
    Rng rng(3);
    report("lookup",
           [&](Vec3f p) { return grid.lookup(floor_to_int(p.x), floor_to_int(p.y), floor_to_int(p.z)); });
    report("stochastic",
           [&](Vec3f p) { return grid.stochastic(p, Vec3f(rng.next(), rng.next(), rng.next())); });
    report("trilinear", [&](Vec3f p) { return grid.trilinear(p); });
    std::printf("  (checksum %g over %zu points)\n", sum, points.size());
}

void measure_walk(const BrickGrid& grid, float thickness) {
    float edge = 0, largest = 0;
    for (std::size_t a = 0; a < 3; ++a)
        edge = std::max(edge, static_cast<float>(grid.bounds().max[a] - grid.bounds().min[a] + 1));
    largest = MajorantGrid(grid, 1).global_majorant();
    const float sigma_scale = thickness / (edge * largest);
    std::unique_ptr<MajorantGrid> majorants;
    const double build = seconds([&] { majorants = std::make_unique<MajorantGrid>(grid, sigma_scale); });
    const std::vector<IndexRay> rays = random_rays(grid.bounds(), 100000);
    double steps = 0, tau = 0, set_up = 1e9, walk = 1e9, track = 1e9, candidates = 0, sum = 0;
    for (int repeat = 0; repeat < 3; ++repeat) {
        set_up = std::min(set_up, seconds([&] {
                              for (const IndexRay& ray : rays)
                                  sum += static_cast<double>(
                                      MajorantWalk(*majorants, ray.o, ray.d, 0, ray.length).point(1).x);
                          }));
        steps = tau = 0;
        walk = std::min(walk, seconds([&] {
                            for (const IndexRay& ray : rays) {
                                MajorantWalk walk_of_ray(*majorants, ray.o, ray.d, 0, ray.length);
                                MajorantPiece piece;
                                float t = 0;
                                while (walk_of_ray.next(piece)) {
                                    tau +=
                                        static_cast<double>((piece.t_end - t) * piece.majorant * sigma_scale);
                                    t = piece.t_end;
                                    steps += 1;
                                }
                            }
                        }));
        candidates = 0;
        Rng rng(4);
        track = std::min(track, seconds([&] {  // ratio tracking to the end
                             for (const IndexRay& ray : rays) {
                                 MajorantWalk walk_of_ray(*majorants, ray.o, ray.d, 0, ray.length);
                                 MajorantPiece piece;
                                 float t = 0, transmittance = 1, depth = rng.next_exponential();
                                 while (walk_of_ray.next(piece)) {
                                     const float rate = piece.majorant * sigma_scale;
                                     while ((piece.t_end - t) * rate > depth) {
                                         t += depth / rate;
                                         depth = rng.next_exponential();
                                         const Vec3f p = walk_of_ray.point(t);
                                         const float value =
                                             grid.stochastic(p, Vec3f(rng.next(), rng.next(), rng.next()));
                                         transmittance *= 1 - value / piece.majorant;
                                         candidates += 1;
                                     }
                                     depth -= (piece.t_end - t) * rate;
                                     t = piece.t_end;
                                 }
                                 sum += static_cast<double>(transmittance);
                             }
                         }));
    }
    const auto n = static_cast<double>(rays.size());
    std::printf(
        "  thickness %-8g build %.1f ms, %.1f KiB; set-up %.1f ns; %.1f pieces a ray, %.1f ns each; majorant "
        "depth %.2f a "
        "ray, %.1f candidates, %.1f ns each (checksum %g)\n",
        static_cast<double>(thickness), build * 1e3, static_cast<double>(majorants->bytes()) / 1024,
        set_up * 1e9 / n, steps / n, (walk - set_up) * 1e9 / steps, tau / n, candidates / n,
        candidates > 0 ? (track - walk) * 1e9 / candidates : 0, sum);
}

void describe(const BrickGrid& grid) {
    const double bricks = static_cast<double>(grid.brick_count());
    std::printf(
        "  %lld active voxels, %zu bricks, %.2f MiB: %.2f bytes per active voxel, fill ratio %.2f, %s\n",
        static_cast<long long>(grid.active_voxels()), grid.brick_count(),
        static_cast<double>(grid.bytes()) / 1048576,
        static_cast<double>(grid.bytes()) / static_cast<double>(grid.active_voxels()),
        static_cast<double>(grid.active_voxels()) / (bricks * 512),
        grid.voxel_type() == VoxelType::half_float ? "half" : "float");
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const auto run = [&](const BrickGrid& grid) {
            describe(grid);
            measure_lookups(grid);
            for (const float thickness : {0.1f, 1.0f, 10.0f, 100.0f, 1000.0f})
                measure_walk(grid, thickness);
        };
        if (argc >= 3) {
            LoadedGrid loaded;
            const double load = seconds([&] { loaded = load_grid(argv[1], argv[2]); });
            std::printf("%s %s: loaded in %.1f ms\n", argv[1], argv[2], load * 1e3);
            for (const std::string& warning : loaded.warnings)
                std::printf("%s\n", warning.c_str());
            if (!loaded.grid)
                return 2;
            run(*loaded.grid);
            return 0;
        }
        for (const VoxelType type : {VoxelType::single_float, VoxelType::half_float}) {
            std::printf("procedural cloud\n");
            run(*procedural_cloud(type));
        }
    } catch (const std::exception& e) {
        std::fprintf(stderr, "grid_lookup: %s\n", e.what());
        return 2;
    }
}
