// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/noise_bounds.h"

#include <array>
#include <optional>
#include <vector>

namespace nephele {
namespace {

using Box = std::array<Interval1, 4>;

/// What sampling aims at, as a part of the fractal's range; octaves beyond the first few do not count.
constexpr double kAim = 0.03;
constexpr std::size_t kOctavesAimedAt = 4;
/// Most steps along an axis (32 made the bounds of a mesh of noise 3 % tighter in 30 s instead of 2), and the
/// largest edge of a box that is sampled: a larger one meets the extremes.
constexpr int kMostSteps = 8;
constexpr double kLargestSampled = 4;
/// Coordinates that perlin does not fold into its period.
constexpr double kPeriod = 100000;

/// One octave's place in the sum.
struct Octave {
    float frequency;
    double weight;  ///< factor of its Perlin noise in the result, >= 0
};

/// A fractal with known settings: the result is `constant` plus the weighted octaves.
struct Fractal {
    std::vector<Octave> octaves;
    double constant = 0, scale = 0;  ///< scale: of the largest number that appears on the way
};

/// The weights that fractal_sum gives its octaves; nothing where they overflow.
std::optional<Fractal> fractal_of(double detail_setting, double roughness_setting, double lacunarity,
                                  bool normalize) {
    const double detail = std::clamp(detail_setting, 0.0, 15.0), roughness = std::max(roughness_setting, 0.0);
    const double rest = detail - std::floor(detail);
    const int coarse = static_cast<int>(detail) + 1, all = coarse + (rest > 0 ? 1 : 0);
    double amplitude = 1, coarse_total = 0, total = 0;
    for (int i = 0; i < all; ++i) {
        total += amplitude;
        coarse_total += i < coarse ? amplitude : 0;
        amplitude *= roughness;
    }
    // The result blends, by `rest`, the sum without the finest octave and the sum with it.
    const double without = (1 - rest) * (normalize ? 0.5 / coarse_total : 1),
                 with = rest * (normalize ? 0.5 / total : 1);
    Fractal fractal{{}, normalize ? 0.5 : 0, normalize ? 1 : total};
    amplitude = 1;
    float frequency = 1;
    for (int i = 0; i < all; ++i) {
        fractal.octaves.push_back({frequency, amplitude * (i < coarse ? without + with : with)});
        if (!std::isfinite(frequency) || !(total < 1e12))
            return std::nullopt;
        amplitude *= roughness;
        frequency *= static_cast<float>(lacunarity);
    }
    return fractal;
}

/// A lattice of samples in a box: how many steps along each axis.
struct Lattice {
    std::array<int, 4> steps{};
    std::array<double, 4> spacing{};

    Lattice(const Box& box, int n, double step) {
        for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
            const double edge = box[i].width();
            steps[i] = edge > 0 ? std::max(1, static_cast<int>(std::ceil(edge / step - 1e-9))) : 0;
            spacing[i] = edge / std::max(steps[i], 1);
        }
    }
    /// By how much an octave may leave the range of its samples.
    double excess(const Octave& octave, int n) const {
        double square = 0;
        for (const double s : spacing)
            square += s * s;
        const double f = octave.frequency;
        return std::min(kPerlinCurvature[n] * f * f * square / 8, 2 * kPerlinRange[n]);
    }
    /// Whether sampling an octave says more than its range.
    bool resolves(const Octave& octave, int n) const { return excess(octave, n) < kPerlinRange[n]; }
};

/// The coarsest lattice that bounds the fractal well enough, or the finest that is allowed.
Lattice lattice_for(const Box& box, const Fractal& fractal, int n) {
    double edge = 0, aim = 0;
    for (const Interval1& side : box)
        edge = std::max(edge, side.width());
    for (std::size_t k = 0; k < fractal.octaves.size(); ++k)
        aim += fractal.octaves[k].weight * kPerlinRange[n] * (k < kOctavesAimedAt ? kAim : 1);
    for (int steps = 1;; steps += (steps + 2) / 3) {
        const Lattice lattice(box, n, edge / std::min(steps, kMostSteps));
        double error = 0;
        for (const Octave& octave : fractal.octaves)
            error += octave.weight * std::min(lattice.excess(octave, n), kPerlinRange[n]);
        if (error <= aim || steps >= kMostSteps)
            return lattice;
    }
}

double perlin_at(const std::array<double, 4>& p, double frequency, int n) {
    const auto at = [&](std::size_t i) { return static_cast<float>(p[i] * frequency); };
    switch (n) {
        case 1:
            return perlin(at(0));
        case 2:
            return perlin(at(0), at(1));
        case 3:
            return perlin(Vec3f(at(0), at(1), at(2)));
        default:
            return perlin(Vec3f(at(0), at(1), at(2)), at(3));
    }
}

/// Range of the samples of some octaves.
Interval1 sampled(const Box& box, const Lattice& lattice, std::span<const Octave> octaves, int n) {
    Interval1 range(std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity());
    std::array<int, 4> step{};
    for (std::size_t i = 0; i < 4;) {
        std::array<double, 4> p;
        for (std::size_t k = 0; k < 4; ++k)
            p[k] = box[k].lo + step[k] * lattice.spacing[k];
        double sum = 0;
        for (const Octave& octave : octaves)
            sum += octave.weight * perlin_at(p, octave.frequency, n);
        range = {std::min(range.lo, sum), std::max(range.hi, sum)};
        for (i = 0; i < 4 && step[i] == lattice.steps[i]; ++i)
            step[i] = 0;
        if (i < 4)
            ++step[i];
    }
    return range;
}

/// Bounds of the weighted octaves over a box.
Interval1 fractal_bounds(const Box& box, const Fractal& fractal, int n) {
    double edge = 0, place = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
        edge = std::max(edge, box[i].width());
        place += box[i].magnitude();
    }
    std::vector<Octave> octaves;  // those that samples resolve
    double excess = 0;
    const Lattice lattice = lattice_for(box, fractal, n);
    for (const Octave& octave : fractal.octaves) {
        const double farthest = place * std::fabs(static_cast<double>(octave.frequency));
        if (edge > kLargestSampled || farthest >= kPeriod || !lattice.resolves(octave, n)) {
            excess += octave.weight * kPerlinRange[n];
            continue;
        }
        octaves.push_back(octave);
        // Coordinates are rounded, here and where the program runs.
        excess +=
            octave.weight * (lattice.excess(octave, n) + kPerlinSlope[n] * kIntervalRounding * farthest);
    }
    const Interval1 range = octaves.empty() ? Interval1(0) : sampled(box, lattice, octaves, n);
    return rounded({range.lo + fractal.constant - excess, range.hi + fractal.constant + excess},
                   4 * fractal.scale);
}

Box moved(const Box& p, const NoisePoint& by) {
    return {p[0] + by.p.x, p[1] + by.p.y, p[2] + by.p.z, p[3] + by.w};
}

Box distorted(const Box& p, Interval1 distortion, int n) {
    if (distortion.is(0))
        return p;
    const Fractal one{{{1, 1}}, 0, 1};
    Box q = p;
    for (int k = 0; k < n; ++k) {
        const auto i = static_cast<std::size_t>(k);
        q[i] = p[i] + distortion * fractal_bounds(moved(p, noise_offset(k, n)), one, n);
    }
    return q;
}

/// Bounds where the settings vary too, or the point is not bounded: the octaves' weights are positive.
Interval1 whole_range(const Interval3& fractal, bool normalize, int n) {
    const double most = kPerlinRange[n] + 1e-5;
    if (normalize)
        return {0.5 - 0.5 * most, 0.5 + 0.5 * most};
    double total = 0, amplitude = 1;
    for (int i = 0; i < 17 && i <= std::clamp(fractal[0].hi, 0.0, 15.0) + 1; ++i) {
        total += amplitude;
        amplitude *= std::max(fractal[1].hi, 0.0);
    }
    return rounded({-total * most, total * most});
}

}  // namespace

Interval3 noise_bounds(const Interval3& p, Interval1 w, const Interval3& settings, Interval1 distortion,
                       bool normalize, int n, bool color) {
    // Octaves of at most (10^2)^16 keep sums finite.
    if (!tame(settings[0], settings[2]) || settings[1].nan || settings[1].hi > 100)
        return Interval3(everything());
    const Interval1 range = whole_range(settings, normalize, n);
    const bool constant = settings[0].width() == 0 && settings[1].width() == 0 && settings[2].width() == 0;
    if (!constant || !tame(distortion) || !tame(p[0], p[1], p[2], w))
        return Interval3(range);
    const auto fractal = fractal_of(settings[0].lo, settings[1].lo, settings[2].lo, normalize);
    if (!fractal)
        return Interval3(range);
    const Box q = distorted({p[0], p[1], p[2], n == 4 ? w : Interval1(0)}, distortion, n);
    const auto channel = [&](const Box& box) {
        return narrowed(fractal_bounds(box, *fractal, n), range.lo, range.hi);
    };
    const Interval1 value = channel(q);
    return color ? Interval3(value, channel(moved(q, noise_offset(n, n))),
                             channel(moved(q, noise_offset(n + 1, n))))
                 : Interval3(value);
}

}  // namespace nephele
