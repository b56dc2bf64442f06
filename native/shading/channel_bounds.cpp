// SPDX-License-Identifier: GPL-3.0-or-later
#include "shading/channel_bounds.h"

#include <optional>

namespace nephele {
namespace {

constexpr double kPiD = 3.14159265358979323846, kLargest = std::numeric_limits<float>::max(),
                 kSmallest = std::numeric_limits<float>::denorm_min();

/// The same with infinities and NaN turned into 0, as finite_or_zero of each value.
Interval1 finite_or_zero(Interval1 a) {
    const Interval1 finite = narrowed(a, -kLargest, kLargest);
    return a.nan || !a.bounded() ? join({finite.lo, finite.hi}, Interval1(0)) : finite;
}
/// 1 where a condition always holds, 0 where it never does.
Interval1 one_if(bool always, bool possibly) {
    return {always ? 1.0 : 0.0, possibly ? 1.0 : 0.0};
}
/// f on what is positive of a, or 0 where `a` may be something else (NaN included).
template <typename F>
Interval1 positive_or_zero(F f, Interval1 a) {
    if (!(a.hi > 0))
        return Interval1(0);
    const Interval1 value = f({std::max(a.lo, kSmallest), a.hi});
    return a.lo <= 0 || a.nan ? join(value, Interval1(0)) : value;
}

Interval1 power(Interval1 a, Interval1 b) {
    std::optional<Interval1> value;
    const auto include = [&](Interval1 part) { value = value ? join(*value, part) : part; };
    if (a.nan || b.nan)
        include({0, 1});  // even then x ^ 0 and 1 ^ y are 1
    if (a.hi >= 0)
        include(finite_or_zero(positive_power({std::max(a.lo, 0.0), a.hi}, b)));
    if (a.lo < 0) {
        const Interval1 size = positive_power({a.hi < 0 ? -a.hi : 0, -a.lo}, b);
        const bool one_exponent = b.lo == b.hi && std::isfinite(b.lo);
        if (!one_exponent)
            include(finite_or_zero(join(join(size, -size), Interval1(0))));
        else if (std::floor(b.lo) != b.lo)
            include(Interval1(0));
        else
            include(finite_or_zero(std::fmod(b.lo, 2) == 0 ? size : -size));
    }
    return *value;
}

Interval1 logarithm(Interval1 a, Interval1 b) {
    const auto log = [](Interval1 x) { return increasing([](double v) { return std::log(v); }, x); };
    return positive_or_zero(
        [&](Interval1 x) {
            return positive_or_zero(
                [&](Interval1 base) { return finite_or_zero(quotient(log(x), log(base))); }, b);
        },
        a);
}

Interval1 inverse_sqrt(Interval1 a) {
    return positive_or_zero(
        [](Interval1 x) {
            return rounded({1 / std::sqrt(x.hi), 1 / std::sqrt(x.lo)});
        },
        a);
}

Interval1 sign(Interval1 a) {
    const auto of = [](double x) { return x > 0 ? 1.0 : x < 0 ? -1.0 : 0.0; };
    const Interval1 value(of(a.lo), of(a.hi));
    return a.nan ? join(value, Interval1(0)) : value;
}

Interval1 less_than(Interval1 a, Interval1 b) {
    return one_if(a.hi < b.lo && !a.nan && !b.nan, a.lo < b.hi);
}

Interval1 compare(Interval1 a, Interval1 b, Interval1 tolerance) {
    const Interval1 distance = absolute(a - b), most = max(tolerance, Interval1(static_cast<double>(1e-5f)));
    return one_if(distance.hi <= most.lo && !distance.nan && !most.nan, distance.lo <= most.hi);
}

Interval1 smooth_min(Interval1 a, Interval1 b, Interval1 distance) {
    if (!tame(a, b, distance))
        return everything();
    const Interval1 least = min(a, b);
    if (distance.hi <= 0)
        return least;
    // The drop is h^3 distance / 6 with h in [0, 1] at most, and nothing where the distance is negative.
    Interval1 h(0, 1);
    if (distance.lo > 0)
        h = narrowed(quotient(max(distance - absolute(a - b), Interval1(0)), distance), 0, 1);
    const Interval1 positive(std::max(distance.lo, 0.0), distance.hi);
    return least - h * h * h * positive * (1.0 / 6);
}

// --- Remainders. A quotient's rounding may count one period too many or too few, which moves the result by
// up to the rounding error of the dividend.

/// a - floor(t) * period, t = (a - low) / period; [low, low + period) but for rounding. t bounds the
/// quotient.
Interval1 remainder_bounds(Interval1 a, Interval1 t, Interval1 period, Interval1 low) {
    if (!tame(a, t, period, low))
        return everything();
    const double most = kIntervalRounding * (a.magnitude() + low.magnitude() + period.magnitude());
    const Interval1 end = low + period, whole = a - period * floor(t);
    return narrowed(whole, std::min(low.lo, end.lo) - 4 * most, std::max(low.hi, end.hi) + 4 * most);
}

Interval1 modulo(Interval1 a, Interval1 b) {
    if (b.is(0))
        return Interval1(0);
    if (!a.bounded() || a.nan || b.nan)
        return everything();
    const double most = absolute(b).hi;  // exact: fmod does not round
    const Interval1 range(a.lo < 0 ? std::max(a.lo, -most) : 0, a.hi > 0 ? std::min(a.hi, most) : 0);
    const Interval1 size = absolute(b);
    if (a.lo < 0 || size.lo == 0 || !b.bounded())
        return range;
    const double whole = std::trunc(a.lo / size.hi);
    if (whole > 1e6 || whole != std::trunc(a.hi / size.lo))
        return range;
    return narrowed(a - size * whole, range.lo, range.hi);
}

Interval1 floored_modulo(Interval1 a, Interval1 b) {
    if (b.is(0))
        return Interval1(0);
    const Interval1 value = remainder_bounds(a, divide(a, b), b, Interval1(0));
    return b.contains(0) ? join(value, Interval1(0)) : value;
}

Interval1 wrap(Interval1 a, Interval1 high, Interval1 low) {
    const Interval1 span = high - low;
    if (span.is(0))
        return low;
    const Interval1 value = remainder_bounds(a, divide(a - low, span), span, low);
    return span.contains(0) ? join(value, low) : value;
}

Interval1 snap(Interval1 a, Interval1 b) {
    if (b.is(0))
        return Interval1(0);
    const Interval1 t = divide(a, b);
    if (!tame(a, b, t))
        return everything();
    const Interval1 value = floor(t) * b;
    return b.contains(0) ? join(value, Interval1(0)) : value;
}

Interval1 pingpong(Interval1 a, Interval1 b) {
    if (b.is(0))
        return Interval1(0);
    const Interval1 t = divide(a - b, b * 2);
    if (!tame(a, b, t))
        return everything();
    Interval1 fraction(0, 1);
    if (std::floor(t.lo) == std::floor(t.hi))
        fraction = narrowed(t - std::floor(t.lo), 0, 1);
    const Interval1 value = absolute(fraction * 2 * b - b);
    return b.contains(0) ? join(value, Interval1(0)) : value;
}

Interval1 fraction(Interval1 a) {
    if (!a.bounded() || a.nan)
        return everything();
    const double whole = std::floor(a.lo);
    return whole == std::floor(a.hi) ? rounded({a.lo - whole, a.hi - whole}) : Interval1(0, 1);
}

// --- Trigonometry
// -----------------------------------------------------------------------------------------------

/// Whether a holds phase + k * period for an integer k.
bool holds(Interval1 a, double phase, double period) {
    return std::floor((a.hi - phase) / period) >= std::ceil((a.lo - phase) / period);
}

/// A wave of period 2 pi with values `f`, highest at `top`, lowest half a period from there.
template <typename F>
Interval1 wave(F f, double top, Interval1 a) {
    if (!a.bounded() || a.nan)
        return {-1, 1, true};
    if (a.magnitude() > 1e6 || a.width() >= 2 * kPiD)
        return {-1, 1};
    const double p = f(a.lo), q = f(a.hi);
    const Interval1 ends = narrowed(rounded({std::min(p, q), std::max(p, q)}), -1, 1);
    return {holds(a, top + kPiD, 2 * kPiD) ? -1 : ends.lo, holds(a, top, 2 * kPiD) ? 1 : ends.hi};
}

Interval1 tangent(Interval1 a) {
    if (!a.bounded() || a.nan)
        return everything();
    if (a.magnitude() > 1e6 || a.width() >= kPiD || holds(a, 0.5 * kPiD, kPiD))
        return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    return increasing([](double x) { return std::tan(x); }, a);
}

Interval1 hyperbolic_cosine(Interval1 a) {
    return increasing([](double x) { return std::cosh(x); }, absolute(a));
}

}  // namespace

Interval1 divide(Interval1 a, Interval1 b) {
    if (!b.contains(0))
        return quotient(a, b);
    Interval1 value(0);
    if (b.hi > 0)
        value = join(value, quotient(a, {kSmallest, b.hi, b.nan}));
    if (b.lo < 0)
        value = join(value, quotient(a, {b.lo, -kSmallest, b.nan}));
    value.nan |= b.nan;
    return value;
}

Interval1 positive_power(Interval1 a, Interval1 b) {
    // b log a is linear in each, so that the extremes are at the corners; x ^ 0 is 1, for any x.
    double lo = std::numeric_limits<double>::infinity(), hi = 0;
    for (const double x : {a.lo, a.hi}) {
        for (const double y : {b.lo, b.hi}) {
            const double v = std::pow(x, y);
            lo = std::min(lo, v);
            hi = std::max(hi, v);
        }
    }
    if (b.contains(0) || a.contains(1)) {
        lo = std::min(lo, 1.0);
        hi = std::max(hi, 1.0);
    }
    return rounded({lo, hi, a.nan || b.nan});
}

Interval1 arctan2(Interval1 y, Interval1 x) {
    if (y.nan || x.nan)
        return everything();
    if (x.lo <= 0 && y.contains(0))  // across the cut, or at the origin
        return rounded({-kPiD, kPiD});
    const double p = std::atan2(y.lo, x.lo), q = std::atan2(y.lo, x.hi), r = std::atan2(y.hi, x.lo),
                 s = std::atan2(y.hi, x.hi);
    return rounded({std::min({p, q, r, s}), std::max({p, q, r, s})});
}

Interval1 map_range(Interval1 a, Interval1 from_low, Interval1 from_high, Interval1 to_low, Interval1 to_high,
                    std::int32_t mode) {
    Interval1 t = divide(a - from_low, from_high - from_low);
    if (mode != 0)
        t = clamp01(t);
    if (mode == 1)
        t = increasing([](double x) { return x * x * (3 - 2 * x); }, t);
    if (mode == 2) {  // near 1 the polynomial's terms are thirty times its value
        const auto smootherstep = [](double x) { return x * x * x * (x * (x * 6 - 15) + 10); };
        t = rounded({smootherstep(t.lo) * (1 - 3e-5), smootherstep(t.hi) * (1 + 3e-5), t.nan});
    }
    return lerp(to_low, to_high, t);
}

Interval1 channel_bounds(Op op, Interval1 a, Interval1 b, Interval1 c) {
    // Functions that increase and do not round are their own bounds.
    const auto exact = [](double (*f)(double), Interval1 x) { return Interval1(f(x.lo), f(x.hi), x.nan); };
    switch (op) {
        case Op::divide:
            return divide(a, b);
        case Op::power:
            return power(a, b);
        case Op::logarithm:
            return logarithm(a, b);
        case Op::sqrt:
            return increasing([](double x) { return std::sqrt(std::max(x, 0.0)); }, a);
        case Op::inverse_sqrt:
            return inverse_sqrt(a);
        case Op::absolute:
            return absolute(a);
        case Op::exponent:
            return increasing([](double x) { return std::exp(x); }, a);
        case Op::minimum:
            return min(a, b);
        case Op::maximum:
            return max(a, b);
        case Op::less_than:
            return less_than(a, b);
        case Op::greater_than:
            return less_than(b, a);
        case Op::sign:
            return sign(a);
        case Op::compare:
            return compare(a, b, c);
        case Op::smooth_min:
            return smooth_min(a, b, c);
        case Op::smooth_max:
            return -smooth_min(-a, -b, c);
        case Op::round:
            return floor(a + 0.5);
        case Op::floor:
            return floor(a);
        case Op::ceil:
            return exact([](double x) { return std::ceil(x); }, a);
        case Op::truncate:
            return exact([](double x) { return std::trunc(x); }, a);
        case Op::fraction:
            return fraction(a);
        case Op::modulo:
            return modulo(a, b);
        case Op::floored_modulo:
            return floored_modulo(a, b);
        case Op::wrap:
            return wrap(a, b, c);
        case Op::snap:
            return snap(a, b);
        case Op::pingpong:
            return pingpong(a, b);
        case Op::sine:
            return wave([](double x) { return std::sin(x); }, 0.5 * kPiD, a);
        case Op::cosine:
            return wave([](double x) { return std::cos(x); }, 0, a);
        case Op::tangent:
            return tangent(a);
        case Op::arcsine:
            return increasing([](double x) { return std::asin(x); }, narrowed(a, -1, 1));
        case Op::arccosine:
            return -increasing([](double x) { return -std::acos(x); }, narrowed(a, -1, 1));
        case Op::arctangent:
            return increasing([](double x) { return std::atan(x); }, a);
        case Op::arctan2:
            return arctan2(a, b);
        case Op::sinh:
            return increasing([](double x) { return std::sinh(x); }, a);
        case Op::cosh:
            return hyperbolic_cosine(a);
        case Op::tanh:
            return increasing([](double x) { return std::tanh(x); }, a);
        default:
            return everything();
    }
}

}  // namespace nephele
