// SPDX-License-Identifier: GPL-3.0-or-later
// Measures lookups in brick grids, in nanoseconds, one thread. (Walks: accelerators.cpp.)
//
//     grid_lookup FILE.vdb GRID    a grid of a file
//     grid_lookup                  a procedural cloud of 512^3 voxels
//
// Points lie in order along random rays through the grid's box, as a tracker visits them.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <vector>

#include "grid_rays.h"
#include "grids/brick_grid.h"
#include "grids/vdb_file.h"
#include "math/sampler.h"

namespace {

using namespace nephele;
using namespace nephele::bench;

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
    report("nearest", [&](Vec3f p) { return grid.nearest(p); });
    report("tricubic, stochastic",
           [&](Vec3f p) { return grid.stochastic_tricubic(p, Vec3f(rng.next(), rng.next(), rng.next())); });
    report("tricubic", [&](Vec3f p) { return grid.tricubic(p); });
    std::printf("  (checksum %g over %zu points)\n", sum, points.size());
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
