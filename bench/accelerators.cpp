// SPDX-License-Identifier: GPL-3.0-or-later
// Compares majorant grid and kd-tree: a table in Markdown, one thread.
//
//     accelerators FOLDER    the volumes listed below, as far as FOLDER has them, and a procedural cloud
//
// Rays cross each grid's box in random directions. The density is scaled until those that meet the object
// have the mean optical thickness tau. Per ray: pieces of the walk; candidates of its whole Poisson process;
// nanoseconds of the bare walk, of ratio tracking to the ray's end, and of delta tracking to its first
// collision. Building starts from CellBounds, whose own time is told apart.
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "grid_rays.h"
#include "grids/majorants.h"
#include "grids/vdb_file.h"
#include "math/sampler.h"

namespace {

using namespace nephele;
using namespace nephele::bench;

constexpr struct {
    const char* name;
    const char* file;
    const char* grid;
} kVolumes[] = {
    {"Disney cloud at 1/16", "wdas_cloud_sixteenth.vdb", "density"},
    {"openvdb.org smoke1", "openvdb_smoke1.vdb", "density"},
    {"smoke 51x49x96", "usd_smoke_000003.vdb", "density"},
    {"dragon 70x49x31", "sergeneren_dragon.vdb", "density"},
};

/// Mean optical thickness per unit of sigma_scale over those rays that have any.
double mean_depth(const BrickGrid& grid, const std::vector<IndexRay>& rays) {
    double sum = 0, hits = 0;
    for (std::size_t n = 0; n < rays.size(); n += 50) {
        double depth = 0;
        for (float t = 0.5f; t < rays[n].length; t += 1)
            depth += static_cast<double>(grid.trilinear(rays[n].o + rays[n].d * t));
        sum += depth;
        hits += depth > 0;
    }
    return sum / hits;
}

struct Cost {
    double pieces = 0, candidates = 0, walk = 1e9, ratio = 1e9, delta = 1e9;  // per ray; seconds
};

/// Ratio tracking to the end of the ray, or delta tracking to its first collision.
template <class Walk, bool kDelta>
float track(const BrickGrid& grid, const Majorants& majorants, float sigma_scale, const IndexRay& ray,
            Rng& rng, double& candidates) {
    Walk walk(majorants, ray.o, ray.d, 0, ray.length);
    MajorantPiece piece;
    float t = 0, transmittance = 1, depth = rng.next_exponential();
    while (walk.next(piece)) {
        const float rate = piece.majorant * sigma_scale;
        while ((piece.t_end - t) * rate > depth) {
            t += depth / rate;
            depth = rng.next_exponential();
            candidates += 1;
            const float value = grid.stochastic(walk.point(t), rng.next3());
            if (kDelta && rng.next() * piece.majorant < value)
                return t;
            transmittance *= 1 - value / piece.majorant;
        }
        depth -= (piece.t_end - t) * rate;
        t = piece.t_end;
    }
    return transmittance;
}

Cost measure(const BrickGrid& grid, const Majorants& majorants, float sigma_scale,
             const std::vector<IndexRay>& rays) {
    using Walk = AnyMajorantWalk;
    Cost cost;
    double sum = 0, ignored = 0;
    for (int repeat = 0; repeat < 5; ++repeat) {
        cost.pieces = cost.candidates = 0;
        cost.walk = std::min(cost.walk, seconds([&] {
                                 for (const IndexRay& ray : rays) {
                                     Walk walk(majorants, ray.o, ray.d, 0, ray.length);
                                     for (MajorantPiece piece; walk.next(piece); cost.pieces += 1)
                                         sum += static_cast<double>(piece.majorant);
                                 }
                             }));
        Rng rng(4);
        cost.ratio = std::min(cost.ratio, seconds([&] {
                                  for (const IndexRay& ray : rays)
                                      sum += static_cast<double>(track<Walk, false>(
                                          grid, majorants, sigma_scale, ray, rng, cost.candidates));
                              }));
        cost.delta = std::min(cost.delta, seconds([&] {
                                  for (const IndexRay& ray : rays)
                                      sum += static_cast<double>(
                                          track<Walk, true>(grid, majorants, sigma_scale, ray, rng, ignored));
                              }));
    }
    if (!(sum > 0))
        std::fprintf(stderr, "accelerators: nothing was met\n");
    for (double* value : {&cost.pieces, &cost.candidates, &cost.walk, &cost.ratio, &cost.delta})
        *value /= static_cast<double>(rays.size());
    return cost;
}

void compare(const std::string& name, const BrickGrid& grid) {
    const std::vector<IndexRay> rays = random_rays(grid.bounds(), 20000);
    const double depth = mean_depth(grid, rays);
    double bounds_time = 1e9;
    std::unique_ptr<CellBounds> bounds;
    for (int repeat = 0; repeat < 5; ++repeat)
        bounds_time =
            std::min(bounds_time, wall_seconds([&] {
                         bounds = std::make_unique<CellBounds>(CellBounds::of_grid(grid, Filter::trilinear));
                     }));
    std::fprintf(stderr, "%s: bounds of %zu KiB in %.2f ms\n", name.c_str(), bounds->bytes() / 1024,
                 bounds_time * 1e3);
    for (const float tau : {1.0f, 10.0f, 100.0f}) {
        const float sigma_scale = tau / static_cast<float>(depth);
        for (const Accelerator accelerator : {Accelerator::grid, Accelerator::kdtree}) {
            double build = 1e9;
            std::unique_ptr<Majorants> majorants;
            for (int repeat = 0; repeat < 5; ++repeat)
                build = std::min(build, wall_seconds([&] {
                                     majorants =
                                         std::make_unique<Majorants>(*bounds, accelerator, sigma_scale);
                                 }));
            const Cost c = measure(grid, *majorants, sigma_scale, rays);
            std::printf("| %s | %g | %s | %.2f | %.1f | %.1f | %.1f | %.0f | %.0f | %.0f |\n", name.c_str(),
                        static_cast<double>(tau), accelerator == Accelerator::grid ? "grid" : "kd-tree",
                        build * 1e3, static_cast<double>(majorants->bytes()) / 1024, c.pieces, c.candidates,
                        c.walk * 1e9, c.ratio * 1e9, c.delta * 1e9);
            std::fflush(stdout);
        }
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        const std::filesystem::path folder = argc > 1 ? argv[1] : ".";
        std::printf(
            "| volume | tau | by | build ms | KiB | pieces | candidates | walk ns | ratio ns | delta ns |\n"
            "|---|---|---|---|---|---|---|---|---|---|\n");
        for (const auto& volume : kVolumes) {
            const std::filesystem::path path = folder / volume.file;
            if (std::filesystem::exists(path)) {
                compare(volume.name, *load_grid(path.string(), volume.grid).grid);
            } else {
                std::fprintf(stderr, "accelerators: %s is not there and left out\n", path.c_str());
            }
        }
        compare("procedural cloud 512^3", *procedural_cloud(VoxelType::half_float));
    } catch (const std::exception& e) {
        std::fprintf(stderr, "accelerators: %s\n", e.what());
        return 2;
    }
}
