// SPDX-License-Identifier: GPL-3.0-or-later
#include "lights/environment.h"

#include <numbers>
#include <stdexcept>

#include "math/warp.h"

namespace nephele {

namespace {

constexpr double kPiDouble = std::numbers::pi;

/// Mean radiance of each cell of a texture that interpolates linearly between the centres of the cells: the
/// weights 1/8, 3/4, 1/8 along either axis are the exact integrals of its tents. Wraps around, stops at the
/// poles.
std::vector<float> averaged(const std::vector<float>& centres, int width, int height) {
    const auto at = [&](const std::vector<float>& v, int x, int y) {
        return v[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    };
    std::vector<float> across(centres.size()), out(centres.size());
    std::size_t i = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const float sides =
                at(centres, x > 0 ? x - 1 : width - 1, y) + at(centres, x + 1 < width ? x + 1 : 0, y);
            across[i++] = 0.75f * at(centres, x, y) + 0.125f * sides;
        }
    }
    i = 0;
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            const float sides =
                at(across, x, std::max(y - 1, 0)) + at(across, x, std::min(y + 1, height - 1));
            out[i++] = 0.75f * at(across, x, y) + 0.125f * sides;
        }
    }
    return out;
}

}  // namespace

/// Cosine to +z at the lower edge of a row, rows counted from -z.
double EnvironmentLight::cos_of_row(int row) const {
    return row == 0 ? -1 : row == height_ ? 1 : -std::cos(kPiDouble * row / height_);
}

EnvironmentLight::EnvironmentLight(const std::function<Rgb(Vec3f)>& radiance, int width, int height)
    : width_(width), height_(height) {
    if (width < 1 || height < 1)
        throw std::invalid_argument("the world's sampling grid must have at least one cell");
    std::vector<float> centres;
    centres.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    Rgb lowest(kInfinity), highest(0);
    double sum[3] = {};
    for (int y = 0; y < height; ++y) {
        const double share = (cos_of_row(y + 1) - cos_of_row(y)) / (2.0 * width);  // of the sphere
        for (int x = 0; x < width; ++x) {
            const Vec2f uv{(static_cast<float>(x) + 0.5f) / static_cast<float>(width),
                           (static_cast<float>(y) + 0.5f) / static_cast<float>(height)};
            const Rgb Le = radiance(direction_from_equirectangular(uv));
            if (!is_finite(Le) || min_component(Le) < 0) {
                throw std::invalid_argument(
                    "the world's radiance is negative or not finite in some direction; check the "
                    "images and values of its Background shader");
            }
            lowest = min(lowest, Le);
            highest = max(highest, Le);
            for (int c = 0; c < 3; ++c)
                sum[c] += share * static_cast<double>(Le[c]);
            centres.push_back(mean(Le));
        }
    }
    for (int c = 0; c < 3; ++c)
        mean_radiance_[c] = static_cast<float>(sum[c]);
    const bool constant = max_component(highest - lowest) <= 1e-4f * max_component(highest);
    if (!constant)
        build(averaged(centres, width, height));
}

void EnvironmentLight::build(const std::vector<float>& weights) {
    std::vector<float> row_weights;
    rows_.reserve(static_cast<std::size_t>(height_));
    for (int y = 0; y < height_; ++y) {
        const auto w = static_cast<std::size_t>(width_);
        rows_.emplace_back(std::span(weights).subspan(static_cast<std::size_t>(y) * w, w));
        row_weights.push_back(static_cast<float>(rows_.back().total() * (cos_of_row(y + 1) - cos_of_row(y))));
    }
    marginal_ = DiscreteDistribution(row_weights);
}

EnvironmentLight::Sample EnvironmentLight::sample(Vec2d u) const {
    constexpr double kUniform = double{kUniformShare};
    const auto sphere = [&](double share) {
        return sample_sphere({std::min(static_cast<float>(u.x / share), kOneMinusEpsilon),
                              std::min(static_cast<float>(u.y), kOneMinusEpsilon)});
    };
    if (constant())
        return {sphere(1), kInv4Pi};
    if (u.x < kUniform) {
        const Vec3f wi = sphere(kUniform);
        return {wi, pdf(wi)};
    }
    const double ux = (u.x - kUniform) / (1 - kUniform);
    const DiscreteDistribution::Choice row = marginal_.sample(u.y);
    const DiscreteDistribution::Choice cell = rows_[row.index].sample(ux);
    const double lower = cos_of_row(static_cast<int>(row.index)),
                 upper = cos_of_row(static_cast<int>(row.index) + 1);
    const double z = lower + static_cast<double>(row.u) * (upper - lower),
                 s = std::sqrt(std::max(0.0, 1 - z * z));
    const double phi =
        -2 * kPiDouble * ((static_cast<double>(cell.index) + static_cast<double>(cell.u)) / width_ - 0.5);
    const double solid_angle = 2 * kPiDouble / width_ * (upper - lower);
    const auto density = static_cast<float>(static_cast<double>(row.probability) *
                                            static_cast<double>(cell.probability) / solid_angle);
    const Vec3f wi(static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
                   static_cast<float>(z));
    return {wi, kUniformShare * kInv4Pi + (1 - kUniformShare) * density};
}

float EnvironmentLight::pdf(Vec3f wi) const {
    if (constant())
        return kInv4Pi;
    // The polar angle by atan2: acos would lose half its digits near the poles.
    const double theta = std::atan2(std::hypot(static_cast<double>(wi.x), static_cast<double>(wi.y)),
                                    static_cast<double>(wi.z));
    const double v = 1 - theta / kPiDouble;
    const double across =
        0.5 - std::atan2(static_cast<double>(wi.y), static_cast<double>(wi.x)) / (2 * kPiDouble);
    const int row = std::clamp(static_cast<int>(v * height_), 0, height_ - 1);
    const int cell = std::clamp(static_cast<int>(across * width_), 0, width_ - 1);
    const double solid_angle = 2 * kPiDouble / width_ * (cos_of_row(row + 1) - cos_of_row(row));
    const auto r = static_cast<std::size_t>(row);
    const float p = marginal_.probability(r) * rows_[r].probability(static_cast<std::size_t>(cell));
    return kUniformShare * kInv4Pi +
           (1 - kUniformShare) * static_cast<float>(static_cast<double>(p) / solid_angle);
}

}  // namespace nephele
