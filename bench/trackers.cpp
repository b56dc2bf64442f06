// SPDX-License-Identifier: GPL-3.0-or-later
// Free flights and transmittance estimators side by side: variance times cost in thin, thick, sparse and
// spiky media, as markdown tables.
//
//     trackers [FILE.vdb GRID OPTICAL_THICKNESS]...
//
// Rays join random points of opposite faces of the medium's box. Each is estimated many times by every
// method; variance is that of one estimate on one ray, averaged over rays and channels, cost the processor
// time of this thread. What counts is their product, here relative to the first method's: less is better.
// Means that differ from the first method's by more than 5 standard errors are marked.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <string>
#include <vector>

#include "grids/vdb_file.h"
#include "thread_time.h"
#include "tracking/free_flight.h"
#include "tracking/transmittance.h"

namespace {

using namespace nephele;
using bench::thread_seconds;

struct TestMedium {
    std::string name;
    std::shared_ptr<const BrickGrid> grid;
    Rgb sigma_s, sigma_a;  ///< per voxel length
};

constexpr int kSize = 96;

TestMedium procedural(const char* name, Rgb sigma_s, Rgb sigma_a,
                      const std::function<float(Vec3f)>& density) {
    std::vector<float> values;
    for (int x = 0; x < kSize; ++x) {
        for (int y = 0; y < kSize; ++y) {
            for (int z = 0; z < kSize; ++z)
                values.push_back(
                    density(Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)) *
                            (1.0f / kSize)));
        }
    }
    return {name, brick_grid_of_dense({0, 0, 0}, {kSize, kSize, kSize}, values.data()), sigma_s, sigma_a};
}

float cloud(Vec3f p) {
    const float ripple = std::sin(20 * p.x) * std::sin(17 * p.y) * std::sin(23 * p.z);
    return std::max(0.0f, 0.5f - length(p - Vec3f(0.5f)) + 0.15f * ripple) * 2;
}
/// A few small balls.
float sparse(Vec3f p) {
    Rng rng(7);
    float d = 0;
    for (int i = 0; i < 12; ++i) {
        const Vec3f centre(rng.next(), rng.next(), rng.next());
        d = std::max(d, 1 - length(p - centre) / 0.06f);
    }
    return d;
}
/// Thin dense sheets in nearly nothing.
float spiky(Vec3f p) {
    const float wave = std::sin(30 * p.x + 9 * p.y) * std::sin(11 * p.y - 25 * p.z);
    return wave > 0.98f ? 1.0f : 0.01f;
}
float haze(Vec3f p) {
    return 0.7f + 0.3f * cloud(p);
}

std::vector<TestMedium> procedural_media() {
    constexpr float kPerVoxel = 1.0f / kSize;
    const auto grey = [&](float tau) { return Rgb(tau * kPerVoxel); };
    const Rgb unlike(1, 0.3f, 0.1f);
    return {procedural("thin (tau 0.1)", grey(0.1f), Rgb(0), cloud),
            procedural("medium (tau 3)", grey(3), Rgb(0), cloud),
            procedural("thick (tau 30)", grey(30), Rgb(0), cloud),
            procedural("sparse (tau 10)", grey(10), Rgb(0), sparse),
            procedural("spiky (tau 30)", grey(30), Rgb(0), spiky),
            procedural("haze (tau 3)", grey(3), Rgb(0), haze),
            procedural("chromatic (tau 10, 3, 1)", unlike * grey(10), Rgb(0), cloud),
            procedural("chromatic haze (tau 3, 1, .3), albedo .5", unlike * grey(1.5f), unlike * grey(1.5f),
                       haze)};
}

TestMedium file_medium(const char* path, const char* grid, float tau) {
    const LoadedGrid loaded = load_grid(path, grid);
    if (!loaded.grid)
        throw std::runtime_error(std::string(path) + " has no usable grid " + grid);
    const IndexBox& box = loaded.grid->active_bounds();
    int longest = 0;
    float largest = CellBounds::of_grid(*loaded.grid, Filter::trilinear).global().max;
    for (std::size_t a = 0; a < 3; ++a)
        longest = std::max(longest, box.max[a] - box.min[a] + 1);
    std::string name(path);
    name = name.substr(name.rfind('/') + 1) + " (tau " + std::to_string(static_cast<int>(tau)) + ")";
    return {name, loaded.grid, Rgb(tau / (largest * static_cast<float>(longest))), Rgb(0)};
}

std::vector<Ray> random_rays(const IndexBox& box, int count) {
    Rng rng(1);
    Vec3f lo, size;
    for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        lo[a] = static_cast<float>(box.min[i]);
        size[a] = static_cast<float>(box.max[i] - box.min[i]);
    }
    std::vector<Ray> rays;
    for (int n = 0; n < count; ++n) {
        Vec3f a(rng.next(), rng.next(), rng.next()), b(rng.next(), rng.next(), rng.next());
        a[n % 3] = 0;
        b[n % 3] = 1;
        const Vec3f from = lo + a * size, to = lo + b * size;
        rays.push_back({from, normalize(to - from), 0, length(to - from)});
    }
    return rays;
}

struct Method {
    std::string name;
    std::function<Rgb(const Segment&, Rng&, Counters&)> estimate;
};

struct Figures {
    double variance = 0, lookups = 0, nanoseconds = 0, mean = 0, error = 0;
};

constexpr int kRays = 1000, kRepeats = 400;

Figures measure(const Method& method, const Medium& medium, const std::vector<Ray>& rays) {
    Figures out;
    Counters counters;
    Rng rng(3);
    double error2 = 0;
    const double start = thread_seconds();
    for (const Ray& ray : rays) {
        Segment segment;
        segment.ray = ray;
        segment.intervals = {{&medium, ray.t_min, ray.t_max}};
        double sum[3] = {}, sum2[3] = {};
        for (int n = 0; n < kRepeats; ++n) {
            const Rgb x = method.estimate(segment, rng, counters);
            for (int c = 0; c < 3; ++c) {
                sum[c] += double{x[c]};
                sum2[c] += double{x[c]} * double{x[c]};
            }
        }
        for (int c = 0; c < 3; ++c) {
            const double mean = sum[c] / kRepeats;
            const double variance = (sum2[c] / kRepeats - mean * mean) * kRepeats / (kRepeats - 1);
            out.variance += variance / (3.0 * kRays);
            out.mean += mean / (3.0 * kRays);
            error2 += variance / kRepeats;
        }
    }
    out.nanoseconds = (thread_seconds() - start) * 1e9 / (double{kRays} * kRepeats);
    out.lookups = static_cast<double>(counters.density_lookups) / (double{kRays} * kRepeats);
    out.error = std::sqrt(error2) / (3.0 * kRays);
    return out;
}

void print_table(const char* title, const std::vector<Method>& methods,
                 const std::vector<TestMedium>& media) {
    std::printf("\n| %s | method | lookups | ns | variance | variance x time |\n|---|---|---|---|---|---|\n",
                title);
    for (const TestMedium& test : media) {
        const CellBounds cells = CellBounds::of_grid(*test.grid, Filter::trilinear);
        Medium medium;
        medium.sigma_s = test.sigma_s;
        medium.sigma_t = test.sigma_s + test.sigma_a;
        medium.grid = test.grid;
        for (const Accelerator accelerator : {Accelerator::grid, Accelerator::kdtree}) {
            medium.bounds = std::make_shared<MediumBounds>(
                MediumBounds{Majorants(cells, accelerator, medium.sigma_t_max(), true), {}});
            const std::vector<Ray> rays = random_rays(test.grid->active_bounds(), kRays);
            double first = 0, mean = 0, error = 0;
            for (const Method& method : methods) {
                const Figures f = measure(method, medium, rays);
                const double product = f.variance * f.nanoseconds;
                if (first == 0) {
                    first = product;
                    mean = f.mean;
                    error = f.error;
                }
                const bool off = std::fabs(f.mean - mean) > 5 * std::hypot(f.error, error) + 1e-6;
                std::printf("| %s, %s | %s | %.1f | %.0f | %.3g | %.2f%s |\n", test.name.c_str(),
                            accelerator == Accelerator::grid ? "grid" : "kd-tree", method.name.c_str(),
                            f.lookups, f.nanoseconds, f.variance, first > 0 ? product / first : 1,
                            off ? " (MEAN DIFFERS)" : "");
                std::fflush(stdout);
            }
        }
    }
}

Method transmittance(const char* name, Settings::Transmittance estimator) {
    Settings settings;
    settings.transmittance = estimator;
    return {name, [settings](const Segment& segment, Rng& rng, Counters& counters) {
                return estimate_transmittance(segment, settings, rng, counters);
            }};
}

/// What scatters, and where: the throughput at a scattering point under a light that fades along the ray.
Method flight(const char* name, Settings::Tracking tracking) {
    Settings settings;
    settings.tracking = tracking;
    auto scratch = std::make_shared<TrackingScratch>();
    return {name, [settings, scratch](const Segment& segment, Rng& rng, Counters& counters) {
                Rgb beta(1);
                const Flight f = sample_flight(segment, *scratch, settings, beta, rng, counters);
                if (f.event != Flight::Event::scattered)
                    return Rgb(0);
                return beta * (1 - f.t / segment.ray.t_max);
            }};
}

}  // namespace

int main(int argc, char** argv) {
    try {
        std::vector<TestMedium> media = procedural_media();
        for (int i = 1; i + 2 < argc; i += 3)
            media.push_back(file_medium(argv[i], argv[i + 1], std::strtof(argv[i + 2], nullptr)));
        using T = Settings::Transmittance;
        print_table("transmittance",
                    {transmittance("ratio", T::ratio), transmittance("residual ratio", T::residual_ratio),
                     transmittance("ray marching", T::ray_marching)},
                    media);
        using D = Settings::Tracking;
        print_table("free flight",
                    {flight("weighted delta", D::weighted_delta), flight("decomposition", D::decomposition),
                     flight("analog delta", D::delta)},
                    media);
    } catch (const std::exception& e) {
        std::fprintf(stderr, "trackers: %s\n", e.what());
        return 2;
    }
    return 0;
}
