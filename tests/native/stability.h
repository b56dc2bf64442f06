// SPDX-License-Identifier: GPL-3.0-or-later
// Measures how far a formula computed in single precision is from the same formula in long double (64 bits of
// mantissa), over the whole range of its arguments. Each formula is a row of docs/stability.md: the row's
// words stand with its test, its figure is what the test measured (tools/stability_page.py).
#pragma once

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "math/sampler.h"
#include "math/vec.h"

namespace nephele::stability {

using Exact = long double;
inline constexpr Exact kExactPi = 3.14159265358979323846264338327950288L;

/// A row of the page.
struct Row {
    const char* room;     ///< of the code: a folder of native/
    const char* file;     ///< in that folder
    const char* formula;  ///< what is computed
    const char* risk;     ///< what could go wrong
    const char* form;     ///< what is done instead
    const char* range;    ///< of the arguments that were tried
    const char* unit;     ///< what the error is relative to
    double bound;         ///< of the error, at most about twice of what was measured
};

/// The largest error met. At its end it holds it against the row's bound and hands the row to the page.
class Worst {
  public:
    explicit Worst(const Row& row) : row_(row), number_(next_number()) {}
    Worst(const Worst&) = delete;
    Worst& operator=(const Worst&) = delete;
    ~Worst() {
        EXPECT_GT(count_, 0) << row_.formula << ": nothing was tried";
        EXPECT_LE(worst_, row_.bound) << row_.formula << ", worst at " << where_;
        if (const char* path = std::getenv("NEPHELE_STABILITY_ROWS")) {
            std::ofstream out(path, std::ios::app);
            out << number_ << '\t' << row_.room << '\t' << row_.file << '\t' << row_.formula << '\t'
                << row_.risk << '\t' << row_.form << '\t' << row_.range << '\t' << row_.unit << '\t'
                << row_.bound << '\t' << worst_ << '\n';
        }
    }

    /// An error found at these arguments; what is not a number is infinitely wrong.
    void error(Exact e, std::initializer_list<double> at = {}) {
        ++count_;
        const double size =
            std::isnan(e) ? std::numeric_limits<double>::infinity() : static_cast<double>(std::fabs(e));
        if (size <= worst_ && count_ > 1)
            return;
        worst_ = size;
        where_.clear();
        for (const double x : at) {
            char text[32];
            std::snprintf(text, sizeof text, "%.9g ", x);
            where_ += text;
        }
    }
    /// Of a value, relative to what it should be; below the normal floats relative to the least of them.
    void relative(double got, Exact want, std::initializer_list<double> at = {}) {
        constexpr Exact kLeast = std::numeric_limits<float>::min();
        error((static_cast<Exact>(got) - want) / std::fmax(std::fabs(want), kLeast), at);
    }
    /// Of a value, relative to `scale`.
    void scaled(double got, Exact want, Exact scale, std::initializer_list<double> at = {}) {
        error((static_cast<Exact>(got) - want) / scale, at);
    }

  private:
    static int next_number() {
        static int number = 0;
        return number++;
    }

    Row row_;
    int number_;  ///< its place among the rows: of several in one test, the last ends first
    double worst_ = 0;
    long count_ = 0;
    std::string where_;
};

/// n values from low to high > 0, evenly in their logarithm, as floats.
inline std::vector<float> logarithmic(double low, double high, int n) {
    std::vector<float> out;
    for (int i = 0; i < n; ++i)
        out.push_back(static_cast<float>(low * std::pow(high / low, static_cast<double>(i) / (n - 1))));
    return out;
}
/// The same, and 1 minus each of them: probabilities and the like, to both ends.
inline std::vector<float> towards_both_ends(double low, int n) {
    std::vector<float> out = logarithmic(low, 0.5, n);
    for (int i = n; i-- > 0;)
        out.push_back(1 - out[static_cast<std::size_t>(i)]);
    return out;
}
inline std::vector<float> joined(std::vector<float> a, const std::vector<float>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

struct Exact3 {
    Exact x, y, z;
    Exact3(Exact vx, Exact vy, Exact vz) : x(vx), y(vy), z(vz) {}
    explicit Exact3(Vec3f v)
        : x(static_cast<Exact>(v.x)), y(static_cast<Exact>(v.y)), z(static_cast<Exact>(v.z)) {}
    Exact3 operator+(Exact3 o) const { return {x + o.x, y + o.y, z + o.z}; }
    Exact3 operator-(Exact3 o) const { return {x - o.x, y - o.y, z - o.z}; }
    Exact3 operator*(Exact s) const { return {x * s, y * s, z * s}; }
};
inline Exact dot(Exact3 a, Exact3 b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline Exact3 cross(Exact3 a, Exact3 b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline Exact length(Exact3 a) {
    return std::sqrt(dot(a, a));
}
inline Exact3 unit(Exact3 a) {
    return a * (1 / length(a));
}
/// Angle between two directions of any length, without cancellation.
inline Exact angle(Exact3 a, Exact3 b) {
    return std::atan2(length(cross(a, b)), dot(a, b));
}

/// A random unit vector, in floats.
inline Vec3f random_direction(Rng& rng) {
    const Exact z = 2 * static_cast<Exact>(rng.next()) - 1, s = std::sqrt(1 - z * z),
                phi = 2 * kExactPi * static_cast<Exact>(rng.next());
    return {static_cast<float>(s * std::cos(phi)), static_cast<float>(s * std::sin(phi)),
            static_cast<float>(z)};
}
/// The unit vector at this angle to z, in floats.
inline Vec3f at_angle(double theta, double phi) {
    return {static_cast<float>(std::sin(theta) * std::cos(phi)),
            static_cast<float>(std::sin(theta) * std::sin(phi)), static_cast<float>(std::cos(theta))};
}

}  // namespace nephele::stability
