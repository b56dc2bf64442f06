// SPDX-License-Identifier: GPL-3.0-or-later
// Checks a sampling routine of directions against the density it claims, by Pearson's chi-square test over
// cells of the sphere. The cells' expected counts are integrals of the density, so that a wrong shape, a
// wrong normalisation and a missing piece all show. Seeds are fixed: a test passes or fails for good.
//
// False alarms: a test passes where its p-value exceeds `significance(tests)`, the bound of Sidak for a whole
// family of that many tests which a correct sampler fails with probability 0.01.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "math/sampler.h"
#include "math/transform.h"
#include "math/warp.h"

namespace nephele::testing {

inline constexpr double kFamilyFalseAlarm = 0.01;

/// p-value below which one test of a family of `tests` fails.
inline double significance(int tests) {
    return 1 - std::pow(1 - kFamilyFalseAlarm, 1.0 / tests);
}

/// Upper regularised incomplete gamma function Q(a, x): series below a + 1, Lentz's continued fraction above.
inline double gamma_q(double a, double x) {
    if (x <= 0)
        return 1;
    const double front = std::exp(-x + a * std::log(x) - std::lgamma(a));
    if (x < a + 1) {
        double term = 1 / a, sum = term;
        for (int n = 1; n < 10000 && term > sum * 1e-15; ++n)
            sum += term *= x / (a + n);
        return std::max(0.0, 1 - front * sum);
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, h = d;
    for (int n = 1; n < 10000; ++n) {
        const double an = -n * (n - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (std::fabs(d * c - 1) < 1e-15)
            break;
    }
    return std::min(1.0, front * h);
}

struct ChiSquareResult {
    double p_value = 1;
    double statistic = 0;
    int degrees = 0;
    double integral = 0;  ///< of the density over the sphere
    double sampled = 0;   ///< share of the draws that gave a direction
};

/// A grid of cells over directions: rows in the angle to `axis`, columns in azimuth.
class ChiSquare {
  public:
    using Sample = std::function<std::optional<Vec3f>(Rng&)>;
    using Density = std::function<double(Vec3f)>;

    /// spread: rows are equal in v with angle = pi v^spread, so that cells crowd around the axis where spread
    /// > 1.
    ChiSquare(Vec3f axis, int rows, int columns, double spread = 1)
        : frame_(axis), rows_(rows), columns_(columns), spread_(spread) {}

    /// Compares `draws` samples with the density.
    ChiSquareResult run(const Sample& sample, const Density& density, int draws, std::uint64_t seed) const {
        const auto cells = static_cast<std::size_t>(rows_ * columns_);
        std::vector<double> observed(cells + 1, 0), expected(cells + 1, 0);  // the last cell: no direction
        Rng rng(seed);
        for (int i = 0; i < draws; ++i) {
            const auto w = sample(rng);
            observed[w ? cell_of(*w) : cells] += 1;
        }
        double integral = 0;
        for (std::size_t i = 0; i < cells; ++i)
            integral += expected[i] = integrate(static_cast<int>(i), density);
        expected[cells] = std::max(0.0, 1 - integral);
        for (double& e : expected)
            e *= draws;
        ChiSquareResult result = compare(observed, expected);
        result.integral = integral;
        result.sampled = 1 - observed[cells] / draws;
        return result;
    }

  private:
    std::size_t cell_of(Vec3f w) const {
        const Vec3f local = frame_.to_local(w);
        const double x = local.x, y = local.y, z = local.z;
        const double v = std::pow(std::atan2(std::hypot(x, y), z) / M_PI, 1 / spread_);
        const double phi = std::atan2(y, x) / (2 * M_PI) + 0.5;
        const int row = std::min(static_cast<int>(v * rows_), rows_ - 1);
        const int column = std::min(static_cast<int>(phi * columns_), columns_ - 1);
        return static_cast<std::size_t>(row * columns_ + column);
    }

    struct Box {
        double v, phi, width;  ///< lower corner and side, in units of a cell
    };

    /// Gauss-Legendre rule of 3 x 3 points over a part of the sphere, in the coordinates of the rows and
    /// columns.
    double gauss(const Box& box, const Density& density) const {
        constexpr double kNodes[] = {0.1127016653792583, 0.5, 0.8872983346207417};
        constexpr double kWeights[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
        double sum = 0;
        for (int i = 0; i < 3; ++i) {
            const double v = (box.v + kNodes[i] * box.width) / rows_, theta = M_PI * std::pow(v, spread_);
            const double jacobian =
                std::sin(theta) * M_PI * spread_ * std::pow(v, spread_ - 1) / rows_ * (2 * M_PI / columns_);
            for (int j = 0; j < 3; ++j) {
                const double phi = 2 * M_PI * ((box.phi + kNodes[j] * box.width) / columns_ - 0.5);
                const Vec3f local(static_cast<float>(std::sin(theta) * std::cos(phi)),
                                  static_cast<float>(std::sin(theta) * std::sin(phi)),
                                  static_cast<float>(std::cos(theta)));
                sum += density(frame_.to_world(local)) * jacobian * kWeights[i] * kWeights[j];
            }
        }
        return sum * box.width * box.width;
    }

    /// Splits the box until the rule and its refinement agree. `depth` counts down; the first splits are not
    /// optional, so that a narrow peak is not missed.
    double refine(const Box& box, double coarse, const Density& density, int depth) const {
        constexpr int kOptional = 9;
        constexpr double kTolerance = 2e-7;
        const double half = 0.5 * box.width;
        const Box parts[] = {{box.v, box.phi, half},
                             {box.v + half, box.phi, half},
                             {box.v, box.phi + half, half},
                             {box.v + half, box.phi + half, half}};
        double values[4], fine = 0;
        for (int k = 0; k < 4; ++k)
            fine += values[k] = gauss(parts[k], density);
        if (depth == 0 || (depth <= kOptional && std::fabs(fine - coarse) < kTolerance))
            return fine;
        double sum = 0;
        for (int k = 0; k < 4; ++k)
            sum += refine(parts[k], values[k], density, depth - 1);
        return sum;
    }

    double integrate(int cell, const Density& density) const {
        constexpr int kDepth = 11;
        const Box whole{static_cast<double>(cell / columns_), static_cast<double>(cell % columns_), 1};
        return refine(whole, gauss(whole, density), density, kDepth);
    }

    /// Pools cells of few expected counts, in order of size, and returns the test of what remains.
    static ChiSquareResult compare(const std::vector<double>& observed, const std::vector<double>& expected) {
        constexpr double kLeast = 10;
        std::vector<std::size_t> order(expected.size());
        for (std::size_t i = 0; i < order.size(); ++i)
            order[i] = i;
        std::sort(order.begin(), order.end(),
                  [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
        ChiSquareResult result;
        double pooled_observed = 0, pooled_expected = 0;
        int cells = 0;
        for (const std::size_t i : order) {
            pooled_observed += observed[i];
            pooled_expected += expected[i];
            if (pooled_expected < kLeast)
                continue;
            const double difference = pooled_observed - pooled_expected;
            result.statistic += difference * difference / pooled_expected;
            pooled_observed = pooled_expected = 0;
            ++cells;
        }
        // Draws where none, or hardly any, are expected and no cell is left to pool them with.
        if (pooled_observed > 0) {
            const double difference = pooled_observed - pooled_expected;
            result.statistic += difference * difference / std::max(pooled_expected, 1.0);
            ++cells;
        }
        result.degrees = std::max(cells - 1, 1);
        result.p_value = gamma_q(0.5 * result.degrees, 0.5 * result.statistic);
        return result;
    }

    Frame frame_;
    int rows_, columns_;
    double spread_;
};

}  // namespace nephele::testing
