// SPDX-License-Identifier: GPL-3.0-or-later
// Interval arithmetic that encloses single-precision arithmetic (Moore, Kearfott and Cloud 2009,
// "Introduction to Interval Analysis"). Every operation returns bounds of what the same operation returns in
// float, with or without fused multiply-adds, for all operands inside the operands' bounds: ends are worked
// out in double and moved outwards by far more than float's rounding. Exact zeros stay exact.
#pragma once

#include <limits>

#include "math/vec.h"

namespace nephele {

/// The floats from lo to hi, infinities included where an end is infinite; `nan`: NaN as well.
struct Interval1 {
    double lo = 0, hi = 0;
    bool nan = false;

    constexpr Interval1() = default;
    constexpr explicit Interval1(double v) : lo(v), hi(v) {
        if (v != v)
            *this = {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), true};
    }
    constexpr Interval1(double low, double high, bool or_nan = false) : lo(low), hi(high), nan(or_nan) {}

    constexpr bool contains(double v) const { return lo <= v && v <= hi; }
    constexpr bool is(double v) const { return lo == v && hi == v && !nan; }
    constexpr bool bounded() const {
        return lo > -std::numeric_limits<double>::infinity() && hi < std::numeric_limits<double>::infinity();
    }
    constexpr double magnitude() const { return std::max(-lo, hi); }
    constexpr double width() const { return hi - lo; }
};

/// What no bound is known of.
constexpr Interval1 everything() {
    return {-std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(), true};
}
constexpr Interval1 join(Interval1 a, Interval1 b) {
    return {std::min(a.lo, b.lo), std::max(a.hi, b.hi), a.nan || b.nan};
}
/// a, of which is known that it lies in [lo, hi] where it is a number.
constexpr Interval1 narrowed(Interval1 a, double lo, double hi) {
    return {std::clamp(a.lo, lo, hi), std::clamp(a.hi, lo, hi), a.nan};
}
/// Whether sums and products of a few such values stay clear of float's infinities.
constexpr bool tame(Interval1 a) {
    return !a.nan && a.magnitude() < 1e12;
}
template <typename... Rest>
constexpr bool tame(Interval1 a, Rest... rest) {
    return tame(a) && tame(rest...);
}

// --- Rounding
// ----------------------------------------------------------------------------------------------------

/// Relative error that is allowed for: 8 units in the last place, several times that of one operation or of a
/// mathematical function of the C library.
inline constexpr double kIntervalRounding = 1e-6;

/// Lower bound of a float result whose exact value is at least v.
inline double below(double v) {
    constexpr double kLargest = std::numeric_limits<float>::max(),
                     kSmallest = std::numeric_limits<float>::min();
    if (v == 0)
        return 0;
    if (std::fabs(v) < kSmallest)  // denormal numbers have less precision, but keep their sign
        return v > 0 ? 0 : -kSmallest;
    const double moved = v - kIntervalRounding * std::fabs(v);
    if (v > 0)
        return moved < kLargest ? moved : kLargest;
    return moved >= -kLargest ? moved : -std::numeric_limits<double>::infinity();
}
inline double above(double v) {
    return -below(-v);
}
/// Bounds of the float results of an operation whose exact values are x.
inline Interval1 rounded(Interval1 x) {
    if (!(x.lo <= x.hi))
        return everything();
    return {below(x.lo), above(x.hi), x.nan};
}
/// As rounded, for a result that errs by up to kIntervalRounding times `size` as well: the sum of the
/// magnitudes of the terms that it is made of.
inline Interval1 rounded(Interval1 x, double size) {
    return rounded({x.lo - kIntervalRounding * size, x.hi + kIntervalRounding * size, x.nan});
}

// --- Arithmetic
// --------------------------------------------------------------------------------------------------

constexpr Interval1 operator-(Interval1 a) {
    return {-a.hi, -a.lo, a.nan};
}
inline Interval1 operator+(Interval1 a, Interval1 b) {
    const auto opposite = [](double x, double y) { return std::isinf(x) && std::isinf(y) && x != y; };
    return rounded(
        {a.lo + b.lo, a.hi + b.hi, a.nan || b.nan || opposite(a.hi, b.lo) || opposite(a.lo, b.hi)});
}
inline Interval1 operator-(Interval1 a, Interval1 b) {
    return a + -b;
}
inline Interval1 operator*(Interval1 a, Interval1 b) {
    const auto product = [](double x, double y) { return x == 0 || y == 0 ? 0 : x * y; };
    const double p = product(a.lo, b.lo), q = product(a.lo, b.hi), r = product(a.hi, b.lo),
                 s = product(a.hi, b.hi);
    const bool zero_times_infinity = (a.contains(0) && !b.bounded()) || (b.contains(0) && !a.bounded());
    return rounded({std::min({p, q, r, s}), std::max({p, q, r, s}), a.nan || b.nan || zero_times_infinity});
}
/// a / b as the processor has it.
inline Interval1 quotient(Interval1 a, Interval1 b) {
    if (b.contains(0))
        return a.is(0) && !b.nan ? Interval1(0, 0, true) : everything();
    const auto ratio = [](double x, double y) { return std::isinf(y) ? 0 : x / y; };
    const double p = ratio(a.lo, b.lo), q = ratio(a.lo, b.hi), r = ratio(a.hi, b.lo), s = ratio(a.hi, b.hi);
    return rounded(
        {std::min({p, q, r, s}), std::max({p, q, r, s}), a.nan || b.nan || (!a.bounded() && !b.bounded())});
}
/// a * a.
inline Interval1 squared(Interval1 a) {
    const double p = a.lo * a.lo, q = a.hi * a.hi;
    return rounded({a.contains(0) ? 0 : std::min(p, q), std::max(p, q), a.nan});
}

inline Interval1 operator+(Interval1 a, double b) {
    return a + Interval1(b);
}
inline Interval1 operator-(Interval1 a, double b) {
    return a - Interval1(b);
}
inline Interval1 operator*(Interval1 a, double b) {
    return a * Interval1(b);
}
inline Interval1 operator-(double a, Interval1 b) {
    return Interval1(a) - b;
}

// --- Functions of <algorithm> and vec.h: exact, with what they make of NaN
// --------------------------------------

/// std::min and std::max return the first operand where either is NaN.
constexpr Interval1 min(Interval1 a, Interval1 b) {
    const Interval1 m(std::min(a.lo, b.lo), std::min(a.hi, b.hi), a.nan);
    return b.nan ? join(m, a) : m;
}
constexpr Interval1 max(Interval1 a, Interval1 b) {
    const Interval1 m(std::max(a.lo, b.lo), std::max(a.hi, b.hi), a.nan);
    return b.nan ? join(m, a) : m;
}
constexpr Interval1 clamp01(Interval1 a) {
    return narrowed(a, 0, 1);
}
constexpr Interval1 absolute(Interval1 a) {
    const double p = a.lo < 0 ? -a.lo : a.lo, q = a.hi < 0 ? -a.hi : a.hi;
    return {a.contains(0) ? 0 : std::min(p, q), std::max(p, q), a.nan};
}
inline Interval1 floor(Interval1 a) {
    return {std::floor(a.lo), std::floor(a.hi), a.nan};
}
/// f increases with its argument and is right to kIntervalRounding.
template <typename F>
Interval1 increasing(F f, Interval1 a) {
    return rounded({f(a.lo), f(a.hi), a.nan});
}

/// A function that is linear in each of its three operands alone: its extremes are at the corners. value:
/// (double, double, double) -> double; size: the same on magnitudes, with every term added.
template <typename Value, typename Size>
Interval1 multilinear(Interval1 a, Interval1 b, Interval1 c, Value value, Size size) {
    if (!tame(a, b, c))
        return everything();
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (int corner = 0; corner < 8; ++corner) {
        const double v = value(corner & 1 ? a.hi : a.lo, corner & 2 ? b.hi : b.lo, corner & 4 ? c.hi : c.lo);
        lo = std::min(lo, v);
        hi = std::max(hi, v);
    }
    return rounded({lo, hi}, size(a.magnitude(), b.magnitude(), c.magnitude()));
}
/// a + (b - a) * t.
inline Interval1 lerp(Interval1 a, Interval1 b, Interval1 t) {
    if (!tame(a, b, t))
        return a + (b - a) * t;
    return multilinear(
        a, b, t, [](double x, double y, double w) { return x + (y - x) * w; },
        [](double x, double y, double w) { return x + (x + y) * w; });
}

}  // namespace nephele
