// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/texture_bounds.h"

#include "shading/channel_bounds.h"

namespace nephele {

Interval1 checker_bounds(const Interval3& p) {
    bool odd = false;
    for (int i = 0; i < 3; ++i) {
        const Interval1 cell = floor((p[i] + 1e-6) * 0.999999);
        if (!p[i].bounded() || p[i].nan || cell.lo != cell.hi)
            return {0, 1};
        odd ^= std::fmod(std::fabs(cell.lo), 2) == 1;
    }
    return Interval1(odd ? 1 : 0);
}

Interval1 gradient_bounds(Gradient kind, const Interval3& p) {
    switch (kind) {
        case Gradient::linear:
            return clamp01(p[0]);
        case Gradient::quadratic:
            return clamp01(squared(max(p[0], Interval1(0))));
        case Gradient::easing:
            return increasing([](double r) { return r * r * (3 - 2 * r); }, clamp01(p[0]));
        case Gradient::diagonal:
            return clamp01((p[0] + p[1]) * 0.5);
        case Gradient::radial: {
            const Interval1 angle = arctan2(p[1], p[0]);
            return clamp01(rounded(angle * (0.5 / 3.14159265358979323846) + 0.5, 1));
        }
        case Gradient::spherical:
            break;
        case Gradient::quadratic_sphere:
            break;
    }
    const Interval1 r = max(0.999999 - length(p), Interval1(0));
    return kind == Gradient::spherical ? r : squared(r);
}

Interval1 table_bounds(std::span<const float> table, std::size_t channels, std::size_t channel, Interval1 t) {
    const double last = static_cast<double>(table.size() / channels - 1);
    const Interval1 place = rounded(narrowed({t.nan ? 0 : t.lo, t.hi}, 0, 1) * last);
    const double from = std::min(place.lo, last), to = std::min(place.hi, last);
    const auto entry = [&](double i) {
        return static_cast<double>(table[channels * static_cast<std::size_t>(i) + channel]);
    };
    const auto known = [](double v) {  // the difference of two such is a number
        return std::fabs(v) < 0.5 * static_cast<double>(std::numeric_limits<float>::max());
    };
    const auto at = [&](double x) {  // linear between entries
        const double i = std::min(std::floor(x), last - 1), a = entry(i), b = entry(i + 1);
        const double v = a + (b - a) * (x - i), size = std::fabs(a) + 2 * std::fabs(b - a);
        return known(a) && known(b) ? rounded(Interval1(v), size) : everything();
    };
    Interval1 value = join(at(from), at(to));
    for (double i = std::ceil(from); i <= to; ++i) {
        const double v = entry(i);
        value = join(value, known(v) ? Interval1(v) : everything());
    }
    return rounded(value);
}

Interval1 length(const Interval3& v) {
    const Interval1 square = squared(v[0]) + squared(v[1]) + squared(v[2]);
    return increasing([](double x) { return std::sqrt(x); }, square);
}

}  // namespace nephele
