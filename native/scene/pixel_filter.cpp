// SPDX-License-Identifier: GPL-3.0-or-later
#include "scene/pixel_filter.h"

#include <numbers>
#include <stdexcept>

namespace nephele {

PixelFilter::PixelFilter(Kind kind, float width) : kind_(kind), width_(width) {
    if (!(width > 0) || !std::isfinite(width))
        throw std::invalid_argument("the pixel filter's width must be above 0");
    reach_ = kind == Kind::box ? 0.5f : kind == Kind::gaussian ? 1.5f * width : width;
    if (kind == Kind::box)
        return;

    std::vector<double> values, integrals{0};
    for (int i = 0; i <= kCells; ++i)
        values.push_back(std::max(0.0, value(double{reach_} * i / kCells)));
    for (std::size_t i = 0; i < kCells; ++i)
        integrals.push_back(integrals[i] + 0.5 * (values[i] + values[i + 1]));
    const double total = integrals.back();
    for (const double v : values)
        values_.push_back(static_cast<float>(v / total));
    for (const double v : integrals)
        integrals_.push_back(static_cast<float>(v / total));
    scale_ = kCells / (2 * double{reach_} * total);
}

/// Unnormalised filter at a distance x >= 0 from the centre.
double PixelFilter::value(double x) const {
    if (kind_ == Kind::box)
        return 1;
    const double v = x / double{width_};
    if (kind_ == Kind::gaussian)
        return std::exp(-8 * v * v);
    const double a = std::numbers::pi * (v + 1);  // the window's argument: pi at its centre, 2 pi at its end
    return 0.35875 - 0.48829 * std::cos(a) + 0.14128 * std::cos(2 * a) - 0.01168 * std::cos(3 * a);
}

float PixelFilter::density(float x) const {
    return std::fabs(x) > reach_ ? 0 : static_cast<float>(scale_ * value(std::fabs(double{x})));
}

float PixelFilter::offset(float u) const {
    if (kind_ == Kind::box)
        return u - 0.5f;
    const float t = 2 * u - 1, target = std::fabs(t);
    const auto above = std::upper_bound(integrals_.begin() + 1, integrals_.end() - 1, target);
    const auto cell = static_cast<std::size_t>(above - integrals_.begin()) - 1;
    // Invert the integral of the linear density a + (b - a) s over the cell.
    const float a = values_[cell], b = values_[cell + 1], rest = target - integrals_[cell];
    const float denominator = a + std::sqrt(std::max(0.0f, a * a + 2 * (b - a) * rest));
    const float s = denominator > 0 ? std::min(2 * rest / denominator, 1.0f) : 0;
    return std::copysign(reach_ / kCells * (static_cast<float>(cell) + s), t);
}

}  // namespace nephele
